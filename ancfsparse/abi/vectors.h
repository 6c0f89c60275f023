/* Operations on long vectors.  Sums are accumulated in several lanes, which a compiler may not do by
 * itself; the order is fixed by the instruction set, so runs are reproducible bit for bit.
 *
 * Operations in parts work on contiguous pieces, each on its own thread, and the sums of the parts are
 * added in order: runs with the same number of parts are reproducible bit for bit.
 */
#ifndef ANCF_VECTORS_H
#define ANCF_VECTORS_H

#include <stddef.h>

#include "parallel.h"
#include "simd.h"

static inline double vec_total(vec v)
{
#if ANCF_LANES == 1
    return v;
#else
    double total = v[0];
    for (int lane = 1; lane < ANCF_LANES; ++lane)
        total += v[lane];
    return total;
#endif
}

static inline double vec_dot(const double *x, const double *y, ptrdiff_t n)
{
    vec t0 = {0}, t1 = {0};
    double rest = 0.0;
    ptrdiff_t i = 0;
    for (; i + 2 * ANCF_LANES <= n; i += 2 * ANCF_LANES) {
        t0 += vec_load(x + i) * vec_load(y + i);
        t1 += vec_load(x + i + ANCF_LANES) * vec_load(y + i + ANCF_LANES);
    }
    for (; i + ANCF_LANES <= n; i += ANCF_LANES)
        t0 += vec_load(x + i) * vec_load(y + i);
    for (; i < n; ++i)
        rest += x[i] * y[i];
    return vec_total(t0 + t1) + rest;
}

/* Sum of w x^2. */
static inline double vec_weigh(const double *w, const double *x, ptrdiff_t n)
{
    vec total = {0};
    double rest = 0.0;
    ptrdiff_t i = 0;
    for (; i + ANCF_LANES <= n; i += ANCF_LANES)
        total += vec_load(w + i) * vec_load(x + i) * vec_load(x + i);
    for (; i < n; ++i)
        rest += w[i] * x[i] * x[i];
    return vec_total(total) + rest;
}

/* Sum of w (x - y)^2. */
static inline double vec_weigh_apart(const double *w, const double *x, const double *y, ptrdiff_t n)
{
    vec total = {0}, apart;
    double rest = 0.0;
    ptrdiff_t i = 0;
    for (; i + ANCF_LANES <= n; i += ANCF_LANES) {
        apart = vec_load(x + i) - vec_load(y + i);
        total += vec_load(w + i) * apart * apart;
    }
    for (; i < n; ++i)
        rest += w[i] * (x[i] - y[i]) * (x[i] - y[i]);
    return vec_total(total) + rest;
}

/* Sum of x^2 / w. */
static inline double vec_weigh_dual(const double *w, const double *x, ptrdiff_t n)
{
    vec total = {0};
    double rest = 0.0;
    ptrdiff_t i = 0;
    for (; i + ANCF_LANES <= n; i += ANCF_LANES)
        total += vec_load(x + i) * vec_load(x + i) / vec_load(w + i);
    for (; i < n; ++i)
        rest += x[i] * x[i] / w[i];
    return vec_total(total) + rest;
}

typedef struct {
    ptrdiff_t n_parts, n;
    double a, b;
    const double *x, *y;
    double *out;
} vec_pass;

/* First entry of a part: each part has whole cache lines. */
static inline ptrdiff_t vec_begin(const vec_pass *pass, ptrdiff_t part)
{
    return part == pass->n_parts ? pass->n : pass->n / 8 * part / pass->n_parts * 8;
}

static inline void vec_scale_range(double *out, double a, const double *x, ptrdiff_t i, ptrdiff_t end)
{
    for (; i < end; ++i)
        out[i] = a * x[i];
}

static inline void vec_sum_range(double *out, double a, const double *x, double b, const double *y,
                                 ptrdiff_t i, ptrdiff_t end)
{
    for (; i < end; ++i)
        out[i] = a * x[i] + b * y[i];
}

