/* The forward and backward sweeps of a solve with a supernodal factor. */
#ifndef ANCF_LDL_SWEEPS_H
#define ANCF_LDL_SWEEPS_H

#include <string.h>

#include "ldl.h"
#include "parallel.h"

/* x_rows -= G x_s, for supernodes of a width known at compile time */
LDL_INLINE void ldl_forward(ldl_numbers g, const int32_t *row, ptrdiff_t n_rows, ptrdiff_t width,
                            double *x, const double *y)
{
    double held[LDL_SHORT]; /* in registers, since stores to x cannot alias them */
    for (ptrdiff_t c = 0; c < width; ++c)
        held[c] = y[c];
    for (ptrdiff_t r = 0; r < n_rows; ++r)
        x[row[r]] -= ldl_dot(ldl_ahead(g, r * width), held, width);
}

/* The same for wide supernodes, four rows at a time; `held` is workspace.  The last four columns of a row
 * may overlap the next row, multiplied by zero. */
LDL_INLINE void ldl_forward_wide(ldl_numbers g, const int32_t *row, ptrdiff_t n_rows, ptrdiff_t width,
                                 double *x, const double *y, double *restrict held)
{
    ptrdiff_t r = 0;
    for (ptrdiff_t c = 0; c < width; ++c)
        held[c] = y[c];
    quad_store(held + width, (quad){0});
    for (; r + 4 <= n_rows; r += 4) {
        ldl_numbers g1 = ldl_ahead(g, width), g2 = ldl_ahead(g1, width), g3 = ldl_ahead(g2, width);
        quad sum0 = {0}, sum1 = {0}, sum2 = {0}, sum3 = {0};
        for (ptrdiff_t c = 0; c < width; c += 4) {
            quad value = quad_load(held + c);
            sum0 += ldl_four(g, c) * value;
            sum1 += ldl_four(g1, c) * value;
            sum2 += ldl_four(g2, c) * value;
            sum3 += ldl_four(g3, c) * value;
        }
        x[row[r]] -= quad_sum(sum0);
        x[row[r + 1]] -= quad_sum(sum1);
        x[row[r + 2]] -= quad_sum(sum2);
        x[row[r + 3]] -= quad_sum(sum3);
        g = ldl_ahead(g3, width);
    }
    for (; r < n_rows; ++r) {
        x[row[r]] -= ldl_dot(g, held, width);
        g = ldl_ahead(g, width);
    }
}

/* low = G^T x_rows, for wide supernodes; the last four columns of a row may exceed the end of `low`. */
LDL_INLINE void ldl_gather_wide(ldl_numbers g, const int32_t *row, ptrdiff_t n_rows, ptrdiff_t width,
                                const double *x, double *restrict low)
{
    ptrdiff_t r = 0;
    for (ptrdiff_t c = 0; c < width; c += 4)
        quad_store(low + c, (quad){0});
    for (; r + 4 <= n_rows; r += 4) {
        ldl_numbers g1 = ldl_ahead(g, width), g2 = ldl_ahead(g1, width), g3 = ldl_ahead(g2, width);
        double x0 = x[row[r]], x1 = x[row[r + 1]], x2 = x[row[r + 2]], x3 = x[row[r + 3]];
        for (ptrdiff_t c = 0; c < width; c += 4)
            quad_store(low + c, quad_load(low + c) + (x0 * ldl_four(g, c) + x1 * ldl_four(g1, c))
                                    + (x2 * ldl_four(g2, c) + x3 * ldl_four(g3, c)));
        g = ldl_ahead(g3, width);
    }
    for (; r < n_rows; ++r) {
        ldl_subtract(low, -x[row[r]], g, width);
        g = ldl_ahead(g, width);
    }
}

