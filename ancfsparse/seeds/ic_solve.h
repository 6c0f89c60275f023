/* Solves with an incomplete factor: one sweep, or conjugate gradients with sweeps and the matrix. */
#ifndef ANCF_IC_SOLVE_H
#define ANCF_IC_SOLVE_H

#include "ic.h"

/* Up to so many sweeps of a first solve one for each correction is enough. */
enum { IC_FEW = 3, IC_MOST_ROUNDS = 200 };

IC_INLINE void ic_columns(quad *out, const float *block)
{
    for (int c = 0; c < 3; ++c)
        out[c] = quad_of_singles(block + 4 * c);
}

IC_INLINE quad ic_times(const quad *block, quad x)
{
    return block[0] * x[0] + block[1] * x[1] + block[2] * x[2];
}

/* x <- (I + N)^-T D^-1 (I + N)^-1 x; the sum of r x, r being the old one. */
static double ic_sweep(ic *self, const double *r, double *restrict x)
{
    const float *factor = ic_factor_singles(self), *block = factor + IC_BLOCK * self->n_triples;
    const int64_t *start = self->start;
    const int32_t *row = self->row;
    quad sum = {0};
    for (ptrdiff_t j = 0; j < self->n_triples; ++j) {
        quad here = quad_load(x + IC_TRIPLE * j), n[3];
        for (int64_t b = start[j]; b < start[j + 1]; ++b, block += IC_BLOCK) {
            double *there = x + IC_TRIPLE * (ptrdiff_t)row[b];
            ic_columns(n, block);
            quad_store(there, quad_load(there) - ic_times(n, here));
        }
    }
    for (ptrdiff_t j = self->n_triples - 1; j >= 0; --j) {
        quad total[3] = {{0}, {0}, {0}}, n[3], d[3], here;
        for (int64_t b = start[j + 1] - 1; b >= start[j]; --b) {
            quad there = quad_load(x + IC_TRIPLE * (ptrdiff_t)row[b]);
            block -= IC_BLOCK;
            ic_columns(n, block);
            for (int c = 0; c < 3; ++c)
                total[c] += n[c] * there;
        }
        ic_columns(d, factor + IC_BLOCK * j);
        here = ic_times(d, quad_load(x + IC_TRIPLE * j)) - quad_sums(total[0], total[1], total[2]);
        quad_store(x + IC_TRIPLE * j, here);
        if (r != NULL)
            sum += here * quad_load(r + IC_TRIPLE * j);
    }
    ++self->sweeps;
    return quad_sum(sum);
}

/* y = A x; x.y */
static double ic_product(ic *self, const double *x, double *restrict y)
{
    const float *matrix = ic_matrix_singles(self), *block = matrix + IC_BLOCK * self->n_triples;
    const int32_t *row = self->row;
    quad sum = {0};
    memset(y, 0, IC_TRIPLE * self->n_triples * sizeof(double));
    for (ptrdiff_t j = 0; j < self->n_triples; ++j) {
        quad here = quad_load(x + IC_TRIPLE * j), a[3], total[3] = {{0}, {0}, {0}}, out;
        for (int64_t b = self->start[j]; b < self->start[j + 1]; ++b, block += IC_BLOCK) {
            double *to = y + IC_TRIPLE * (ptrdiff_t)row[b];
            quad there = quad_load(x + IC_TRIPLE * (ptrdiff_t)row[b]);
            ic_columns(a, block);
            quad_store(to, quad_load(to) + ic_times(a, here));
            for (int c = 0; c < 3; ++c)
                total[c] += a[c] * there;
        }
        ic_columns(a, matrix + IC_BLOCK * j);
        out = quad_load(y + IC_TRIPLE * j) + ic_times(a, here) +
              quad_sums(total[0], total[1], total[2]);
        quad_store(y + IC_TRIPLE * j, out);
        sum += here * out;
    }
    ++self->products;
    return quad_sum(sum);
}

/* out += a x */
IC_INLINE void ic_add(const ic *self, double *restrict out, double a, const double *x)
{
    for (ptrdiff_t k = 0; k < IC_TRIPLE * self->n_triples; k += 4)
        quad_store(out + k, quad_load(out + k) + a * quad_load(x + k));
}

/* Conjugate gradients from x = 0, until z.r has come down by share^2; how many rounds.  Where A curves
 * the wrong way they end with what there is. */
static ptrdiff_t ic_conjugate(ic *self, double share, ptrdiff_t most)
{
    size_t bytes = IC_TRIPLE * self->n_triples * sizeof(double);
    double *x = self->x, *r = self->r, *z = self->z, *p = self->p;
    double zr, first, last;
    ptrdiff_t k = 0;
    memset(x, 0, bytes);
    memcpy(z, r, bytes);
    zr = first = ic_sweep(self, r, z);
    memcpy(p, z, bytes);
    while (k < most) {
        double curvature = ic_product(self, p, z);
        if (!(curvature > 0.0)) { /* a NaN ends here too */
            if (k == 0)
                memcpy(x, p, bytes);
            break;
        }
        ++k;
        ic_add(self, x, zr / curvature, p);
        ic_add(self, r, -zr / curvature, z);
        memcpy(z, r, bytes);
        last = zr;
        zr = ic_sweep(self, r, z);
        if (!(zr > share * share * first))
            break;
        for (ptrdiff_t i = 0; i < IC_TRIPLE * self->n_triples; i += 4)
            quad_store(p + i, quad_load(z + i) + zr / last * quad_load(p + i));
    }
    self->extra += k * self->per_round;
    return k;
}

static void ic_gather(const ic *self, const double *r, double *out)
{
    for (ptrdiff_t t = 0; t < self->n_triples; ++t) {
        const int32_t *at = self->unknown + 3 * t;
        for (int k = 0; k < 3; ++k)
            out[IC_TRIPLE * t + k] = at[k] < 0 ? 0.0 : r[at[k]] * self->scale[at[k]];
    }
}

static void ic_scatter(const ic *self, const double *x, double *out)
{
    for (ptrdiff_t t = 0; t < self->n_triples; ++t) {
        const int32_t *at = self->unknown + 3 * t;
        for (int k = 0; k < 3; ++k)
            if (at[k] >= 0)
                out[at[k]] = x[IC_TRIPLE * t + k] * self->scale[at[k]];
    }
}

static void ic_solve(void *context, const double *r, double *x)
{
    ic *self = context;
    if (self->mode == IC_PLAIN) {
        ic_gather(self, r, self->x);
        ic_sweep(self, NULL, self->x);
    } else {
        ic_gather(self, r, self->r);
        ptrdiff_t rounds = ic_conjugate(self, self->share, IC_MOST_ROUNDS);
        if (self->mode == IC_PROBE)
            self->mode = rounds + 1 <= IC_FEW ? IC_PLAIN : IC_INNER;
    }
    ic_scatter(self, self->x, x);
}

/* Leave no more than a share of the residual from now on, until the next factor; whether that is new. */
static int ic_refine(void *context, double share)
{
    ic *self = context;
    if (self->mode != IC_PLAIN && self->share <= share)
        return 0;
    self->mode = IC_INNER;
    self->share = share;
    return 1;
}

#endif
