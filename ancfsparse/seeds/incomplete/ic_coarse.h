/* A coarse space for long steps: each cable can slide along itself.
 *
 * In a step longer than the time in which an axial wave traverses a cable, the cable acts as axially rigid
 * but free to slide, restrained only by the bending of the cables it crosses.  There is one such mode per
 * cable, a column of Z, and a factor without fill-in does not capture them.  Conjugate gradients start
 * from, and each sweep is followed by, the correction
 *
 *     Z E^-1 Z^T (r - A y),   E ~ Z^T A Z ,
 *
 * where E omits the coupling of cables at about right angles, which is far weaker: so the cost of its
 * factor is negligible in lattices.
 */
#ifndef ANCF_IC_COARSE_H
#define ANCF_IC_COARSE_H

#include "ic_sweeps.h"

/* Use of the modes: not tried yet, always, never. */
enum { IC_UNTRIED, IC_KEPT, IC_LEFT };

IC_INLINE double ic_dot(short_quad a, short_quad b) { return quad_sum(ic_products(a, b)); }

/* Scale the modes, for the ways of a front. */
static void ic_scale_ways(void *context, ptrdiff_t front)
{
    const ic *self = context;
    const ic_modes *modes = &self->modes;
    for (ptrdiff_t e = modes->first[front]; e < modes->first[front + 1]; ++e) {
        const int32_t *at = self->unknown + 3 * modes->triple[e];
        for (int k = 0; k < 3; ++k)
            modes->way[4 * e + k] =
                at[k] < 0 ? 0.0f : (float)(modes->direction[3 * e + k] / self->scale[at[k]]);
    }
}

/* A share of the terms of E, from the matrix in single precision. */
static void ic_add_terms(void *context, ptrdiff_t front)
{
    const ic *self = context;
    const ic_modes *modes = &self->modes;
    const float *matrix = ic_matrix_singles(self);
    double *values = modes->values + front * modes->n_values;
    ptrdiff_t end = modes->n_terms * (front + 1) / IC_FRONTS;
    memset(values, 0, modes->n_values * sizeof(double));
    for (ptrdiff_t k = modes->n_terms * front / IC_FRONTS; k < end; ++k) {
        ptrdiff_t block = modes->block[k], row = modes->row[k], column = modes->column[k];
        short_quad a[3];
        ic_columns(a, matrix + IC_BLOCK * block);
        double term = ic_dot(ic_get(modes->way + 4 * row),
                             ic_three(ic_times(a, ic_get(modes->way + 4 * column))));
        int twice = block >= self->n_triples && modes->mode[row] == modes->mode[column];
        values[modes->place[k]] += twice ? 2.0 * term : term;
    }
}

/* Find the modes and E; whether it could be factored. */
static int ic_find_modes(ic *self)
{
    const ic_modes *modes = &self->modes;
    ic_on_fronts(self, ic_scale_ways);
    ic_on_fronts(self, ic_add_terms);
    for (ptrdiff_t k = 0; k < modes->n_values; ++k)
        modes->values[k] += modes->values[modes->n_values + k];
    return modes->factor->factor(modes->factor->context, modes->values) == 0;
}

/* Z^T of `of`, and of `less` if given, for a front, the middle belonging to the second one. */
static void ic_project(void *context, ptrdiff_t front)
{
    ic *self = context;
    const ic_modes *modes = &self->modes;
    double *sum = modes->sums + 2 * front * modes->n, *left = sum + modes->n;
    memset(sum, 0, 2 * modes->n * sizeof(double));
    for (ptrdiff_t e = modes->first[front]; e < modes->first[front + 1]; ++e) {
        ptrdiff_t at = IC_TRIPLE * (ptrdiff_t)modes->triple[e];
        short_quad way = ic_get(modes->way + 4 * e);
        sum[modes->mode[e]] += ic_dot(way, ic_get(self->of + at));
        if (self->less != NULL)
            left[modes->mode[e]] += ic_dot(way, ic_get(self->less + at));
    }
}

/* to += Z times the coefficients */
static void ic_prolong(void *context, ptrdiff_t front)
{
    ic *self = context;
    const ic_modes *modes = &self->modes;
    const double *coefficient = modes->sums + modes->n;
    for (ptrdiff_t e = modes->first[front]; e < modes->first[front + 1]; ++e) {
        float *to = self->to + IC_TRIPLE * (ptrdiff_t)modes->triple[e];
        ic_put(to, ic_get(to) + (float)coefficient[modes->mode[e]] * ic_get(modes->way + 4 * e));
    }
}

/* to += Z E^-1 Z^T (of - less); returns the work of `of` along that. */
static double ic_slide(ic *self, const float *of, const float *less, float *to)
{
    ic_modes *modes = &self->modes;
    ptrdiff_t n = modes->n;
    double *whole = modes->sums, *held = whole + n, work = 0.0;
    self->of = of, self->less = less, self->to = to;
    ic_on_fronts(self, ic_project);
    for (ptrdiff_t k = 0; k < n; ++k) {
        whole[k] += whole[2 * n + k];
        held[k] = whole[k] - (held[k] + held[2 * n + k]);
    }
    modes->factor->solve(modes->factor->context, held, held);
    for (ptrdiff_t k = 0; k < n; ++k)
        work += whole[k] * held[k];
    ic_on_fronts(self, ic_prolong);
    return work;
}

/* x += Z E^-1 Z^T r, r -= A x, from x = 0; returns the work of r along x. */
static double ic_slide_first(ic *self)
{
    double work = ic_slide(self, self->r, NULL, self->x);
    ic_product(self, self->x, self->w);
    ic_on_fronts(self, ic_leave);
    return work;
}

/* z += Z E^-1 Z^T (r - A z); returns the change of r.z. */
static double ic_slide_after(ic *self)
{
    ic_product(self, self->z, self->w);
    return ic_slide(self, self->r, self->w, self->z);
}

#endif
