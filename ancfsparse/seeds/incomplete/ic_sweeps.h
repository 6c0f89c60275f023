/* Sweeps through an incomplete factor, and products with its matrix, in single precision. */
#ifndef ANCF_IC_SWEEPS_H
#define ANCF_IC_SWEEPS_H

#include "ic.h"

/* Prefetch distance, 30 blocks: hardware prefetching stops at page boundaries. */
enum { IC_FAR = 30 * IC_BLOCK };

IC_INLINE short_quad ic_get(const float *p) { return *(const short_quad *)p; }
IC_INLINE void ic_put(float *p, short_quad v) { *(short_quad *)p = v; }

/* Clear the fourth number, which belongs to the next column of the block. */
IC_INLINE short_quad ic_three(short_quad v)
{
    return (short_quad)((ic_mask)v & (ic_mask){-1, -1, -1, 0});
}

IC_INLINE void ic_columns(short_quad *out, const float *block)
{
    for (int c = 0; c < 3; ++c)
        out[c] = ic_get(block + 3 * c);
}

IC_INLINE short_quad ic_times(const short_quad *block, short_quad x)
{
    return block[0] * x[0] + block[1] * x[1] + block[2] * x[2];
}

/* (sum of a, sum of b, sum of c, 0); the fourth numbers must be zero */
IC_INLINE short_quad ic_sums(short_quad a, short_quad b, short_quad c)
{
    const short_quad zero = {0};
    short_quad ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) +
                    __builtin_shufflevector(a, b, 1, 5, 3, 7);
    short_quad c0 = __builtin_shufflevector(c, zero, 0, 4, 2, 6) +
                    __builtin_shufflevector(c, zero, 1, 5, 3, 7);
    return __builtin_shufflevector(ab, c0, 0, 1, 4, 5) +
           __builtin_shufflevector(ab, c0, 2, 3, 6, 7);
}

IC_INLINE quad ic_products(short_quad a, short_quad b)
{
    return quad_of_singles((const float *)&a) * quad_of_singles((const float *)&b);
}

/* x <- (I + N)^-1 x */
static void ic_forward(void *context, ptrdiff_t front)
{
    const ic *self = context;
    float *x = self->to;
    ptrdiff_t j = self->first[front], end = self->first[front + 1];
    const int32_t *start = self->start, *row = self->row;
    const float *block = ic_factor_singles(self) + IC_BLOCK * (self->n_triples + start[j]);
    for (; j < end; ++j) {
        short_quad here = ic_get(x + IC_TRIPLE * j), n[3];
        for (ptrdiff_t b = start[j]; b < start[j + 1]; ++b, block += IC_BLOCK) {
            float *there = x + IC_TRIPLE * (ptrdiff_t)row[b];
            __builtin_prefetch(block + IC_FAR);
            ic_columns(n, block);
            ic_put(there, ic_get(there) - ic_three(ic_times(n, here)));
        }
    }
}

/* x <- (I + N)^-T D^-1 x; and r.x if r is given */
static void ic_backward(void *context, ptrdiff_t front)
{
    ic *self = context;
    const float *factor = ic_factor_singles(self), *r = self->of;
    float *x = self->to;
    ptrdiff_t first = self->first[front], j = self->first[front + 1];
    const int32_t *start = self->start, *row = self->row;
    const float *block = factor + IC_BLOCK * (self->n_triples + start[j]);
    quad sum = {0};
    while (--j >= first) {
        short_quad total[3] = {{0}, {0}, {0}}, n[3], d[3], here;
        for (ptrdiff_t b = start[j + 1] - 1; b >= start[j]; --b) {
            short_quad there = ic_get(x + IC_TRIPLE * (ptrdiff_t)row[b]);
            block -= IC_BLOCK;
            __builtin_prefetch(block - IC_FAR);
            ic_columns(n, block);
            for (int c = 0; c < 3; ++c)
                total[c] += n[c] * there;
        }
        ic_columns(d, factor + IC_BLOCK * j);
        here = ic_three(ic_times(d, ic_get(x + IC_TRIPLE * j))) -
               ic_sums(total[0], total[1], total[2]);
        ic_put(x + IC_TRIPLE * j, here);
        if (r != NULL)
            sum += ic_products(here, ic_get(r + IC_TRIPLE * j));
    }
    self->sum[front] = quad_sum(sum);
}

/* Operations on the image of the middle: clear it, add it to the middle, copy the middle to it. */
static void ic_clear_image(const ic *self, float *x)
{
    memset(x + IC_TRIPLE * self->n_triples, 0, IC_TRIPLE * ic_width(self) * sizeof(float));
}

