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
 * Two fronts of triples, which do not meet, come first, and then the middle, which both meet.  Each front
 * can have a thread of its own.  What the second one adds to the middle it adds to an image of it, so
 * digits do not depend on the number of threads.
 *
 * A block takes nine numbers, column by column.  Blocks are factored in double precision; then they are
 * rounded to single precision into the front half of their own room, and A itself into the back half:
 * sweeps take as long as memory takes to bring them.  All of it is scaled on both sides by powers of two,
 * so that the diagonal of A is near one and no unit of mass or length leaves the range of single precision.
 */
#ifndef ANCF_IC_H
#define ANCF_IC_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "parallel.h"
#include "quad.h"
#include "solver_abi.h"

/* Numbers of a block, and of a triple of unknowns; numbers of four that are read past the last block. */
enum { IC_BLOCK = 9, IC_TRIPLE = 4, IC_PAST = 4 };
/* Fronts, each with a thread where there are two; then comes the middle. */
enum { IC_FRONTS = 2, IC_MIDDLE = 2 };

/* Share of the residual that conjugate gradients may leave of a correction which others follow. */
#define IC_LOOSE 0.1

/* How a solve goes: one sweep; or conjugate gradients, whose first count says which of both is next. */
enum { IC_PROBE, IC_PLAIN, IC_INNER };

/* Modes along which cables slide, see ic_coarse.h: the way of each triple in its mode. */
typedef struct {
    ptrdiff_t n, n_ways, n_terms, n_values;
    ptrdiff_t first[IC_FRONTS + 1]; /* way of each front, the middle with the second, and the end */
    const int32_t *triple, *mode;   /* of each way, by triples */
    const float *direction;         /* three numbers of each way */
    float *way;                     /* four, scaled as the matrix is */
    const int32_t *block, *row, *column, *place; /* terms of E: blocks between two ways, and where */
    double *values, *sums;          /* of E, twice; of each mode, two for each front */
    const ancf_seed *factor;        /* of E; NULL where there are no modes */
} ic_modes;

/* Equations that are held exactly, see ic_border.h. */
typedef struct {
    ptrdiff_t n, n_own;      /* equations; entries of their own block */
    const int32_t *first;    /* term of each equation, and the end */
    const int64_t *entry;    /* of each term among the values of the matrix */
    const int32_t *unknown, *place; /* its coordinate, and where that is in vectors over triples */
    const int64_t *own;      /* entries of -E among the values, and where they are in S */
    const int32_t *own_place;
    double *term, *schur;    /* B by equations, scaled; S by rows, or its factor */
    double *size;            /* 1 / sqrt of the diagonal of S */
    double *off, *of_x, *of_p, *of_z, *sums; /* g, multipliers of the vectors, room */
} ic_border;

typedef struct {
    ptrdiff_t n, n_triples, n_blocks; /* blocks: those on the diagonal, then those below it */
    ptrdiff_t first[IC_FRONTS + 2];   /* triple of each front and of the middle, and the end */
    ptrdiff_t longest;                /* blocks of the longest column */
    const int64_t *indptr;            /* lower triangle of A by columns */
    const int32_t *indices;
    const int32_t *unknown;        /* three of each triple, in order of elimination; -1 where none is */
    const int32_t *start;          /* first block below the diagonal of each column, and the end */
    const int32_t *row;            /* triple of each of these, ascending; of the second front in its image */
    const int32_t *place_of_entry; /* of A, counted in numbers of `blocks` */
    double *scale;                 /* of each unknown; of equations one */
    double *scale_of;              /* of the three of each triple */
    double *blocks;                /* and then the image of those of the middle */
    double *column;                /* room for the longest one of each front */
    float *x, *r, *z, *p, *w;      /* vectors over the triples and the image of the middle */
    ic_modes modes;
    ic_border border;
    int use, slides;               /* of modes: in the run, and with this factor */
    ptrdiff_t n_threads;
    int mode;
    double share;                 /* of the residual that conjugate gradients may leave */
    int64_t sweeps, products;     /* since construction */
    double extra;                 /* operations of solves so far beyond one sweep for each */
    double per_sweep, per_round;  /* operations */
    double per_slide;
    /* What the fronts are working on. */
    const double *values, *from;
    double *into;
    const float *of, *less;
    float *to;
    double shift, weight;
    double sum[IC_FRONTS + 1];
    ptrdiff_t bad[IC_FRONTS + 1];
} ic;

#define IC_INLINE static inline __attribute__((always_inline))

typedef int32_t ic_mask __attribute__((vector_size(16)));

IC_INLINE float *ic_factor_singles(const ic *self) { return (float *)self->blocks; }
IC_INLINE float *ic_matrix_singles(const ic *self)
{
    return (float *)self->blocks + IC_BLOCK * self->n_blocks;
}

/* Do something for both fronts, the middle not included. */
static void ic_on_fronts(ic *self, ancf_part work)
{
    if (self->n_threads > 1)
        ancf_in_parts(IC_FRONTS, work, self);
    else
        for (ptrdiff_t front = 0; front < IC_FRONTS; ++front)
            work(self, front);
}

/* Where passes over vectors end that take the middle with the second front. */
IC_INLINE ptrdiff_t ic_end(const ic *self, ptrdiff_t front)
{
    return front == IC_FRONTS - 1 ? self->n_triples : self->first[front + 1];
}

/* Triples of the middle. */
IC_INLINE ptrdiff_t ic_width(const ic *self) { return self->n_triples - self->first[IC_MIDDLE]; }

#endif
