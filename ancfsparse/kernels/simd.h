/* One vector type per instruction set: `vec` holds ANCF_LANES doubles, one element in each lane.
 *
 * The vector extension of GCC and Clang supports + - * with vectors and scalars; the rest is below.  The type has the
 * alignment of a double because NumPy guarantees no more, and may alias because it reads such arrays.
 */
#ifndef ANCF_SIMD_H
#define ANCF_SIMD_H

#include <math.h>
#include <stdint.h>

#ifndef ANCF_LANES
#if defined(__AVX512F__)
#define ANCF_LANES 8
#elif defined(__AVX2__)
#define ANCF_LANES 4
#else
#define ANCF_LANES 2
#endif
#endif

#if ANCF_LANES == 1

typedef double vec;

static inline vec vec_load(const double *p) { return *p; }
static inline vec vec_gather(const double *p, const int32_t *at) { return p[*at]; }
static inline void vec_scatter_add(double *out, const int32_t *at, vec v) { out[*at] += v; }
static inline vec vec_sqrt(vec v) { return sqrt(v); }
static inline vec vec_reciprocal(vec v) { return 1.0 / v; }
static inline vec vec_gather_next(const double *p, const int32_t *at, vec before, int chained)
{
    return p[*at];
}
static inline void vec_scatter_add_nodes(double *out, const int32_t *first, const int32_t *second,
                                         vec u, vec v, int chained)
{
    out[*first] += u;
    out[*second] += v;
}

#else

typedef double vec __attribute__((vector_size(8 * ANCF_LANES), aligned(8), may_alias));

static inline vec vec_load(const double *p) { return *(const vec *)p; }

/* Scalar loads: measured 10 to 30 % faster than the hardware's gather for whole kernels (Zen 4). */
static inline vec vec_gather(const double *p, const int32_t *at)
{
#if ANCF_LANES == 8
    return (vec){p[at[0]], p[at[1]], p[at[2]], p[at[3]], p[at[4]], p[at[5]], p[at[6]], p[at[7]]};
#elif ANCF_LANES == 4
    return (vec){p[at[0]], p[at[1]], p[at[2]], p[at[3]]};
#else
    return (vec){p[at[0]], p[at[1]]};
#endif
}

/* Lane after lane, because elements in one block may share a node.  Not inlined: kernels call it up to 24
 * times, run as fast with a call and compile in two thirds of the time. */
static __attribute__((noinline)) void vec_scatter_add(double *out, const int32_t *at, vec v)
{
    out[at[0]] += v[0];
    out[at[1]] += v[1];
#if ANCF_LANES > 2
    out[at[2]] += v[2];
    out[at[3]] += v[3];
#endif
#if ANCF_LANES > 4
    out[at[4]] += v[4];
    out[at[5]] += v[5];
    out[at[6]] += v[6];
    out[at[7]] += v[7];
#endif
}

/* Places for __builtin_shufflevector, which requires vectors without the attributes of `vec`. */
typedef double vec_plain __attribute__((vector_size(8 * ANCF_LANES)));
#if ANCF_LANES == 8
#define VEC_NEXT 1, 2, 3, 4, 5, 6, 7, 8
#define VEC_BEFORE 8, 0, 1, 2, 3, 4, 5, 6
#elif ANCF_LANES == 4
#define VEC_NEXT 1, 2, 3, 4
#define VEC_BEFORE 4, 0, 1, 2
#else
#define VEC_NEXT 1, 2
#define VEC_BEFORE 2, 0
#endif

/* Coordinates of the second nodes.  In a chain they are those of the first nodes shifted by one lane,
 * so one number is loaded instead of one per lane. */
static inline vec vec_gather_next(const double *p, const int32_t *at, vec before, int chained)
{
    if (chained)
        return __builtin_shufflevector((vec_plain)before, (vec_plain){0} + p[at[ANCF_LANES - 1]],
                                       VEC_NEXT);
    return vec_gather(p, at);
}

/* Add the results of the elements to their first and second nodes.  In a chain the first node of a lane
 * is the second node of the previous lane, and both numbers are added together. */
static inline void vec_scatter_add_nodes(double *out, const int32_t *first, const int32_t *second,
                                         vec u, vec v, int chained)
{
    if (chained) {
        vec_scatter_add(out, first,
                        u + __builtin_shufflevector((vec_plain)v, (vec_plain){0}, VEC_BEFORE));
        out[second[ANCF_LANES - 1]] += v[ANCF_LANES - 1];
    } else {
        vec_scatter_add(out, first, u);
        vec_scatter_add(out, second, v);
    }
}

/* By GCC's builtins: <immintrin.h> declares them too, but reading it took a third of the compilation of a
 * small kernel. */
static inline vec vec_sqrt(vec v)
{
#if defined(__clang__)
    return __builtin_elementwise_sqrt((vec_plain)v);
#elif ANCF_LANES == 8
    return __builtin_ia32_sqrtpd512_mask(v, v, -1, 4); /* all lanes, current rounding */
#elif ANCF_LANES == 4
    return __builtin_ia32_sqrtpd256(v);
#elif defined(__x86_64__)
    return __builtin_ia32_sqrtpd(v);
#else
    for (int lane = 0; lane < ANCF_LANES; lane++)
        v[lane] = __builtin_sqrt(v[lane]);
    return v;
#endif
}

static inline vec vec_reciprocal(vec v) { return 1.0 / v; }

#endif

static inline vec vec_set1(double x) { return (vec){0} + x; }

static inline vec vec_parameter(const double *set, int number)
{
    return vec_load(set + number * ANCF_LANES);
}

#endif