/* y = P^-1 y */
LDL_INLINE void ldl_divide_one(ldl_numbers entry, ldl_numbers inverse, ptrdiff_t width,
                               double *restrict y)
{
    if (__builtin_constant_p(width)) { /* unrolled, so that independent operations overlap */
#pragma GCC unroll 12
        for (ptrdiff_t c = 1; c < width; ++c)
#pragma GCC unroll 12
            for (ptrdiff_t k = 0; k < c; ++k)
                y[c] -= ldl_one(entry, c * (c - 1) / 2 + k) * y[k];
#pragma GCC unroll 12
        for (ptrdiff_t c = 0; c < width; ++c)
            y[c] *= ldl_one(inverse, c);
#pragma GCC unroll 12
        for (ptrdiff_t c = width - 1; c > 0; --c)
#pragma GCC unroll 12
            for (ptrdiff_t k = 0; k < c; ++k)
                y[k] -= ldl_one(entry, c * (c - 1) / 2 + k) * y[c];
        return;
    }
    for (ptrdiff_t c = 1; c < width; ++c) {
        y[c] -= ldl_dot(entry, y, c);
        entry = ldl_ahead(entry, c);
    }
    for (ptrdiff_t c = 0; c < width; ++c)
        y[c] *= ldl_one(inverse, c);
    for (ptrdiff_t c = width - 1; c > 0; --c) {
        entry = ldl_ahead(entry, -c);
        ldl_subtract(y, y[c], entry, c);
    }
}

/* y = P^-1 y - G^T x_rows, for the unknowns of a supernode; `low` is workspace. */
LDL_INLINE void ldl_backward(ldl_numbers g, ldl_numbers inverse, ldl_numbers triangle,
                             const int32_t *row, ptrdiff_t n_rows, ptrdiff_t width, const double *x,
                             double *restrict y, double *restrict low)
{
    /* Only the rows of ancestors depend on earlier results; everything else can be done before. */
    if (__builtin_constant_p(width)) { /* in registers; the last four may overlap the next row */
        quad even[LDL_SHORT / 4] = {{0}}, odd[LDL_SHORT / 4] = {{0}};
        ptrdiff_t fours = (width + 3) / 4, r = 0;
        for (; r + 2 <= n_rows; r += 2)
            for (ptrdiff_t k = 0; k < fours; ++k) {
                even[k] += x[row[r]] * ldl_four(g, r * width + 4 * k);
                odd[k] += x[row[r + 1]] * ldl_four(g, r * width + width + 4 * k);
            }
        for (ptrdiff_t k = 0; k < fours && r < n_rows; ++k)
            even[k] += x[row[r]] * ldl_four(g, r * width + 4 * k);
        for (ptrdiff_t k = 0; k < fours; ++k)
            quad_store(low + 4 * k, even[k] + odd[k]);
    } else {
        ldl_gather_wide(g, row, n_rows, width, x, low);
    }
    ldl_divide_one(triangle, inverse, width, y);
    for (ptrdiff_t c = 0; c < width; ++c)
        y[c] -= low[c];
}

/* Sweep over supernodes s to end.  The right-hand side is loaded just before it is needed, from column
 * `gathered` on.  Supernodes s to end are a part or the root, each of which is rounded separately. */
LDL_INLINE void ldl_forward_range(const ldl *self, ptrdiff_t s, ptrdiff_t end, ptrdiff_t gathered,
                                  double *space, int single)
{
    double *x = self->work;
    ldl_numbers g = {self->block + self->block_start[s], single};
    const int32_t *row = self->row + self->row_start[s];
    ptrdiff_t column = self->first[s], last = self->first[end];
    for (; s < end; ++s) {
        ptrdiff_t width = ldl_width(self, s), n_rows = ldl_rows(self, s);
        ptrdiff_t needed = column + width;
        for (ptrdiff_t r = n_rows - 1; r >= 0; --r)
            if (row[r] < last) {
                needed = row[r] + 1;
                break;
            }
        for (; gathered < needed; ++gathered)
            x[gathered] = self->r[self->permutation[gathered]];
        /* Nodes of cables and of thick beams, planar and spatial: loops of known length. */
        if (width == 3)
            ldl_forward(g, row, n_rows, 3, x, x + column);
        else if (width == 4)
            ldl_forward(g, row, n_rows, 4, x, x + column);
        else if (width == 6)
            ldl_forward(g, row, n_rows, 6, x, x + column);
        else if (width == 12)
            ldl_forward(g, row, n_rows, 12, x, x + column);
        else if (width == 7)
            ldl_forward(g, row, n_rows, 7, x, x + column);
        else
            ldl_forward_wide(g, row, n_rows, width, x, x + column, space);
        g = ldl_ahead(g, n_rows * width);
        row += n_rows;
        column += width;
    }
}

