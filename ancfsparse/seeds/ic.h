/* An incomplete Cholesky factor in blocks: the matrix it is made of, and where its parts lie.
 *
 * The unknowns are taken three at a time, a position or a slope in space; what is held or has fewer
 * coordinates leaves places free, which are filled by ones on the diagonal.  The factor
 *
 *     A ~ (I + N) D (I + N)^T,   N strictly lower,
 *
 * has the blocks that A has and no others; what elimination would add elsewhere is dropped.  On a tree
 * whose leaves come first nothing is dropped.
 *
 * A block takes three columns of four numbers.  Blocks are factored in double precision; then they are
 * rounded to single precision into the front half of their own room, and A itself into the back half.
 * All of it is scaled on both sides by powers of two, so that the diagonal of A is near one and no
 * unit of mass or length leaves the range of single precision.
 */
#ifndef ANCF_IC_H
#define ANCF_IC_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "quad.h"

/* Numbers of a block, and of a triple of unknowns. */
enum { IC_BLOCK = 12, IC_TRIPLE = 4 };

/* Share of the residual that conjugate gradients may leave of a correction which others follow. */
#define IC_LOOSE 0.1

/* How a solve goes: one sweep; or conjugate gradients, whose first count says which of both is next. */
enum { IC_PROBE, IC_PLAIN, IC_INNER };

typedef struct {
    ptrdiff_t n, n_triples, n_blocks; /* blocks: those on the diagonal, then those below it */
    const int64_t *indptr;            /* lower triangle of A by columns */
    const int32_t *indices;
    const int32_t *unknown;        /* three of each triple, in order of elimination; -1 where none is */
    const int64_t *start;          /* first block below the diagonal of each column, and the end */
    const int32_t *row;            /* triple of each of these, ascending in a column */
    const int32_t *place_of_entry; /* of A, counted in doubles of `blocks` */
    double *scale;                 /* of each unknown */
    double *blocks, *column;       /* `column` has room for the longest one */
    double *x, *r, *z, *p;         /* vectors over the triples */
    int mode;
    double share;                 /* of the residual that conjugate gradients may leave */
    int64_t sweeps, products;     /* since construction */
    double extra;                 /* operations of solves so far beyond one sweep for each */
    double per_sweep, per_round;  /* operations */
} ic;

#define IC_INLINE static inline __attribute__((always_inline))

IC_INLINE float *ic_factor_singles(const ic *self) { return (float *)self->blocks; }
IC_INLINE float *ic_matrix_singles(const ic *self)
{
    return (float *)self->blocks + IC_BLOCK * self->n_blocks;
}

#endif
