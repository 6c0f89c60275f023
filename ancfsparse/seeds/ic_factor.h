/* Incomplete elimination, column of blocks by column of blocks. */
#ifndef ANCF_IC_FACTOR_H
#define ANCF_IC_FACTOR_H

#include "ic.h"

/* What is first added to the diagonal where elimination breaks down, and how often that is doubled. */
#define IC_SHIFT 1e-3
enum { IC_MOST_SHIFTS = 30 };

static void ic_find_scale(ic *self, const double *values)
{
    for (ptrdiff_t j = 0; j < self->n; ++j) {
        int power = 0;
        frexp(values[self->indptr[j]], &power);
        self->scale[j] = ldexp(1.0, -power / 2);
    }
}

/* A, scaled, into the blocks; its diagonal, which is near one, enlarged. */
static void ic_spread(const ic *self, const double *values, double shift)
{
    memset(self->blocks, 0, IC_BLOCK * self->n_blocks * sizeof(double));
    for (ptrdiff_t j = 0; j < self->n; ++j) {
        int64_t p = self->indptr[j];
        double scale = self->scale[j];
        self->blocks[self->place_of_entry[p]] = values[p] * scale * scale + shift;
        for (++p; p < self->indptr[j + 1]; ++p)
            self->blocks[self->place_of_entry[p]] = values[p] * scale * self->scale[self->indices[p]];
    }
    for (ptrdiff_t t = 0; t < self->n_triples; ++t)
        for (int k = 0; k < 3; ++k)
            if (self->unknown[3 * t + k] < 0)
                self->blocks[IC_BLOCK * t + 5 * k] = 1.0;
}

/* Invert a block of the diagonal, of which the lower triangle is read; 0, or 1 + the first lane whose
 * pivot is not positive. */
IC_INLINE int ic_invert(double *d)
{
    double d0 = d[0], l1 = d[1] / d0, l2 = d[2] / d0;
    double d1 = d[5] - l1 * d[1], u = d[6] - l1 * d[2], l = u / d1;
    double d2 = d[10] - l2 * d[2] - l * u, m = l1 * l - l2;
    if (!(d0 > 0.0 && d0 < INFINITY)) /* a NaN ends here too */
        return 1;
    if (!(d1 > 0.0 && d1 < INFINITY))
        return 2;
    if (!(d2 > 0.0 && d2 < INFINITY))
        return 3;
    double i0 = 1.0 / d0, i1 = 1.0 / d1, i2 = 1.0 / d2;
    d[0] = i0 + l1 * l1 * i1 + m * m * i2;
    d[1] = d[4] = -l1 * i1 - l * m * i2;
    d[2] = d[8] = m * i2;
    d[5] = i1 + l * l * i2;
    d[6] = d[9] = -l * i2;
    d[10] = i2;
    return 0;
}

/* out -= n b^T */
IC_INLINE void ic_subtract_product(double *out, const quad *n, const double *b)
{
    for (int c = 0; c < 3; ++c)
        quad_store(out + 4 * c, quad_load(out + 4 * c) -
                                    (n[0] * b[c] + n[1] * b[4 + c] + n[2] * b[8 + c]));
}

IC_INLINE void ic_load(quad *out, const double *block)
{
    for (int c = 0; c < 3; ++c)
        out[c] = quad_load(block + 4 * c);
}

/* Eliminate; 0, or 1 + the first unknown whose pivot is not positive. */
static ptrdiff_t ic_eliminate(const ic *self)
{
    double *below = self->blocks + IC_BLOCK * self->n_triples, *column = self->column;
    for (ptrdiff_t j = 0; j < self->n_triples; ++j) {
        double *pivot = self->blocks + IC_BLOCK * j;
        int64_t begin = self->start[j], end = self->start[j + 1];
        int bad = ic_invert(pivot);
        if (bad)
            return 1 + (self->unknown[3 * j + bad - 1] < 0 ? 0 : self->unknown[3 * j + bad - 1]);
        memcpy(column, below + IC_BLOCK * begin, IC_BLOCK * (end - begin) * sizeof(double));
        for (int64_t b = begin; b < end; ++b) {
            quad old[3];
            ic_load(old, below + IC_BLOCK * b);
            for (int c = 0; c < 3; ++c)
                quad_store(below + IC_BLOCK * b + 4 * c, old[0] * pivot[4 * c] +
                                                             old[1] * pivot[4 * c + 1] +
                                                             old[2] * pivot[4 * c + 2]);
        }
        for (int64_t b = begin; b < end; ++b) {
            const double *held = column + IC_BLOCK * (b - begin);
            ptrdiff_t k = self->row[b];
            int64_t at = self->start[k], last = self->start[k + 1];
            quad n[3];
            ic_load(n, below + IC_BLOCK * b);
            ic_subtract_product(self->blocks + IC_BLOCK * k, n, held);
            for (int64_t i = b + 1; i < end; ++i) {
                while (at < last && self->row[at] < self->row[i])
                    ++at;
                if (at == last)
                    break;
                if (self->row[at] != self->row[i])
                    continue; /* dropped */
                ic_load(n, below + IC_BLOCK * i);
                ic_subtract_product(below + IC_BLOCK * at, n, held);
            }
        }
    }
    return 0;
}

/* Round the factor, and write A beside it. */
static void ic_round(const ic *self, const double *values)
{
    float *factor = ic_factor_singles(self), *matrix = ic_matrix_singles(self);
    for (ptrdiff_t b = 0; b < self->n_blocks; ++b) {
        quad block[3];
        ic_load(block, self->blocks + IC_BLOCK * b);
        for (int c = 0; c < 3; ++c)
            quad_to_singles(factor + IC_BLOCK * b + 4 * c, block[c]);
    }
    memset(matrix, 0, IC_BLOCK * self->n_blocks * sizeof(float));
    for (ptrdiff_t j = 0; j < self->n; ++j)
        for (int64_t p = self->indptr[j]; p < self->indptr[j + 1]; ++p)
            matrix[self->place_of_entry[p]] =
                (float)(values[p] * self->scale[j] * self->scale[self->indices[p]]);
    for (ptrdiff_t t = 0; t < self->n_triples; ++t) {
        float *d = matrix + IC_BLOCK * t;
        d[4] = d[1];
        d[8] = d[2];
        d[9] = d[6];
    }
}

/* Make solves give no numbers, since there is no factor. */
static void ic_spoil(const ic *self)
{
    float *factor = ic_factor_singles(self), *matrix = ic_matrix_singles(self);
    for (ptrdiff_t k = 0; k < IC_BLOCK * self->n_blocks; ++k)
        factor[k] = matrix[k] = NAN;
}

static ptrdiff_t ic_factor_shifted(ic *self, const double *values, double shift)
{
    ptrdiff_t bad;
    ic_find_scale(self, values);
    ic_spread(self, values, shift);
    bad = ic_eliminate(self);
    if (bad == 0)
        ic_round(self, values);
    self->mode = IC_PROBE;
    self->share = IC_LOOSE;
    return bad;
}

/* Factor the values; 0, or 1 + the first unknown whose pivot is not positive, and then no factor. */
static ptrdiff_t ic_factor(void *context, const double *values)
{
    ptrdiff_t bad = ic_factor_shifted(context, values, 0.0);
    if (bad)
        ic_spoil(context);
    return bad;
}

/* Factor a neighbour of the values, whose diagonal is as much larger as it must be; whether there is
 * one.  Conjugate gradients go on with the values themselves. */
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
