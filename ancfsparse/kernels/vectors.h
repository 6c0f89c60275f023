/* Passes over long vectors.  Sums run in several lanes at once, which a compiler may not do by itself;
 * the order is fixed by the instruction set, so a run repeats bit for bit.
 */
#ifndef ANCF_VECTORS_H
#define ANCF_VECTORS_H

#include <stddef.h>

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

#endif
