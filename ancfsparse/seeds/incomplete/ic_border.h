/* A few constraints in addition to an incomplete factor M ~ A, satisfied exactly.
 *
 * For the system with multipliers l of equations B x - E l = g,
 *
 *     [ A   B^T ] [ x ]   [ f ]
 *     [ B   -E  ] [ l ] = [ g ] ,   E diagonal or nearly so, positive,
 *
 * a sweep solves it with A replaced by M: l = S^-1 (B M^-1 f - g), x = M^-1 (f - B^T l), with the Schur
 * complement S = B M^-1 B^T + E, which is small and dense.  The remaining residual is zero in the
 * constraints, and conjugate gradients with this (constraint) preconditioner keep it so: in exact
 * arithmetic they are those of A + B^T E^-1 B, which is positive definite (Gould, Hribar, Nocedal 2001;
 * Dollar, Gould, Schilders, Wathen 2006).
 */
#ifndef ANCF_IC_BORDER_H
#define ANCF_IC_BORDER_H

#include "ic_sweeps.h"

/* Pivots of S below this fraction of the diagonal entry are rounding: the equation depends on others,
 * and its multiplier is not changed. */
#define IC_DEPENDENT 1e-5

IC_INLINE int ic_is_sticking(const ic *self) { return self->border.n > 0; }

/* out = B x */
static void ic_pull(const ic_border *border, const float *x, double *out)
{
    for (ptrdiff_t i = 0; i < border->n; ++i) {
        out[i] = 0.0;
        for (ptrdiff_t k = border->first[i]; k < border->first[i + 1]; ++k)
            out[i] += border->term[k] * x[border->place[k]];
    }
}

/* x += weight B^T l */
static void ic_push(const ic_border *border, double weight, const double *l, float *x)
{
    for (ptrdiff_t i = 0; i < border->n; ++i)
        for (ptrdiff_t k = border->first[i]; k < border->first[i + 1]; ++k)
            x[border->place[k]] += (float)(weight * border->term[k] * l[i]);
}

/* x <- S^-1 x */
static void ic_border_solve(const ic_border *border, double *x)
{
    ptrdiff_t n = border->n;
    for (ptrdiff_t i = 0; i < n; ++i) {
        const double *row = border->schur + n * i;
        for (ptrdiff_t k = 0; k < i; ++k)
            x[i] -= row[k] * x[k];
        x[i] /= row[i];
    }
    for (ptrdiff_t i = n - 1; i >= 0; --i) {
        const double *row = border->schur + n * i;
        x[i] /= row[i];
        for (ptrdiff_t k = 0; k < i; ++k)
            x[k] -= row[k] * x[i];
    }
}

/* Cholesky factor of S, in place. */
static void ic_border_factor(ic_border *border)
{
    ptrdiff_t n = border->n;
    for (ptrdiff_t i = 0; i < n; ++i) {
        double *row = border->schur + n * i, whole = row[i];
        for (ptrdiff_t j = 0; j < i; ++j) {
            const double *other = border->schur + n * j;
            for (ptrdiff_t k = 0; k < j; ++k)
                row[j] -= row[k] * other[k];
            row[j] /= other[j];
            row[i] -= row[j] * row[j];
        }
        row[i] = row[i] > IC_DEPENDENT * whole ? sqrt(row[i]) : INFINITY;
        border->size[i] = whole > 0.0 ? 1.0 / sqrt(whole) : 0.0;
    }
}

/* Set B and S from the values and the factor: one sweep per equation. */
static void ic_find_border(ic *self)
{
    ic_border *border = &self->border;
    ptrdiff_t n = border->n;
    int64_t sweeps = self->sweeps;
    for (ptrdiff_t k = 0; k < border->first[n]; ++k)
        border->term[k] = self->values[border->entry[k]] * self->scale[border->unknown[k]];
    for (ptrdiff_t i = 0; i < n; ++i) {
        memset(self->x, 0, IC_TRIPLE * self->n_triples * sizeof(float));
        for (ptrdiff_t k = border->first[i]; k < border->first[i + 1]; ++k)
            self->x[border->place[k]] += (float)border->term[k];
        ic_sweep(self, NULL, self->x);
        ic_pull(border, self->x, border->schur + n * i);
    }
    for (ptrdiff_t k = 0; k < border->n_own; ++k)
        border->schur[border->own_place[k]] -= self->values[border->own[k]];
    ic_border_factor(border);
    self->sweeps = sweeps;
}

/* Largest violation of the equations, relative to the effect of a unit residual on them. */
static double ic_largest_off(const ic_border *border, const double *g)
{
    double largest = 0.0;
    for (ptrdiff_t i = 0; i < border->n; ++i)
        largest = fmax(largest, fabs(g[i] * border->size[i]));
    return largest;
}

/* l = S^-1 (B M^-1 r - g), z = M^-1 (r - B^T l); returns r.z.  NULL: g is zero. */
static double ic_hold(ic *self, const double *g, const float *r, float *z, double *l)
{
    const ic_border *border = &self->border;
    ic_copy_all(self, r, z);
    ic_sweep(self, NULL, z);
    ic_pull(border, z, l);
    for (ptrdiff_t i = 0; g != NULL && i < border->n; ++i)
        l[i] -= g[i];
    ic_border_solve(border, l);
    ic_copy_all(self, r, z);
    ic_push(border, -1.0, l, z);
    return ic_sweep(self, r, z);
}

/* Set x to satisfy the equations, r -= A x + B^T l; returns the work along x. */
static double ic_hold_first(ic *self)
{
    const ic_border *border = &self->border;
    const double *g = border->off;
    double *l = border->of_x, work = 0.0;
    int off = 0;
    for (ptrdiff_t i = 0; i < border->n; ++i) {
        l[i] = -g[i];
        off |= g[i] != 0.0;
    }
    if (!off)
        return 0.0;
    ic_border_solve(border, l);
    for (ptrdiff_t i = 0; i < border->n; ++i)
        work -= l[i] * g[i];
    ic_push(border, -1.0, l, self->x);
    ic_sweep(self, NULL, self->x);
    ic_product(self, self->x, self->w);
    ic_on_fronts(self, ic_leave);
    ic_push(border, -1.0, l, self->r);
    self->extra += self->per_round;
    return work;
}

/* z += B^T l of p; returns the change of p.z. */
static double ic_add_border(ic *self)
{
    const ic_border *border = &self->border;
    double sum = 0.0;
    ic_pull(border, self->p, border->sums);
    ic_push(border, 1.0, border->of_p, self->z);
    for (ptrdiff_t i = 0; i < border->n; ++i)
        sum += border->of_p[i] * border->sums[i];
    return sum;
}

#endif
