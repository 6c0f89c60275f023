/* Solves with an incomplete factor: one sweep, or conjugate gradients with sweeps and the matrix. */
#ifndef ANCF_IC_SOLVE_H
#define ANCF_IC_SOLVE_H

#include "ic_border.h"
#include "ic_coarse.h"
#include "ic_sweeps.h"

/* If a first solve takes at most this many sweeps, one per correction is enough; limit on iterations. */
enum { IC_FEW = 3, IC_MOST_ROUNDS = 200 };
/* Number of iterations from which modes are tried; they must save a third of them. */
enum { IC_MANY = 6 };
/* Number of unknowns from which the magnitude of a residual is estimated. */
enum { IC_SAMPLE = 256 };

/* Apply to z, which equals r, the preconditioner with its modes or equations; returns r.z. */
static double ic_precondition(ic *self)
{
    double sum;
    if (ic_is_sticking(self))
        return ic_hold(self, NULL, self->r, self->z, self->border.of_z);
    sum = ic_sweep(self, self->r, self->z);
    return self->slides ? sum + ic_slide_after(self) : sum;
}

/* x = 0 */
static void ic_clear_x(void *context, ptrdiff_t front)
{
    const ic *self = context;
    ptrdiff_t begin = self->first[front];
    memset(self->x + IC_TRIPLE * begin, 0, IC_TRIPLE * (ic_end(self, front) - begin) * sizeof(float));
}

/* x += weight p, r -= weight z, z = r */
static void ic_step(void *context, ptrdiff_t front)
{
    const ic *self = context;
    float weight = (float)self->weight, *x = self->x, *r = self->r, *z = self->z;
    const float *p = self->p;
    ptrdiff_t end = IC_TRIPLE * ic_end(self, front);
    for (ptrdiff_t k = IC_TRIPLE * self->first[front]; k < end; k += 4) {
        short_quad left = ic_get(r + k) - weight * ic_get(z + k);
        ic_put(x + k, ic_get(x + k) + weight * ic_get(p + k));
        ic_put(r + k, left);
        ic_put(z + k, left);
    }
}

/* p = z + weight p */
static void ic_turn(void *context, ptrdiff_t front)
{
    const ic *self = context;
    float weight = (float)self->weight, *p = self->p;
    ptrdiff_t end = IC_TRIPLE * ic_end(self, front);
    for (ptrdiff_t k = IC_TRIPLE * self->first[front]; k < end; k += 4)
        ic_put(p + k, ic_get(self->z + k) + weight * ic_get(p + k));
}

/* to = a + weight from, for multipliers */
static void ic_border_sum(const ic *self, double *to, const double *a, double weight, const double *from)
{
    for (ptrdiff_t i = 0; i < self->border.n; ++i)
        to[i] = a[i] + weight * from[i];
}

/* Conjugate gradients from x = 0 until z.r is reduced by share^2; returns the number of iterations.  They
 * stop at a direction of negative curvature with the current iterate. */
static ptrdiff_t ic_conjugate(ic *self, double share, ptrdiff_t most)
{
    const ic_border *border = &self->border;
    double zr, first, last;
    float *swap = self->p;
    ptrdiff_t k = 0;
    ic_on_fronts(self, ic_clear_x);
    first = self->slides ? ic_slide_first(self) : 0.0;
    if (ic_is_sticking(self))
        first = ic_hold_first(self);
    ic_copy_all(self, self->r, self->z);
    zr = ic_precondition(self);
    first += zr;
    self->p = self->z; /* which is overwritten next */
    self->z = swap;
    ic_border_sum(self, border->of_p, border->of_z, 0.0, border->of_z);
    while (k < most) {
        double curvature = ic_product(self, self->p, self->z);
        if (ic_is_sticking(self))
            curvature += ic_add_border(self);
        if (!(curvature > 0.0)) { /* true for NaN */
            if (k == 0)
                for (ptrdiff_t i = 0; i < IC_TRIPLE * self->n_triples; i += 4)
                    ic_put(self->x + i, ic_get(self->x + i) + ic_get(self->p + i));
            if (k == 0)
                ic_border_sum(self, border->of_x, border->of_x, 1.0, border->of_p);
            break;
        }
        ++k;
        self->weight = zr / curvature;
        ic_on_fronts(self, ic_step);
        ic_border_sum(self, border->of_x, border->of_x, self->weight, border->of_p);
        last = zr;
        zr = ic_precondition(self);
        if (!(zr > share * share * first))
            break;
        self->weight = zr / last;
        ic_on_fronts(self, ic_turn);
        ic_border_sum(self, border->of_p, border->of_z, self->weight, border->of_p);
    }
    self->extra += k * self->per_round + (self->slides ? (k + 2) * self->per_slide : 0.0);
    return k;
}

