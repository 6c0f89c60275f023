/* Elimination, supernode by supernode: each, once inverted, updates those that its rows belong to. */
#ifndef ANCF_LDL_FACTOR_H
#define ANCF_LDL_FACTOR_H

#include <math.h>
#include <string.h>

#include "ldl.h"
#include "ldl_spread.h"
#include "parallel.h"
#include "simd.h"

/* Numbers of working space for a supernode: inverse, one row of it, rows transposed, products. */
static inline ptrdiff_t ldl_space(ptrdiff_t width, ptrdiff_t n_rows)
{
    ptrdiff_t stride = ldl_stride(n_rows);
    return width * width + width + width * stride + stride + 4 * LDL_SLACK;
}

/* product[k] = sum over c of g[c] b[c * stride + k], for k < n; up to LDL_SLACK more are read and written. */
LDL_INLINE void ldl_products(const double *restrict g, ptrdiff_t width, const double *restrict b,
                             ptrdiff_t stride, ptrdiff_t n, double *restrict product)
{
    ptrdiff_t k = 0;
    if (!__builtin_constant_p(width))
        for (; k + 4 < n; k += 2 * ANCF_LANES) {
            vec first = g[0] * vec_load(b + k), second = g[0] * vec_load(b + k + ANCF_LANES);
            for (ptrdiff_t c = 1; c < width; ++c) {
                first += g[c] * vec_load(b + c * stride + k);
                second += g[c] * vec_load(b + c * stride + k + ANCF_LANES);
            }
            *(vec *)(product + k) = first;
            *(vec *)(product + k + ANCF_LANES) = second;
        }
    for (; k < n; k += 4) {
        quad total = g[0] * quad_load(b + k);
        for (ptrdiff_t c = 1; c < width; ++c)
            total += g[c] * quad_load(b + c * stride + k);
        quad_store(product + k, total);
    }
}

/* Invert the block P of a supernode into `inverse`, full; 0, 1 + the first unknown whose pivot has the
 * wrong sign, or minus that where the pivot is none.
 *
 * The sweep operator (Goodnight 1979): after all columns are swept, -P^-1 has taken the place of P.
 * Its pivots are those of L D L^T. */
LDL_INLINE ptrdiff_t ldl_invert(const ldl *self, ptrdiff_t s, ptrdiff_t width,
                                double *restrict inverse, double *restrict held)
{
    const int32_t *permutation = self->permutation + self->first[s];
    double *restrict diagonal = self->diagonal + self->first[s];
    double *restrict triangle = self->triangle + self->triangle_start[s];
    double *entry = triangle;
    ptrdiff_t bad = 0;
    for (ptrdiff_t i = 0; i < width; ++i) {
        for (ptrdiff_t k = 0; k < i; ++k)
            inverse[i * width + k] = inverse[k * width + i] = *entry++;
        inverse[i * width + i] = diagonal[i];
    }
    for (ptrdiff_t k = 0; k < width; ++k) {
        double pivot = inverse[k * width + k], over = 1.0 / pivot;
        double sign = permutation[k] < self->n_positive ? 1.0 : -1.0;
        if (!(pivot * sign > 0.0 && pivot * sign < INFINITY)) { /* a NaN ends here too */
            if (bad == 0)
                bad = 1 + permutation[k];
            if (pivot == 0.0 || !isfinite(pivot))
                return -bad;
        }
        for (ptrdiff_t j = 0; j < width; ++j)
            held[j] = inverse[k * width + j];
        for (ptrdiff_t i = 0; i < width; ++i) {
            double factor = held[i] * over;
            ldl_subtract(inverse + i * width, factor, held, width);
            inverse[i * width + k] = factor;
        }
        for (ptrdiff_t j = 0; j < width; ++j)
            inverse[k * width + j] = held[j] * over;
        inverse[k * width + k] = -over;
    }
    for (ptrdiff_t i = 0; i < width * width; ++i)
        inverse[i] = -inverse[i];
    entry = triangle;
    for (ptrdiff_t i = 0; i < width; ++i) {
        for (ptrdiff_t k = 0; k < i; ++k)
            *entry++ = inverse[i * width + k];
        diagonal[i] = inverse[i * width + i];
    }
    return bad;
}

/* Subtract what supernode s gives to the columns of its rows r to end; `b` are its rows, transposed.
 * These rows are numbered from `shift` on: zero, or where the image of the root is. */
