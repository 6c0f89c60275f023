/* An incomplete block Cholesky factor: the matrix, and the storage of its parts.
 *
 * The unknowns are grouped in triples, a position or a slope in space; vectors with fixed or fewer
 * coordinates are padded by ones on the diagonal.  The factor
 *
 *     A ~ (I + N) D (I + N)^T,   N strictly lower,
 *
 * has the block pattern of A; fill-in is dropped.  On a tree whose leaves are eliminated first there is no
 * fill-in.
 *
 * The order is: two fronts of triples, which are not coupled, then the middle, which is coupled to both.
 * Each front can run on its own thread.  Updates of the middle by the second front go to a copy, its
 * image, so results do not depend on the number of threads.
 *
 * A block has nine numbers, by columns.  Blocks are factored in double precision, then rounded to single
 * precision into the first half of their memory, and A itself into the second half, since sweeps are
 * limited by memory bandwidth.  The matrix is scaled symmetrically by powers of two, so that its diagonal
 * is near one and no unit of mass or length exceeds the range of single precision.
 */
#ifndef ANCF_IC_H
#define ANCF_IC_H

#include <math.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include "parallel.h"
#include "simd4.h"
#include "solver_abi.h"

/* Sizes of a block and of a triple of unknowns in vectors; numbers read past the end of the last block. */
enum { IC_BLOCK = 9, IC_TRIPLE = 4, IC_PAST = 4 };
/* Number of fronts, each with its own thread if there are two; index of the middle. */
enum { IC_FRONTS = 2, IC_MIDDLE = 2 };

/* Relative residual of conjugate gradients for a correction that is followed by others. */
#define IC_LOOSE 0.1

/* Kind of a solve: conjugate gradients whose iteration count selects the next kind; a sweep; or
 * conjugate gradients. */
enum { IC_PROBE, IC_PLAIN, IC_INNER };

/* Modes along which cables slide, see ic_coarse.h: the displacement ("way") of each triple in a mode. */
typedef struct {
    ptrdiff_t n, n_ways, n_terms, n_values;
    ptrdiff_t first[IC_FRONTS + 1]; /* first way of each front, the middle with the second; the end */
    const int32_t *triple, *mode;   /* of each way, sorted by triples */
    const float *direction;         /* three numbers per way */
    float *way;                     /* four numbers, scaled like the matrix */
    const int32_t *block, *row, *column, *place; /* terms of E: block, two ways, index in E */
    double *values, *sums;          /* of E, twice; two per mode and front */
    const ancf_seed *factor;        /* of E; NULL without modes */
} ic_modes;

/* Constraints that are satisfied exactly, see ic_border.h. */
typedef struct {
    ptrdiff_t n, n_own;      /* number of equations; of entries in their diagonal block */
    const int32_t *first;    /* first term of each equation, and the end */
    const int64_t *entry;    /* index of each term in the values of the matrix */
    const int32_t *unknown, *place; /* its coordinate, and the index of that in vectors over triples */
    const int64_t *own;      /* indices of -E in the values, and in S */
    const int32_t *own_place;
    double *term, *schur;    /* B by equations, scaled; S by rows, or its factor */
    double *size;            /* 1 / sqrt of the diagonal of S */
    double *off, *of_x, *of_p, *of_z, *sums; /* g, multipliers of the vectors, workspace */
} ic_border;

typedef struct {
    ptrdiff_t n, n_triples, n_blocks; /* blocks: those on the diagonal, then those below it */
    ptrdiff_t first[IC_FRONTS + 2];   /* first triple of each front and of the middle, and the end */
    ptrdiff_t longest;                /* number of blocks in the longest column */
    const int64_t *indptr;            /* lower triangle of A by columns */
    const int32_t *indices;
    const int32_t *unknown;        /* three per triple, in order of elimination; -1: none */
    const int32_t *start;          /* first block below the diagonal of each column, and the end */
    const int32_t *row;            /* triple of each of these, ascending; of the second front in its image */
    const int32_t *place_of_entry; /* index of each entry of A in `blocks` */
    double *scale;                 /* of each unknown; of equations one */
    double *scale_of;              /* of the three unknowns of each triple */
    double *blocks;                /* followed by the image of those of the middle */
    double *column;                /* workspace for the longest column of each front */
    float *x, *r, *z, *p, *w;      /* vectors over the triples and the image of the middle */
    ic_modes modes;
    ic_border border;
    int use, slides;               /* of modes: in the run, and with this factor */
    ptrdiff_t n_threads;
    int mode;
    double share;                 /* relative residual of conjugate gradients */
    int64_t sweeps, products;     /* since construction */
    double extra;                 /* operations of all solves so far in excess of one sweep each */
    double per_sweep, per_round;  /* operations */
    double per_slide;
    /* Arguments of the current parallel operation. */
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

/* Call a function for both fronts, without the middle. */
static void ic_on_fronts(ic *self, ancf_part work)
{
    if (self->n_threads > 1)
        ancf_in_parts(IC_FRONTS, work, self);
    else
        for (ptrdiff_t front = 0; front < IC_FRONTS; ++front)
            work(self, front);
}

/* End of the range of a front in vector operations, the middle belonging to the second one. */
IC_INLINE ptrdiff_t ic_end(const ic *self, ptrdiff_t front)
{
    return front == IC_FRONTS - 1 ? self->n_triples : self->first[front + 1];
}

/* Number of triples of the middle. */
IC_INLINE ptrdiff_t ic_width(const ic *self) { return self->n_triples - self->first[IC_MIDDLE]; }

#endif
