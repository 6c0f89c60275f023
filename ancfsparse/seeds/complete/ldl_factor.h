/* Right-looking elimination by supernodes: each, once factored, updates those its rows belong to. */
#ifndef ANCF_LDL_FACTOR_H
#define ANCF_LDL_FACTOR_H

#include <math.h>
#include <string.h>

#include "ldl.h"
#include "ldl_dense.h"
#include "ldl_spread.h"
#include "parallel.h"
#include "simd.h"

/* Distance between the products of consecutive rows. */
LDL_INLINE ptrdiff_t ldl_product_room(ptrdiff_t n_rows) { return ldl_stride(n_rows) + LDL_SLACK; }

/* Size of the workspace for a supernode: its rows transposed, their products, and the rows of G. */
static inline ptrdiff_t ldl_space(ptrdiff_t width, ptrdiff_t n_rows)
{
    return width * ldl_stride(n_rows) + LDL_SLACK + LDL_ROWS * ldl_product_room(n_rows) +
           LDL_ABREAST * ANCF_LANES * width;
}

/* Factor the diagonal block of a supernode, L D L^T in place, D inverted; returns 0, 1 + the first unknown
 * whose pivot has the wrong sign, or the negative of that if the pivot is zero or not finite. */
LDL_INLINE ptrdiff_t ldl_pivots(const ldl *self, ptrdiff_t s, ptrdiff_t width)
{
    const int32_t *permutation = self->permutation + self->first[s];
    double *restrict inverse = self->diagonal + self->first[s];
    double *triangle = self->triangle + self->triangle_start[s], *entry = triangle;
    ptrdiff_t bad = 0;
    for (ptrdiff_t c = 0; c < width; ++c) {
        double pivot = inverse[c], sign = permutation[c] < self->n_positive ? 1.0 : -1.0;
        const double *above = triangle;
        for (ptrdiff_t k = 1; k < c; ++k) {
            entry[k] -= ldl_dot(ldl_double(above), entry, k);
            above += k;
        }
        for (ptrdiff_t k = 0; k < c; ++k) {
            double scaled = entry[k] * inverse[k];
            pivot -= entry[k] * scaled;
            entry[k] = scaled;
        }
        inverse[c] = 1.0 / pivot;
        if (!(pivot * sign > 0.0 && pivot * sign < INFINITY)) { /* true for NaN */
            if (bad == 0)
                bad = 1 + permutation[c];
            if (pivot == 0.0 || !isfinite(pivot))
                return -bad;
        }
        entry += c;
    }
    return bad;
}

/* G of a wide supernode, for up to `abreast` vectors of rows, starting from row r. */
LDL_INLINE void ldl_divide_rows(const ldl *self, ptrdiff_t s, ptrdiff_t r, const double *b, vec *y,
                                int abreast)
{
    ptrdiff_t width = ldl_width(self, s), n_rows = ldl_rows(self, s), stride = ldl_stride(n_rows);
    ptrdiff_t n = n_rows - r < abreast * ANCF_LANES ? n_rows - r : abreast * ANCF_LANES;
    double *g = self->block + self->block_start[s] + r * width;
    for (ptrdiff_t c = 0; c < width; ++c)
        for (int j = 0; j < abreast; ++j)
            y[abreast * c + j] = vec_load(b + c * stride + r + j * ANCF_LANES);
    ldl_divide_abreast(self->triangle + self->triangle_start[s], self->diagonal + self->first[s], width,
                       y, abreast);
    for (ptrdiff_t k = 0; k < n; ++k)
        for (ptrdiff_t c = 0; c < width; ++c)
            g[k * width + c] = ((const double *)y)[abreast * ANCF_LANES * c + k];
}

/* G of a wide supernode, from its transposed rows; as many vectors at once as there are rows. */
static void ldl_divide_wide(const ldl *self, ptrdiff_t s, const double *b, vec *y)
{
    ptrdiff_t n_rows = ldl_rows(self, s), r = 0;
    for (; n_rows - r > 2 * ANCF_LANES; r += 4 * ANCF_LANES)
        ldl_divide_rows(self, s, r, b, y, 4);
    if (n_rows - r > ANCF_LANES)
        ldl_divide_rows(self, s, r, b, y, 2);
    else if (n_rows > r)
        ldl_divide_rows(self, s, r, b, y, 1);
}

/* Subtract the update by supernode s from the columns of its rows r to end; `b` are its rows, transposed.
 * Row numbers include `shift`: zero, or the offset of the image of the root. */
