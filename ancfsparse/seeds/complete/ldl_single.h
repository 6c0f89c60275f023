/* The factor rounded to single precision, so that a solve reads half as much memory.
 *
 * It is rounded in place, without extra memory: the numbers of each part, and those of the root, are
 * packed into the first half of their range.  The unknowns of a solve remain in double precision.  The
 * next factorization starts again from the matrix in double precision.
 */
#ifndef ANCF_LDL_SINGLE_H
#define ANCF_LDL_SINGLE_H

#include "ldl.h"
#include "parallel.h"

static void ldl_round_numbers(double *x, ptrdiff_t n)
{
    ldl_single *out = (ldl_single *)x;
    ptrdiff_t i = 0;
    for (; i + 4 <= n; i += 4)
        *(short_quad *)(out + i) = __builtin_convertvector(quad_load(x + i), short_quad);
    for (; i < n; ++i)
        out[i] = (float)x[i];
    /* Numbers read past the end are multiplied by zero, so they must be finite; shorter ranges are not
     * read in fours. */
    for (ptrdiff_t k = 0; n > LDL_TAIL && k < LDL_TAIL; ++k)
        out[n + k] = 0.0f;
}

/* Round the factor of supernodes s to end. */
static void ldl_round_range(const ldl *self, ptrdiff_t s, ptrdiff_t end)
{
    ldl_round_numbers(self->diagonal + self->first[s], self->first[end] - self->first[s]);
    ldl_round_numbers(self->triangle + self->triangle_start[s],
                      self->triangle_start[end] - self->triangle_start[s]);
    ldl_round_numbers(self->block + self->block_start[s],
                      self->block_start[end] - self->block_start[s]);
}

static void ldl_round_part(void *context, ptrdiff_t part)
{
    const ldl *self = context;
    ldl_round_range(self, self->part[part], self->part[part + 1]);
}

static void ldl_round(void *context)
{
    ldl *self = context;
    if (self->is_single)
        return;
    ancf_in_parts(self->n_parts, ldl_round_part, self);
    ldl_round_range(self, self->part[self->n_parts], self->n_super);
    self->is_single = 1;
}

#endif