/* With the unknowns in registers. */
#define LDL_BACKWARD(width)                                                                    \
    do {                                                                                       \
        for (ptrdiff_t c = 0; c < (width); ++c)                                                \
            held[c] = y[c];                                                                    \
        ldl_backward(g, inverse, triangle, row, n_rows, (width), x, held, low);                \
        for (ptrdiff_t c = 0; c < (width); ++c)                                                \
            self->x[out[c]] = y[c] = held[c];                                                  \
    } while (0)

LDL_INLINE void ldl_backward_range(const ldl *self, ptrdiff_t s, ptrdiff_t end, double *space,
                                   int single)
{
    double *x = self->work;
    int64_t in_block = self->block_start[s], in_triangle = self->triangle_start[s];
    ldl_numbers g = {self->block + in_block, single};
    ldl_numbers triangle = {self->triangle + in_triangle, single};
    ldl_numbers inverse = {self->diagonal + self->first[s], single};
    const int32_t *row = self->row + self->row_start[end];
    ptrdiff_t column = self->first[end], begin = s;
    g = ldl_ahead(g, self->block_start[end] - in_block);
    triangle = ldl_ahead(triangle, self->triangle_start[end] - in_triangle);
    inverse = ldl_ahead(inverse, column - self->first[s]);
    for (s = end - 1; s >= begin; --s) {
        ptrdiff_t width = ldl_width(self, s), n_rows = ldl_rows(self, s);
        const int32_t *out = self->permutation + (column -= width);
        double held[LDL_SHORT], low[LDL_SHORT], *y = x + column;
        g = ldl_ahead(g, -n_rows * width);
        triangle = ldl_ahead(triangle, -width * (width - 1) / 2);
        inverse = ldl_ahead(inverse, -width);
        row -= n_rows;
        if (width == 3)
            LDL_BACKWARD(3);
        else if (width == 4)
            LDL_BACKWARD(4);
        else if (width == 6)
            LDL_BACKWARD(6);
        else if (width == 12)
            LDL_BACKWARD(12);
        else if (width == 7)
            LDL_BACKWARD(7);
        else {
            ldl_backward(g, inverse, triangle, row, n_rows, width, x, y, space);
            for (ptrdiff_t c = 0; c < width; ++c)
                self->x[out[c]] = y[c];
        }
    }
}

/* Supernodes of a part, or of the root; the two precisions are compiled separately. */
static void ldl_down(const ldl *self, ptrdiff_t s, ptrdiff_t end, ptrdiff_t gathered, double *space)
{
    if (self->is_single)
        ldl_forward_range(self, s, end, gathered, space, 1);
    else
        ldl_forward_range(self, s, end, gathered, space, 0);
}

static void ldl_up(const ldl *self, ptrdiff_t s, ptrdiff_t end, double *space)
{
    if (self->is_single)
        ldl_backward_range(self, s, end, space, 1);
    else
        ldl_backward_range(self, s, end, space, 0);
}

static void ldl_forward_part(void *context, ptrdiff_t part)
{
    const ldl *self = context;
    memset(self->work + self->n + part * self->n_root, 0, self->n_root * sizeof(double));
    ldl_down(self, self->part[part], self->part[part + 1], self->first[self->part[part]],
             self->space + part * self->space_of_part);
}

static void ldl_backward_part(void *context, ptrdiff_t part)
{
    const ldl *self = context;
    memcpy(self->work + self->n + part * self->n_root, self->work + self->root_column,
           self->n_root * sizeof(double));
    ldl_up(self, self->part[part], self->part[part + 1],
           self->space + part * self->space_of_part);
}

static void ldl_solve(void *context, const double *r, double *x)
{
    ldl *self = context;
    ptrdiff_t root = self->part[self->n_parts];
    self->r = r;
    self->x = x;
    ancf_in_parts(self->n_parts, ldl_forward_part, self);
    if (self->n_root > 0) {
        for (ptrdiff_t k = self->root_column; k < self->n; ++k) {
            double sum = r[self->permutation[k]];
            for (ptrdiff_t part = 0; part < self->n_parts; ++part)
                sum += self->work[k - self->root_column + self->n + part * self->n_root];
            self->work[k] = sum;
        }
        ldl_down(self, root, self->n_super, self->n, self->space);
        ldl_up(self, root, self->n_super, self->space);
    }
    ancf_in_parts(self->n_parts, ldl_backward_part, self);
}

#endif
