/* Incomplete elimination by block columns. */
#ifndef ANCF_IC_FACTOR_H
#define ANCF_IC_FACTOR_H

#include "ic_border.h"
#include "ic_coarse.h"

/* Initial shift of the diagonal if elimination breaks down, and how often it may be doubled. */
#define IC_SHIFT 1e-3
enum { IC_MOST_SHIFTS = 30 };

typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));

IC_INLINE void ic_store(double *p, quad v)
{
    *(pair *)p = (pair){v[0], v[1]};
    p[2] = v[2];
}

IC_INLINE void ic_load(quad *out, const double *block)
{
    for (int c = 0; c < 3; ++c)
        out[c] = quad_load(block + 3 * c);
}

static void ic_find_scale(void *context, ptrdiff_t front)
{
    const ic *self = context;
    ptrdiff_t end = self->n * (front + 1) / IC_FRONTS;
    for (ptrdiff_t j = self->n * front / IC_FRONTS; j < end; ++j) {
        int power = 0;
        frexp(self->values[self->indptr[j]], &power);
        self->scale[j] = ldexp(1.0, -power / 2);
    }
}

/* Copy A, scaled, into cleared blocks, with its diagonal, which is near one, increased by the shift. */
static void ic_spread(void *context, ptrdiff_t front)
{
    const ic *self = context;
    const double *values = self->values;
    ptrdiff_t end = self->n * (front + 1) / IC_FRONTS;
    for (ptrdiff_t j = self->n * front / IC_FRONTS; j < end; ++j) {
        int64_t p = self->indptr[j];
        double scale = self->scale[j];
        self->blocks[self->place_of_entry[p]] = values[p] * scale * scale + self->shift;
        for (++p; p < self->indptr[j + 1]; ++p)
            self->blocks[self->place_of_entry[p]] = values[p] * scale * self->scale[self->indices[p]];
    }
    for (ptrdiff_t t = self->first[front]; t < ic_end(self, front); ++t)
        for (int k = 0; k < 3; ++k) {
            int32_t at = self->unknown[3 * t + k];
            if (at < 0)
                self->blocks[IC_BLOCK * t + 4 * k] = 1.0;
            else
                self->scale_of[3 * t + k] = self->scale[at];
        }
}

/* Clear the blocks of a front; for the second front, also the image. */
static void ic_clear(void *context, ptrdiff_t front)
{
    const ic *self = context;
    ptrdiff_t half = self->n_blocks / 2, begin = front ? half : 0;
    ptrdiff_t image = ic_width(self) + self->start[self->n_triples] - self->start[self->first[IC_MIDDLE]];
    ptrdiff_t end = front ? self->n_blocks + image : half;
    memset(self->blocks + IC_BLOCK * begin, 0, IC_BLOCK * (end - begin) * sizeof(double));
}

/* Invert a diagonal block, of which the lower triangle is read; returns 0, or 1 + the first lane whose
 * pivot is not positive. */
IC_INLINE int ic_invert(double *d)
{
    double d0 = d[0], l1 = d[1] / d0, l2 = d[2] / d0;
    double d1 = d[4] - l1 * d[1], u = d[5] - l1 * d[2], l = u / d1;
    double d2 = d[8] - l2 * d[2] - l * u, m = l1 * l - l2;
    if (!(d0 > 0.0 && d0 < INFINITY)) /* true for NaN */
        return 1;
    if (!(d1 > 0.0 && d1 < INFINITY))
        return 2;
    if (!(d2 > 0.0 && d2 < INFINITY))
        return 3;
    double i0 = 1.0 / d0, i1 = 1.0 / d1, i2 = 1.0 / d2;
    d[0] = i0 + l1 * l1 * i1 + m * m * i2;
    d[1] = d[3] = -l1 * i1 - l * m * i2;
    d[2] = d[6] = m * i2;
    d[4] = i1 + l * l * i2;
    d[5] = d[7] = -l * i2;
    d[8] = i2;
    return 0;
}