static void vec_dot_part(void *context, ptrdiff_t part)
{
    const vec_pass *pass = context;
    ptrdiff_t i = vec_begin(pass, part);
    pass->out[part] = vec_dot(pass->x + i, pass->y + i, vec_begin(pass, part + 1) - i);
}

static void vec_weigh_part(void *context, ptrdiff_t part)
{
    const vec_pass *pass = context;
    ptrdiff_t i = vec_begin(pass, part);
    pass->out[part] = vec_weigh(pass->x + i, pass->y + i, vec_begin(pass, part + 1) - i);
}

static void vec_weigh_dual_part(void *context, ptrdiff_t part)
{
    const vec_pass *pass = context;
    ptrdiff_t i = vec_begin(pass, part);
    pass->out[part] = vec_weigh_dual(pass->x + i, pass->y + i, vec_begin(pass, part + 1) - i);
}

static void vec_scale_part(void *context, ptrdiff_t part)
{
    const vec_pass *pass = context;
    vec_scale_range(pass->out, pass->a, pass->x, vec_begin(pass, part), vec_begin(pass, part + 1));
}

static void vec_sum_part(void *context, ptrdiff_t part)
{
    const vec_pass *pass = context;
    vec_sum_range(pass->out, pass->a, pass->x, pass->b, pass->y, vec_begin(pass, part),
                  vec_begin(pass, part + 1));
}

static inline double vec_total_of_parts(ptrdiff_t n_parts, void (*part_of)(void *, ptrdiff_t),
                                        const double *x, const double *y, ptrdiff_t n)
{
    double sum[ANCF_MOST_PARTS], total = 0.0;
    vec_pass pass = {.n_parts = n_parts, .n = n, .x = x, .y = y, .out = sum};
    ancf_in_parts(n_parts, part_of, &pass);
    for (ptrdiff_t part = 0; part < n_parts; ++part)
        total += sum[part];
    return total;
}

/* x . y */
static inline double vec_dot_parts(ptrdiff_t n_parts, const double *x, const double *y, ptrdiff_t n)
{
    return n_parts == 1 ? vec_dot(x, y, n) : vec_total_of_parts(n_parts, vec_dot_part, x, y, n);
}

/* Sum of w x^2. */
static inline double vec_weigh_parts(ptrdiff_t n_parts, const double *w, const double *x, ptrdiff_t n)
{
    return n_parts == 1 ? vec_weigh(w, x, n) : vec_total_of_parts(n_parts, vec_weigh_part, w, x, n);
}

/* Sum of x^2 / w. */
static inline double vec_weigh_dual_parts(ptrdiff_t n_parts, const double *w, const double *x,
                                          ptrdiff_t n)
{
    return n_parts == 1 ? vec_weigh_dual(w, x, n)
                        : vec_total_of_parts(n_parts, vec_weigh_dual_part, w, x, n);
}

/* out = a x */
static inline void vec_scale_parts(ptrdiff_t n_parts, double *out, double a, const double *x,
                                   ptrdiff_t n)
{
    if (n_parts == 1) {
        vec_scale_range(out, a, x, 0, n);
        return;
    }
    vec_pass pass = {.n_parts = n_parts, .n = n, .a = a, .x = x, .out = out};
    ancf_in_parts(n_parts, vec_scale_part, &pass);
}

/* out = a x + b y */
static inline void vec_sum_parts(ptrdiff_t n_parts, double *out, double a, const double *x, double b,
                                 const double *y, ptrdiff_t n)
{
    if (n_parts == 1) {
        vec_sum_range(out, a, x, b, y, 0, n);
        return;
    }
    vec_pass pass = {.n_parts = n_parts, .n = n, .a = a, .b = b, .x = x, .y = y, .out = out};
    ancf_in_parts(n_parts, vec_sum_part, &pass);
}

#endif
