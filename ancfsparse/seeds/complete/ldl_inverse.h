/* The inverse of a factored matrix, for one thread.
 *
 * Four columns at a time fill vectors, and the factor is read once for them.  In the order of elimination the
 * forward sweep begins at the first of the four, where their unit vectors do, and the backward sweep ends
 * there: the entries before it follow by symmetry.  Both take a quarter of the time of solves one by one.
 */
#ifndef ANCF_LDL_INVERSE_H
#define ANCF_LDL_INVERSE_H

#include "ldl.h"

/* x_rows -= G y, for the unknowns y of a supernode */
LDL_INLINE void ldl_forward_four(ldl_numbers g, const int32_t *row, ptrdiff_t n_rows, ptrdiff_t width, quad *x,
                                 const quad *y)
{
    for (ptrdiff_t r = 0; r < n_rows; ++r) {
        quad sum = {0};
        for (ptrdiff_t c = 0; c < width; ++c)
            sum += ldl_one(g, r * width + c) * y[c];
        x[row[r]] -= sum;
    }
}

/* y = P^-1 y - G^T x_rows; `low` is workspace. */
LDL_INLINE void ldl_backward_four(ldl_numbers g, ldl_numbers inverse, ldl_numbers triangle, const int32_t *row,
                                  ptrdiff_t n_rows, ptrdiff_t width, const quad *x, quad *y, quad *restrict low)
{
    for (ptrdiff_t c = 0; c < width; ++c)
        low[c] = (quad){0};
    for (ptrdiff_t r = 0; r < n_rows; ++r)
        for (ptrdiff_t c = 0; c < width; ++c)
            low[c] += ldl_one(g, r * width + c) * x[row[r]];
    for (ptrdiff_t c = 1; c < width; ++c)
        for (ptrdiff_t k = 0; k < c; ++k)
            y[c] -= ldl_one(triangle, c * (c - 1) / 2 + k) * y[k];
    for (ptrdiff_t c = 0; c < width; ++c)
        y[c] *= ldl_one(inverse, c);
    for (ptrdiff_t c = width - 1; c > 0; --c)
        for (ptrdiff_t k = 0; k < c; ++k)
            y[k] -= ldl_one(triangle, c * (c - 1) / 2 + k) * y[c];
    for (ptrdiff_t c = 0; c < width; ++c)
        y[c] -= low[c];
}

/* Solve for the unknowns of supernodes from `begin` on, in place: x[n] in the order of elimination. */
LDL_INLINE void ldl_solve_four(const ldl *self, ptrdiff_t begin, quad *x, quad *low, int single)
{
    const ldl_numbers block = {self->block, single}, triangles = {self->triangle, single};
    const ldl_numbers diagonal = {self->diagonal, single};
    for (ptrdiff_t s = begin; s < self->n_super; ++s) {
        ptrdiff_t width = ldl_width(self, s), n_rows = ldl_rows(self, s);
        ldl_numbers g = ldl_ahead(block, self->block_start[s]);
        const int32_t *row = self->row + self->row_start[s];
        const quad *y = x + self->first[s];
        if (width == 4) /* nodes of planar cables */
            ldl_forward_four(g, row, n_rows, 4, x, y);
        else if (width == 6) /* and of spatial ones */
            ldl_forward_four(g, row, n_rows, 6, x, y);
        else
            ldl_forward_four(g, row, n_rows, width, x, y);
    }
    for (ptrdiff_t s = self->n_super - 1; s >= begin; --s) {
        ptrdiff_t width = ldl_width(self, s), n_rows = ldl_rows(self, s);
        ldl_numbers g = ldl_ahead(block, self->block_start[s]);
        ldl_numbers triangle = ldl_ahead(triangles, self->triangle_start[s]);
        ldl_numbers inverse = ldl_ahead(diagonal, self->first[s]);
        const int32_t *row = self->row + self->row_start[s];
        quad *y = x + self->first[s];
        if (width == 4)
            ldl_backward_four(g, inverse, triangle, row, n_rows, 4, x, y, low);
        else if (width == 6)
            ldl_backward_four(g, inverse, triangle, row, n_rows, 6, x, y, low);
        else
            ldl_backward_four(g, inverse, triangle, row, n_rows, width, x, y, low);
    }
}

static void ldl_inverse(void *context, double *columns, ptrdiff_t stride, double *space)
{
    const ldl *self = context;
    quad *x = (quad *)space, *low = x + self->n;
    for (ptrdiff_t begin = 0; begin < self->n; begin += 4) {
        ptrdiff_t s = self->super_of[begin], n_columns = self->n - begin < 4 ? self->n - begin : 4;
        for (ptrdiff_t k = self->first[s]; k < self->n; ++k)
            x[k] = (quad){0};
        for (ptrdiff_t j = 0; j < n_columns; ++j)
            x[begin + j][j] = 1.0;
        if (self->is_single)
            ldl_solve_four(self, s, x, low, 1);
        else
            ldl_solve_four(self, s, x, low, 0);
        /* Unknowns that follow one another in this order mostly do so in theirs, in one cache line. */
        for (ptrdiff_t k = begin; k < self->n; ++k)
            for (ptrdiff_t j = 0; j < n_columns; ++j) {
                ptrdiff_t one = self->permutation[begin + j], other = self->permutation[k];
                columns[one * stride + other] = columns[other * stride + one] = x[k][j];
            }
    }
}

#endif