/* out -= n b^T */
IC_INLINE void ic_subtract_product(double *out, const quad *n, const double *b)
{
    for (int c = 0; c < 3; ++c)
        ic_store(out + 3 * c,
                 quad_load(out + 3 * c) - (n[0] * b[c] + n[1] * b[3 + c] + n[2] * b[6 + c]));
}

/* Eliminate a front or the middle; the outcome is 0, or 1 + the first unknown with a nonpositive pivot. */
static void ic_eliminate(void *context, ptrdiff_t front)
{
    ic *self = context;
    ptrdiff_t middle = self->first[IC_MIDDLE], width = ic_width(self);
    double *blocks = self->blocks, *below = blocks + IC_BLOCK * self->n_triples;
    double *column = self->column + (front % IC_FRONTS) * (IC_BLOCK * self->longest + IC_PAST);
    /* Offset of the blocks of the middle, as this front addresses them. */
    ptrdiff_t on = front == 1 ? self->n_blocks - middle : 0;
    ptrdiff_t off =
        front == 1 ? self->n_blocks + width - self->n_triples - self->start[middle] : 0;
    for (ptrdiff_t j = self->first[front]; j < self->first[front + 1]; ++j) {
        double *pivot = blocks + IC_BLOCK * j;
        ptrdiff_t begin = self->start[j], end = self->start[j + 1];
        int bad = ic_invert(pivot);
        if (bad) {
            self->bad[front] =
                1 + (self->unknown[3 * j + bad - 1] < 0 ? 0 : self->unknown[3 * j + bad - 1]);
            return;
        }
        memcpy(column, below + IC_BLOCK * begin, IC_BLOCK * (end - begin) * sizeof(double));
        for (ptrdiff_t b = begin; b < end; ++b) {
            quad old[3];
            ic_load(old, below + IC_BLOCK * b);
            for (int c = 0; c < 3; ++c)
                ic_store(below + IC_BLOCK * b + 3 * c, old[0] * pivot[3 * c] +
                                                           old[1] * pivot[3 * c + 1] +
                                                           old[2] * pivot[3 * c + 2]);
        }
        for (ptrdiff_t b = begin; b < end; ++b) {
            const double *held = column + IC_BLOCK * (b - begin);
            ptrdiff_t k = self->row[b], to, here;
            if (k >= self->n_triples)
                k -= width;
            here = k >= middle;
            to = self->row[b] - k; /* offset from the rows of the middle to those of the image */
            ptrdiff_t at = self->start[k], last = self->start[k + 1];
            quad n[3];
            ic_load(n, below + IC_BLOCK * b);
            ic_subtract_product(blocks + IC_BLOCK * (k + (here ? on : 0)), n, held);
            for (ptrdiff_t i = b + 1; i < end; ++i) {
                ptrdiff_t row = self->row[i] - to;
                while (at < last && self->row[at] < row)
                    ++at;
                if (at == last)
                    break;
                if (self->row[at] != row)
                    continue; /* fill-in is dropped */
                ic_load(n, below + IC_BLOCK * i);
                ic_subtract_product(below + IC_BLOCK * (at + (here ? off : 0)), n, held);
            }
        }
    }
}

/* Add the image to the middle. */
static void ic_join(const ic *self)
{
    ptrdiff_t middle = self->first[IC_MIDDLE], width = ic_width(self);
    const double *image = self->blocks + IC_BLOCK * self->n_blocks;
    double *on = self->blocks + IC_BLOCK * middle;
    double *below = self->blocks + IC_BLOCK * (self->n_triples + self->start[middle]);
    ptrdiff_t n_below = self->start[self->n_triples] - self->start[middle];
    for (ptrdiff_t k = 0; k < IC_BLOCK * width; ++k)
        on[k] += image[k];
    for (ptrdiff_t k = 0; k < IC_BLOCK * n_below; ++k)
        below[k] += image[IC_BLOCK * width + k];
}

