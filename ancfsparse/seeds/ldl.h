/* A symmetric quasi-definite matrix, factored by supernodes: what its parts are and where they lie.
 *
 * A supernode s is a run of columns with one and the same pattern below: the coordinates of a node, or
 * more.  Of what is left of the matrix when its turn comes, P is the square block at the diagonal and B
 * are the rows below, one for each row of the pattern.  Kept are
 *
 *     P = L D L^T,  as 1/D and the packed strict triangle of L,   and   G = B P^-1, row by row.
 *
 * Beside L and D of the whole matrix this takes as much room and as many operations in a solve, but the
 * way from one supernode to the next does not lead through a triangle: down x_rows -= G x_s, up
 * x_s = P^-1 x_s - G^T x_rows.  It is as stable as L D L^T up to the root of the condition of P (block LU
 * of a definite matrix: Demmel, Higham and Schreiber 1995); with P^-1 itself it would not be.
 *
 * For several threads the supernodes stand in parts that do not update one another, disjoint subtrees of
 * the elimination tree, and a root that all of them may update and that is left to one thread.  In the
 * sweeps every part has an image of the root's unknowns behind its own: there it adds, and from there it
 * reads, so rows of a part that belong to the root are numbered as places of the image.
 */
#ifndef ANCF_LDL_H
#define ANCF_LDL_H

#include <stddef.h>
#include <stdint.h>

#include "quad.h"

typedef struct {
    ptrdiff_t n, n_super, n_positive;
    const int32_t *permutation, *place; /* unknown eliminated in each place, and its inverse */
    const int64_t *start;               /* lower triangle of the matrix by columns */
    const int32_t *index;
    const int32_t *super_of, *first; /* supernode of each column; first column of each, and the end */
    const int64_t *row_start, *triangle_start, *block_start;
    const int32_t *row;
    double *entries; /* diagonals, triangles and blocks one after another */
    double *diagonal, *triangle, *block;
    int is_single; /* whether they are rounded to single precision, see ldl_single.h */
    const int32_t *place_of_entry; /* of the matrix in them; null where these would be too many */
    double *work;                  /* unknowns in order of elimination, then the images */
    /* First supernode of each part, of the root and the end; first column and columns of the root. */
    ptrdiff_t n_parts, root_column, n_root;
    const int32_t *part;
    /* Supernodes of the parts with rows in the root, and where what they leave for it is kept. */
    ptrdiff_t n_boundary;
    const int32_t *boundary;
    const int64_t *kept_start;
    double *kept;
    double *space; /* for one supernode, for each part: ldl_space numbers */
    ptrdiff_t space_of_part;
    ptrdiff_t *outcome;   /* of each part */
    const double *values; /* what is being factored */
    const double *r;      /* what is being solved for */
    double *x;
} ldl;

#define LDL_INLINE static inline __attribute__((always_inline))

typedef float ldl_single __attribute__((may_alias));

/* Numbers in double or single precision; which of them is known where the code is compiled. */
typedef struct {
    const void *first;
    int single;
} ldl_numbers;

LDL_INLINE ldl_numbers ldl_double(const double *first)
{
    return (ldl_numbers){first, 0};
}

LDL_INLINE ldl_numbers ldl_ahead(ldl_numbers x, ptrdiff_t n)
{
    ptrdiff_t size = x.single ? sizeof(float) : sizeof(double);
    return (ldl_numbers){(const char *)x.first + n * size, x.single};
}

LDL_INLINE double ldl_one(ldl_numbers x, ptrdiff_t i)
{
    return x.single ? ((const ldl_single *)x.first)[i] : ((const double *)x.first)[i];
}

LDL_INLINE quad ldl_four(ldl_numbers x, ptrdiff_t i)
{
    return x.single ? quad_of_singles((const float *)x.first + i) : quad_load((const double *)x.first + i);
}

/* Whether loops over a width are unrolled and best left to single numbers: nodes of cables. */
#define LDL_NARROW(width) (__builtin_constant_p(width) && (width) < 8)

LDL_INLINE ptrdiff_t ldl_width(const ldl *self, ptrdiff_t s)
{
    return self->first[s + 1] - self->first[s];
}

LDL_INLINE ptrdiff_t ldl_rows(const ldl *self, ptrdiff_t s)
{
    return self->row_start[s + 1] - self->row_start[s];
}

/* The widest node with loops of known length. */
enum { LDL_SHORT = 12 };

/* g . y, in two chains of additions, so that neither is long */
LDL_INLINE double ldl_dot(ldl_numbers g, const double *restrict y, ptrdiff_t width)
{
    double even = 0.0, odd = 0.0;
    ptrdiff_t c = 0;
    if (!LDL_NARROW(width)) {
        quad first = {0}, second = {0};
        for (; c + 8 <= width; c += 8) {
            first += ldl_four(g, c) * quad_load(y + c);
            second += ldl_four(g, c + 4) * quad_load(y + c + 4);
        }
        if (c + 4 <= width) {
            first += ldl_four(g, c) * quad_load(y + c);
            c += 4;
        }
        first += second;
        even = first[0] + first[2];
        odd = first[1] + first[3];
    }
    for (; c + 2 <= width; c += 2) {
        even += ldl_one(g, c) * y[c];
        odd += ldl_one(g, c + 1) * y[c + 1];
    }
    if (c < width)
        even += ldl_one(g, c) * y[c];
    return even + odd;
}

/* out -= a x, of length n */
LDL_INLINE void ldl_subtract(double *restrict out, double a, ldl_numbers x, ptrdiff_t n)
{
    ptrdiff_t i = 0;
    if (!LDL_NARROW(n))
        for (; i + 4 <= n; i += 4)
            quad_store(out + i, quad_load(out + i) - a * ldl_four(x, i));
    for (; i < n; ++i)
        out[i] -= a * ldl_one(x, i);
}

/* Passes in vectors may read and write so many numbers behind what they are for, and the sweeps read
 * so many behind the entries. */
enum { LDL_SLACK = 31, LDL_TAIL = 3 };

/* The rows of a supernode, transposed, stand this far apart: whole vectors. */
LDL_INLINE ptrdiff_t ldl_stride(ptrdiff_t n_rows) { return (n_rows + 3) / 4 * 4; }

/* How many rows of a supernode come before a column. */
LDL_INLINE ptrdiff_t ldl_rows_before(const ldl *self, ptrdiff_t s, ptrdiff_t column)
{
    const int32_t *row = self->row + self->row_start[s];
    ptrdiff_t n = ldl_rows(self, s);
    while (n > 0 && row[n - 1] >= column)
        --n;
    return n;
}

/* How far the image of the root in the part of supernode s is behind the root. */
LDL_INLINE ptrdiff_t ldl_image_shift(const ldl *self, ptrdiff_t s)
{
    ptrdiff_t part = 0;
    while (self->part[part + 1] <= s)
        ++part;
    return self->n + part * self->n_root - self->root_column;
}

#endif
