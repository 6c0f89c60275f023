/* Supernodal factorization of a symmetric quasi-definite matrix: its parts and their storage.
 *
 * A supernode s is a set of consecutive columns with the same pattern below: the coordinates of a node, or
 * more.  In the Schur complement at its elimination, P is the square diagonal block and B the rows below,
 * one per row of the pattern.  Stored are
 *
 *     P = L D L^T,  as 1/D and the packed strict triangle of L,   and   G = B P^-1, row by row.
 *
 * Compared with L and D of the whole matrix, memory and operations of a solve are the same, but the
 * critical path from one supernode to the next contains no triangular solve: forward x_rows -= G x_s,
 * backward x_s = P^-1 x_s - G^T x_rows.  It is as stable as L D L^T up to the root of the condition number
 * of P (block LU of a definite matrix: Demmel, Higham and Schreiber 1995); with P^-1 it would not be.
 *
 * For several threads the supernodes are divided into parts that do not update one another, disjoint
 * subtrees of the elimination tree, and a root that all of them may update and that one thread processes.
 * In the sweeps each part has an image of the root's unknowns after its own, to which it adds and from
 * which it reads; rows of a part that belong to the root are numbered as entries of the image.
 */
#ifndef ANCF_LDL_H
#define ANCF_LDL_H

#include <stddef.h>
#include <stdint.h>

#include "simd4.h"

typedef struct {
    ptrdiff_t n, n_super, n_positive;
    const int32_t *permutation, *place; /* unknowns in order of elimination, and its inverse */
    const int64_t *start;               /* lower triangle of the matrix by columns */
    const int32_t *index;
    const int32_t *super_of, *first; /* supernode of each column; first column of each, and the end */
    const int64_t *row_start, *triangle_start, *block_start;
    const int32_t *row;
    double *entries; /* diagonals, triangles and blocks, in this order */
    double *diagonal, *triangle, *block;
    int is_single; /* whether they are rounded to single precision, see ldl_single.h */
    const int32_t *place_of_entry; /* index of each matrix entry in them; null if there are too many */
    double *work;                  /* unknowns in order of elimination, then the images */
    /* First supernode of each part, of the root, and the end; first column and columns of the root. */
    ptrdiff_t n_parts, root_column, n_root;
    const int32_t *part;
    /* Supernodes of the parts with rows in the root, and storage of their updates of it. */
    ptrdiff_t n_boundary;
    const int32_t *boundary;
    const int64_t *kept_start;
    double *kept;
    double *space; /* workspace for one supernode per part: ldl_space numbers */
    ptrdiff_t space_of_part;
    ptrdiff_t *outcome;   /* of each part */
    const double *values; /* matrix being factored */
    const double *r;      /* current right-hand side */
    double *x;
} ldl;

#define LDL_INLINE static inline __attribute__((always_inline))

typedef float ldl_single __attribute__((may_alias));

/* Numbers in double or single precision; which of the two is known at compile time. */
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

/* Whether loops over a width are unrolled and best done with scalars: nodes of cables. */
#define LDL_NARROW(width) (__builtin_constant_p(width) && (width) < 8)

LDL_INLINE ptrdiff_t ldl_width(const ldl *self, ptrdiff_t s)
{
    return self->first[s + 1] - self->first[s];
}

LDL_INLINE ptrdiff_t ldl_rows(const ldl *self, ptrdiff_t s)
{
    return self->row_start[s + 1] - self->row_start[s];
}

/* Width of the widest node with loops of known length. */
enum { LDL_SHORT = 12 };

/* g . y, in two independent sums, which shortens the chain of dependent additions */
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

/* Vector operations may read and write this many numbers past the end of their range, and the sweeps may
 * read this many past the end of the entries. */
enum { LDL_SLACK = 31, LDL_TAIL = 3 };

/* Leading dimension of the transposed rows of a supernode: whole vectors. */
LDL_INLINE ptrdiff_t ldl_stride(ptrdiff_t n_rows) { return (n_rows + 3) / 4 * 4; }

/* Number of rows of a supernode before a column. */
LDL_INLINE ptrdiff_t ldl_rows_before(const ldl *self, ptrdiff_t s, ptrdiff_t column)
{
    const int32_t *row = self->row + self->row_start[s];
    ptrdiff_t n = ldl_rows(self, s);
    while (n > 0 && row[n - 1] >= column)
        --n;
    return n;
}

/* Offset from the root to its image in the part of supernode s. */
LDL_INLINE ptrdiff_t ldl_image_shift(const ldl *self, ptrdiff_t s)
{
    ptrdiff_t part = 0;
    while (self->part[part + 1] <= s)
        ++part;
    return self->n + part * self->n_root - self->root_column;
}

#endif