/* Round the factor in place, in ascending order: it moves to the first half of its memory. */
static void ic_round(const ic *self)
{
    float *factor = ic_factor_singles(self);
    for (ptrdiff_t b = 0; b < self->n_blocks; ++b) {
        quad block[3];
        ic_load(block, self->blocks + IC_BLOCK * b);
        for (int c = 0; c < 3; ++c)
            quad_to_singles(factor + IC_BLOCK * b + 3 * c, block[c]);
    }
}

/* Clear the room behind the factor. */
static void ic_clear_matrix(void *context, ptrdiff_t front)
{
    const ic *self = context;
    ptrdiff_t all = IC_BLOCK * self->n_blocks + IC_PAST, half = all / IC_FRONTS;
    memset(ic_matrix_singles(self) + (front ? half : 0), 0, (front ? all - half : half) * sizeof(float));
}

/* Store A in single precision. */
static void ic_spread_singles(void *context, ptrdiff_t front)
{
    const ic *self = context;
    float *matrix = ic_matrix_singles(self);
    ptrdiff_t end = self->n * (front + 1) / IC_FRONTS;
    for (ptrdiff_t j = self->n * front / IC_FRONTS; j < end; ++j)
        for (int64_t p = self->indptr[j]; p < self->indptr[j + 1]; ++p)
            matrix[self->place_of_entry[p]] =
                (float)(self->values[p] * self->scale[j] * self->scale[self->indices[p]]);
}

/* Fill the upper triangles of diagonal blocks. */
static void ic_mirror(void *context, ptrdiff_t front)
{
    const ic *self = context;
    for (ptrdiff_t t = self->first[front]; t < ic_end(self, front); ++t) {
        float *d = ic_matrix_singles(self) + IC_BLOCK * t;
        d[3] = d[1];
        d[6] = d[2];
        d[7] = d[5];
    }
}

/* Make solves return NaN, since there is no factor. */
static void ic_spoil(const ic *self)
{
    float *factor = ic_factor_singles(self), *matrix = ic_matrix_singles(self);
    for (ptrdiff_t k = 0; k < IC_BLOCK * self->n_blocks; ++k)
        factor[k] = matrix[k] = NAN;
}

static ptrdiff_t ic_factor_shifted(ic *self, const double *values, double shift)
{
    self->values = values, self->shift = shift;
    self->slides = 0;
    memset(self->bad, 0, sizeof(self->bad));
    ic_on_fronts(self, ic_find_scale);
    ic_on_fronts(self, ic_clear);
    ic_on_fronts(self, ic_spread);
    ic_on_fronts(self, ic_eliminate);
    self->mode = IC_PROBE;
    self->share = IC_LOOSE;
    for (ptrdiff_t front = 0; front < IC_FRONTS; ++front)
        if (self->bad[front])
            return self->bad[front];
    ic_join(self);
    ic_eliminate(self, IC_MIDDLE);
    if (self->bad[IC_MIDDLE])
        return self->bad[IC_MIDDLE];
    ic_round(self);
    ic_on_fronts(self, ic_clear_matrix);
    ic_on_fronts(self, ic_spread_singles);
    ic_on_fronts(self, ic_mirror);
    self->slides = self->use == IC_KEPT && ic_find_modes(self);
    if (ic_is_sticking(self))
        ic_find_border(self);
    return 0;
}

/* Factor the values; returns 0, or 1 + the first unknown whose pivot is not positive (no factor). */
static ptrdiff_t ic_factor(void *context, const double *values)
{
    ptrdiff_t bad = ic_factor_shifted(context, values, 0.0);
    if (bad)
        ic_spoil(context);
    return bad;
}

/* Factor the values with a diagonal increased until that succeeds; returns 1 if it did.
 * Conjugate gradients still use the values themselves. */
static int ic_mend(void *context, const double *values)
{
    double shift = IC_SHIFT;
    for (int k = 0; k < IC_MOST_SHIFTS; ++k, shift *= 2.0)
        if (ic_factor_shifted(context, values, shift) == 0)
            return 1;
    ic_spoil(context);
    return 0;
}

#endif
