/* A coarse space for long steps: each cable may slide along itself.
 *
 * A step in which a wave runs along a whole cable leaves it stiff in itself and free to slide, held by the
 * bending of those that it crosses.  There are as many such modes Z as cables, and a factor without fill
 * does not see them.  Conjugate gradients start from, and each sweep is followed by, the correction
 *
 *     Z E^-1 Z^T (r - A y),   E ~ Z^T A Z ,
 *
 * where E leaves out what couples cables at about right angles, which is less by far: so its factor costs
 * next to nothing in lattices.
 */
#ifndef ANCF_IC_COARSE_H
#define ANCF_IC_COARSE_H

#include "ic_sweeps.h"

/* Whether the modes are used: not tried yet, always, never. */
enum { IC_UNTRIED, IC_KEPT, IC_LEFT };

IC_INLINE double ic_dot(short_quad a, short_quad b) { return quad_sum(ic_products(a, b)); }

/* The modes in our scale, and E from the matrix in single precision; whether it could be factored. */
static int ic_find_modes(ic *self)
{
    ic_modes *modes = &self->modes;
    const float *matrix = ic_matrix_singles(self);
    for (ptrdiff_t e = 0; e < modes->n_ways; ++e) {
        const int32_t *at = self->unknown + 3 * modes->triple[e];
        for (int k = 0; k < 3; ++k)
            modes->way[4 * e + k] =
                at[k] < 0 ? 0.0f : (float)(modes->direction[3 * e + k] / self->scale[at[k]]);
    }
    memset(modes->values, 0, modes->n_values * sizeof(double));
    for (ptrdiff_t k = 0; k < modes->n_terms; ++k) {
        ptrdiff_t block = modes->block[k], row = modes->row[k], column = modes->column[k];
        short_quad a[3];
        ic_columns(a, matrix + IC_BLOCK * block);
        double term = ic_dot(ic_get(modes->way + 4 * row),
                             ic_three(ic_times(a, ic_get(modes->way + 4 * column))));
        int twice = block >= self->n_triples && modes->mode[row] == modes->mode[column];
        modes->values[modes->place[k]] += twice ? 2.0 * term : term;
    }
    return modes->factor->factor(modes->factor->context, modes->values) == 0;
}

/* Z^T of a vector, of a front and, with the second one, of the middle. */
static void ic_project(void *context, ptrdiff_t front)
{
    ic *self = context;
    const ic_modes *modes = &self->modes;
    double *sum = modes->sums + front * modes->n;
    memset(sum, 0, modes->n * sizeof(double));
    for (ptrdiff_t e = modes->first[front]; e < modes->first[front + 1]; ++e)
        sum[modes->mode[e]] += ic_dot(ic_get(modes->way + 4 * e),
                                      ic_get(self->of + IC_TRIPLE * (ptrdiff_t)modes->triple[e]));
}

/* to += Z of the coefficients */
static void ic_prolong(void *context, ptrdiff_t front)
{
    ic *self = context;
    const ic_modes *modes = &self->modes;
    for (ptrdiff_t e = modes->first[front]; e < modes->first[front + 1]; ++e) {
        float *to = self->to + IC_TRIPLE * (ptrdiff_t)modes->triple[e];
        ic_put(to, ic_get(to) + (float)modes->sums[modes->mode[e]] * ic_get(modes->way + 4 * e));
    }
}

/* to += Z E^-1 Z^T of; the work of `of` along that */
static double ic_slide(ic *self, const float *of, float *to)
{
    ic_modes *modes = &self->modes;
    double *sum = modes->sums, *held = modes->sums + modes->n, work = 0.0;
    self->of = of, self->to = to;
    ic_on_fronts(self, ic_project);
    for (ptrdiff_t k = 0; k < modes->n; ++k)
        held[k] = sum[k] += held[k];
    modes->factor->solve(modes->factor->context, held, sum);
    for (ptrdiff_t k = 0; k < modes->n; ++k)
        work += held[k] * sum[k];
    ic_on_fronts(self, ic_prolong);
    return work;
}

/* w = r - w */
static void ic_leave(void *context, ptrdiff_t front)
{
    const ic *self = context;
    ptrdiff_t end = IC_TRIPLE * ic_end(self, front);
    for (ptrdiff_t k = IC_TRIPLE * self->first[front]; k < end; k += 4)
        ic_put(self->w + k, ic_get(self->r + k) - ic_get(self->w + k));
}

/* The sum of r z */
static void ic_work(void *context, ptrdiff_t front)
{
    ic *self = context;
    ptrdiff_t end = IC_TRIPLE * ic_end(self, front);
    quad sum = {0};
    for (ptrdiff_t k = IC_TRIPLE * self->first[front]; k < end; k += 4)
        sum += ic_products(ic_get(self->r + k), ic_get(self->z + k));
    self->sum[front] = quad_sum(sum);
}

/* x = Z E^-1 Z^T r, r -= A x; the work of r along x */
static double ic_slide_first(ic *self)
{
    double work = ic_slide(self, self->r, self->x);
    ic_product(self, self->x, self->w);
    ic_on_fronts(self, ic_leave);
    memcpy(self->r, self->w, IC_TRIPLE * self->n_triples * sizeof(float));
    return work;
}

/* z += Z E^-1 Z^T (r - A z); the sum of r z */
static double ic_slide_after(ic *self)
{
    ic_product(self, self->z, self->w);
    ic_on_fronts(self, ic_leave);
    ic_slide(self, self->w, self->z);
    ic_on_fronts(self, ic_work);
    return self->sum[0] + self->sum[1];
}

#endif