/* Largest |scaled residual| over every step-th unknown. */
static double ic_largest(const ic *self, const double *r, ptrdiff_t step)
{
    double largest = 0.0;
    for (ptrdiff_t j = 0; j < self->n; j += step)
        largest = fmax(largest, fabs(r[j] * self->scale[j]));
    return largest;
}

/* The unknowns of consecutive triples are scattered in memory: they are prefetched this many triples
 * ahead. */
enum { IC_AHEAD = 24 };

IC_INLINE ptrdiff_t ic_ahead(const ic *self, ptrdiff_t t)
{
    ptrdiff_t last = self->n_triples - 1;
    int32_t at = self->unknown[3 * (t + IC_AHEAD < last ? t + IC_AHEAD : last)];
    return at < 0 ? 0 : at;
}

static void ic_gather_front(void *context, ptrdiff_t front)
{
    const ic *self = context;
    const double *from = self->from;
    double weight = self->weight;
    for (ptrdiff_t t = self->first[front]; t < ic_end(self, front); ++t) {
        const int32_t *at = self->unknown + 3 * t;
        const double *scale = self->scale_of + 3 * t;
        __builtin_prefetch(from + ic_ahead(self, t));
        for (int k = 0; k < 3; ++k)
            self->to[IC_TRIPLE * t + k] = at[k] < 0 ? 0.0f : (float)(from[at[k]] * scale[k] * weight);
    }
}

static void ic_scatter_front(void *context, ptrdiff_t front)
{
    const ic *self = context;
    double *into = self->into, weight = self->weight;
    for (ptrdiff_t t = self->first[front]; t < ic_end(self, front); ++t) {
        const int32_t *at = self->unknown + 3 * t;
        const double *scale = self->scale_of + 3 * t;
        __builtin_prefetch(into + ic_ahead(self, t), 1);
        for (int k = 0; k < 3; ++k)
            if (at[k] >= 0)
                into[at[k]] = self->x[IC_TRIPLE * t + k] * scale[k] * weight;
    }
}

/* Copy a residual, scaled by a power of two to the middle of the range of single precision; returns the
 * exponent.  A few unknowns suffice to choose it: the range exceeds them by thirty powers of ten. */
static int ic_gather(ic *self, const double *r, float *out)
{
    int power = 0;
    double largest = ic_largest(self, r, self->n / IC_SAMPLE + 1);
    if (largest == 0.0)
        largest = ic_largest(self, r, 1);
    largest = fmax(largest, ic_largest_off(&self->border, r + self->n));
    if (largest < INFINITY)
        frexp(largest, &power);
    self->from = r, self->to = out, self->weight = ldexp(1.0, -power);
    ic_on_fronts(self, ic_gather_front);
    for (ptrdiff_t i = 0; i < self->border.n; ++i)
        self->border.off[i] = self->weight * r[self->n + i];
    return power;
}

static void ic_scatter(ic *self, double *out, int power)
{
    self->into = out, self->weight = ldexp(1.0, power);
    ic_on_fronts(self, ic_scatter_front);
    for (ptrdiff_t i = 0; i < self->border.n; ++i)
        out[self->n + i] = self->weight * self->border.of_x[i];
}

/* Solve for the same right-hand side with the modes, which are kept if that takes fewer iterations. */
static void ic_try_modes(ic *self, const double *r, ptrdiff_t rounds)
{
    self->use = IC_LEFT;
    if (!ic_find_modes(self))
        return;
    self->slides = 1;
    ic_gather(self, r, self->r);
    if (3 * ic_conjugate(self, self->share, IC_MOST_ROUNDS) <= 2 * rounds)
        self->use = IC_KEPT;
    self->slides = self->use == IC_KEPT;
}

static void ic_solve(void *context, const double *r, double *x)
{
    ic *self = context;
    int plain = self->mode == IC_PLAIN;
    int power = ic_gather(self, r, plain && !ic_is_sticking(self) ? self->x : self->r);
    if (plain && ic_is_sticking(self)) {
        ic_hold(self, self->border.off, self->r, self->x, self->border.of_x);
    } else if (plain) {
        ic_sweep(self, NULL, self->x);
    } else {
        ptrdiff_t rounds = ic_conjugate(self, self->share, IC_MOST_ROUNDS);
        if (self->mode == IC_PROBE)
            self->mode = rounds + 1 <= IC_FEW && !self->slides ? IC_PLAIN : IC_INNER;
        if (self->use == IC_UNTRIED && self->modes.factor != NULL && rounds >= IC_MANY)
            ic_try_modes(self, r, rounds);
    }
    ic_scatter(self, x, power);
}

/* Reduce the residual to this fraction until the next factorization; returns whether that is a change. */
static int ic_refine(void *context, double share)
{
    ic *self = context;
    if (self->mode != IC_PLAIN && self->share <= share)
        return 0;
    self->mode = IC_INNER;
    self->share = share;
    return 1;
}

#endif