static void ic_add_image(const ic *self, float *x)
{
    const float *image = x + IC_TRIPLE * self->n_triples;
    float *middle = x + IC_TRIPLE * self->first[IC_MIDDLE];
    for (ptrdiff_t k = 0; k < IC_TRIPLE * ic_width(self); ++k)
        middle[k] += image[k];
}

static void ic_set_image(const ic *self, float *x)
{
    memcpy(x + IC_TRIPLE * self->n_triples, x + IC_TRIPLE * self->first[IC_MIDDLE],
           IC_TRIPLE * ic_width(self) * sizeof(float));
}

static double ic_sum(const ic *self)
{
    return self->sum[0] + self->sum[1] + self->sum[IC_MIDDLE];
}

/* x <- (I + N)^-T D^-1 (I + N)^-1 x; returns r.x, where r is the previous x. */
static double ic_sweep(ic *self, const float *r, float *x)
{
    self->of = r, self->to = x;
    ic_clear_image(self, x);
    ic_on_fronts(self, ic_forward);
    ic_add_image(self, x);
    ic_forward(self, IC_MIDDLE);
    ic_backward(self, IC_MIDDLE);
    ic_set_image(self, x);
    ic_on_fronts(self, ic_backward);
    ++self->sweeps;
    return ic_sum(self);
}

/* to = of, without the images */
static void ic_copy(void *context, ptrdiff_t front)
{
    const ic *self = context;
    ptrdiff_t begin = IC_TRIPLE * self->first[front], end = IC_TRIPLE * ic_end(self, front);
    memcpy(self->to + begin, self->of + begin, (end - begin) * sizeof(float));
}

static void ic_copy_all(ic *self, const float *of, float *to)
{
    self->of = of, self->to = to;
    ic_on_fronts(self, ic_copy);
}

/* r -= w */
static void ic_leave(void *context, ptrdiff_t front)
{
    const ic *self = context;
    ptrdiff_t end = IC_TRIPLE * ic_end(self, front);
    for (ptrdiff_t k = IC_TRIPLE * self->first[front]; k < end; k += 4)
        ic_put(self->r + k, ic_get(self->r + k) - ic_get(self->w + k));
}

/* y += A x for a front or the middle; and x.y */
static void ic_multiply(void *context, ptrdiff_t front)
{
    ic *self = context;
    const float *matrix = ic_matrix_singles(self), *x = self->of;
    float *y = self->to;
    ptrdiff_t j = self->first[front], end = self->first[front + 1];
    const int32_t *start = self->start, *row = self->row;
    const float *block = matrix + IC_BLOCK * (self->n_triples + start[j]);
    quad sum = {0};
    if (front != IC_MIDDLE)
        memset(y + IC_TRIPLE * j, 0, IC_TRIPLE * (end - j) * sizeof(float));
    for (; j < end; ++j) {
        short_quad here = ic_get(x + IC_TRIPLE * j), a[3], total[3] = {{0}, {0}, {0}}, out;
        for (ptrdiff_t b = start[j]; b < start[j + 1]; ++b, block += IC_BLOCK) {
            float *to = y + IC_TRIPLE * (ptrdiff_t)row[b];
            short_quad there = ic_get(x + IC_TRIPLE * (ptrdiff_t)row[b]);
            __builtin_prefetch(block + IC_FAR);
            ic_columns(a, block);
            ic_put(to, ic_get(to) + ic_three(ic_times(a, here)));
            for (int c = 0; c < 3; ++c)
                total[c] += a[c] * there;
        }
        ic_columns(a, matrix + IC_BLOCK * j);
        out = ic_get(y + IC_TRIPLE * j) + ic_three(ic_times(a, here)) +
              ic_sums(total[0], total[1], total[2]);
        ic_put(y + IC_TRIPLE * j, out);
        sum += ic_products(here, out);
    }
    self->sum[front] = quad_sum(sum);
}

/* y = A x; returns x.y. */
static double ic_product(ic *self, float *x, float *y)
{
    ptrdiff_t middle = self->first[IC_MIDDLE];
    self->of = x, self->to = y;
    ic_set_image(self, x);
    memset(y + IC_TRIPLE * middle, 0, 2 * IC_TRIPLE * ic_width(self) * sizeof(float));
    ic_on_fronts(self, ic_multiply);
    ic_add_image(self, y);
    ic_multiply(self, IC_MIDDLE);
    ++self->products;
    return ic_sum(self);
}

#endif