LDL_INLINE void ldl_update(const ldl *self, ptrdiff_t s, ptrdiff_t width, ptrdiff_t r, ptrdiff_t end,
                           ptrdiff_t shift, const double *b, double *products)
{
    const double *block = self->block + self->block_start[s];
    const int32_t *row = self->row + self->row_start[s];
    ptrdiff_t n_rows = ldl_rows(self, s), stride = ldl_stride(n_rows);
    ptrdiff_t room = ldl_product_room(n_rows);
    double *product;
    while (r < end) {
        /* The rows before `behind` are columns of supernode t. */
        ptrdiff_t t = self->super_of[row[r] - shift], first = self->first[t] + shift, behind = r + 1;
        while (behind < end && row[behind] < self->first[t + 1] + shift)
            ++behind;
        const int32_t *to = self->row + self->row_start[t];
        double *target = self->block + self->block_start[t];
        for (ptrdiff_t i = r, ready = r; i < n_rows; ++i) {
            ptrdiff_t n = i < behind ? i - r : behind - r;
            double *out;
            if (i == ready) {
                int several = !__builtin_constant_p(width) && i + LDL_ROWS <= n_rows;
                ready += several ? LDL_ROWS : 1;
                product = products;
                ptrdiff_t columns = (ready < behind ? ready : behind) - r;
                if (several)
                    ldl_products_of_rows(block + i * width, width, b + r, stride, columns, product, room);
                else
                    ldl_products(block + i * width, width, b + r, stride, columns, product);
            }
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
            product += room;
        }
        r = behind;
    }
}

/* Eliminate a supernode and update its part; returns like `ldl_pivots`.  Its update of the root, if any,
 * is stored: one thread processes the root later.  Supernodes of the root itself update only the root. */
LDL_INLINE ptrdiff_t ldl_eliminate(const ldl *self, ptrdiff_t s, ptrdiff_t width, double *space,
                                   double **kept)
{
    double *g = self->block + self->block_start[s];
    ptrdiff_t n_rows = ldl_rows(self, s), stride = ldl_stride(n_rows), end = n_rows, bad;
    double *b = space, *products = b + width * stride + LDL_SLACK;
    for (ptrdiff_t r = 0; r < n_rows; ++r)
        for (ptrdiff_t c = 0; c < width; ++c)
            b[c * stride + r] = g[r * width + c];
    bad = ldl_pivots(self, s, width);
    if (bad < 0)
        return bad;
    if (__builtin_constant_p(width))
        for (ptrdiff_t r = 0; r < n_rows; r += 4) {
            quad y[LDL_SHORT];
            for (ptrdiff_t c = 0; c < width; ++c)
                y[c] = quad_load(b + c * stride + r);
            ldl_divide(self->triangle + self->triangle_start[s], self->diagonal + self->first[s], width,
                       y);
            for (ptrdiff_t k = r; k < n_rows && k < r + 4; ++k)
                for (ptrdiff_t c = 0; c < width; ++c)
                    g[k * width + c] = y[c][k - r];
        }
    else
        ldl_divide_wide(self, s, b, (vec *)(products + LDL_ROWS * ldl_product_room(n_rows)));
    if (s < self->part[self->n_parts]) {
        end = ldl_rows_before(self, s, self->root_column);
        if (end < n_rows) {
            memcpy(*kept, b, width * stride * sizeof(double));
            *kept += width * stride;
        }
    }
    ldl_update(self, s, width, 0, end, 0, b, products);
    return bad;
}

/* Eliminate supernodes s to end; returns like `ldl_pivots`. */
static ptrdiff_t ldl_eliminate_range(const ldl *self, ptrdiff_t s, ptrdiff_t end, double *space,
                                     double *kept)
{
    ptrdiff_t bad = 0;
    for (; s < end; ++s) {
        ptrdiff_t width = ldl_width(self, s), found;
        /* Nodes of planar and spatial cables: loops of known length. */
        if (width == 4)
            found = ldl_eliminate(self, s, 4, space, &kept);
        else if (width == 6)
            found = ldl_eliminate(self, s, 6, space, &kept);
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

/* Factor the values; returns 0, or 1 + the first unknown whose pivot has the wrong sign. */
static ptrdiff_t ldl_factor(void *context, const double *values)
{
    ldl *self = context;
    ptrdiff_t bad = 0, found;
    self->values = values;
    self->is_single = 0;
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