LDL_INLINE void ldl_update(const ldl *self, ptrdiff_t s, ptrdiff_t width, ptrdiff_t r, ptrdiff_t end,
                           ptrdiff_t shift, const double *b, double *product)
{
    const double *block = self->block + self->block_start[s];
    const int32_t *row = self->row + self->row_start[s];
    ptrdiff_t n_rows = ldl_rows(self, s), stride = ldl_stride(n_rows);
    while (r < end) {
        /* The rows up to `behind` are columns of supernode t. */
        ptrdiff_t t = self->super_of[row[r] - shift], first = self->first[t] + shift, behind = r + 1;
        while (behind < end && row[behind] < self->first[t + 1] + shift)
            ++behind;
        const int32_t *to = self->row + self->row_start[t];
        double *target = self->block + self->block_start[t];
        for (ptrdiff_t i = r; i < n_rows; ++i) {
            ptrdiff_t n = i < behind ? i - r : behind - r;
            double *out;
            ldl_products(block + i * width, width, b + r, stride, i < behind ? n + 1 : n, product);
            if (i < behind) {
                ptrdiff_t a = row[i] - first;
                out = self->triangle + self->triangle_start[t] + a * (a - 1) / 2;
                self->diagonal[self->first[t] + a] -= product[n];
            } else {
                while (*to != row[i] - shift) {
                    ++to;
                    target += ldl_width(self, t);
                }
                out = target;
            }
            for (ptrdiff_t k = 0; k < n; ++k)
                out[row[r + k] - first] -= product[k];
        }
        r = behind;
    }
}

/* Eliminate a supernode and update its part; return as `ldl_invert` does.  What it has for the root, if
 * anything, is kept: the root comes later, from one thread.  In the root itself there are only such rows. */
LDL_INLINE ptrdiff_t ldl_eliminate(const ldl *self, ptrdiff_t s, ptrdiff_t width, double *space,
                                   double **kept)
{
    double *inverse = space, *held = inverse + width * width + LDL_SLACK;
    double *b = held + width + LDL_SLACK, *product;
    double *g = self->block + self->block_start[s];
    ptrdiff_t n_rows = ldl_rows(self, s), stride = ldl_stride(n_rows), end = n_rows;
    ptrdiff_t bad = ldl_invert(self, s, width, inverse, held);
    if (bad < 0)
        return bad;
    product = b + width * stride + LDL_SLACK;
    for (ptrdiff_t r = 0; r < n_rows; ++r) {
        for (ptrdiff_t c = 0; c < width; ++c)
            b[c * stride + r] = g[c];
        ldl_products(g, width, inverse, width, width, held);
        for (ptrdiff_t c = 0; c < width; ++c)
            g[c] = held[c];
        g += width;
    }
    if (s < self->part[self->n_parts]) {
        end = ldl_rows_before(self, s, self->root_column);
        if (end < n_rows) {
            memcpy(*kept, b, width * stride * sizeof(double));
            *kept += width * stride;
        }
    }
    ldl_update(self, s, width, 0, end, 0, b, product);
    return bad;
}

/* Eliminate supernodes s to end; return as `ldl_invert` does. */
static ptrdiff_t ldl_eliminate_range(const ldl *self, ptrdiff_t s, ptrdiff_t end, double *space,
                                     double *kept)
{
    ptrdiff_t bad = 0;
    for (; s < end; ++s) {
        ptrdiff_t width = ldl_width(self, s), found;
        /* Nodes of planar cables, spatial cables and thick beams: loops of known length. */
        if (width == 4)
            found = ldl_eliminate(self, s, 4, space, &kept);
        else if (width == 6)
            found = ldl_eliminate(self, s, 6, space, &kept);
        else if (width == 12)
            found = ldl_eliminate(self, s, 12, space, &kept);
        else
            found = ldl_eliminate(self, s, width, space, &kept);
        if (found < 0)
            return bad == 0 ? found : -bad;
        if (bad == 0)
            bad = found;
    }
    return bad;
}

static void ldl_eliminate_part(void *context, ptrdiff_t part)
{
    const ldl *self = context;
    ptrdiff_t b = 0;
    while (b < self->n_boundary && self->boundary[b] < self->part[part])
        ++b;
    self->outcome[part] =
        ldl_eliminate_range(self, self->part[part], self->part[part + 1],
                            self->space + part * self->space_of_part, self->kept + self->kept_start[b]);
}

/* Factor the values; 0, or 1 + the first unknown whose pivot has the wrong sign. */
static ptrdiff_t ldl_factor(void *context, const double *values)
{
    ldl *self = context;
    ptrdiff_t bad = 0, found;
    self->values = values;
    ancf_in_parts(self->n_parts, ldl_clear, self);
    ancf_in_parts(self->n_parts, ldl_spread, self);
    ancf_in_parts(self->n_parts, ldl_eliminate_part, self);
    for (ptrdiff_t part = 0; part < self->n_parts; ++part) {
        if (self->outcome[part] < 0)
            return bad == 0 ? -self->outcome[part] : bad;
        if (bad == 0)
            bad = self->outcome[part];
    }
    for (ptrdiff_t k = 0; k < self->n_boundary; ++k) {
        ptrdiff_t s = self->boundary[k];
        ldl_update(self, s, ldl_width(self, s), ldl_rows_before(self, s, self->root_column),
                   ldl_rows(self, s), ldl_image_shift(self, s), self->kept + self->kept_start[k],
                   self->space);
    }
    found = ldl_eliminate_range(self, self->part[self->n_parts], self->n_super, self->space, NULL);
    return bad != 0 ? bad : found < 0 ? -found : found;
}

#endif
