/* Operations on long vectors.  Sums are accumulated in several lanes, which a compiler may not do by
 * itself; the order is fixed by the instruction set, so runs are reproducible bit for bit.
 *
 * Operations in parts work on contiguous pieces, each on its own thread, and the sums of the parts are
 * added in order: runs with the same number of parts are reproducible bit for bit.
 */
#ifndef ANCF_VECTORS_H
#define ANCF_VECTORS_H

#ifdef __x86_64__
#include <immintrin.h>
#endif
#include <stddef.h>

#include "parallel.h"
#include "simd.h"

/* For loops over the remaining entries, fewer than ANCF_LANES, which the compiler would otherwise
 * vectorise: on short vectors its checks for overlap took as long as the rest. */
#define VEC_LEFT __asm__("")

/* Sum of the lanes, by halves: short sums wait for it. */
static inline double vec_total(vec v)
{
#if ANCF_LANES == 1
    return v;
#elif ANCF_LANES == 2
    return v[0] + v[1];
#else
#if ANCF_LANES == 8
    __m256d half = _mm512_castpd512_pd256(v) + _mm512_extractf64x4_pd(v, 1);
#else
    __m256d half = v;
#endif
    __m128d pair = _mm256_castpd256_pd128(half) + _mm256_extractf128_pd(half, 1);
    return pair[0] + pair[1];
#endif
}

/* Entry i of an array: lanes from there on in the loops over lanes, one number in those over the rest. */
#define VEC_AT(p) (*(number *)((p) + i))

/* Return the sum over n entries of the terms that statements add to `sum`. */
#define VEC_SUM(n, ...)                                                \
    vec t0 = {0}, t1 = {0};                                            \
    double rest = 0.0;                                                 \
    ptrdiff_t next = 0;                                                \
    for (; next + 2 * ANCF_LANES <= n; next += 2 * ANCF_LANES) {       \
        VEC_STATEMENTS(vec, t0, next, __VA_ARGS__)                     \
        VEC_STATEMENTS(vec, t1, next + ANCF_LANES, __VA_ARGS__)        \
    }                                                                  \
    for (; next + ANCF_LANES <= n; next += ANCF_LANES)                 \
        VEC_STATEMENTS(vec, t0, next, __VA_ARGS__)                     \
    for (; next < n; ++next) {                                         \
        VEC_LEFT;                                                      \
        VEC_STATEMENTS(double, rest, next, __VA_ARGS__)                \
    }                                                                  \
    return vec_total(t0 + t1) + rest
#define VEC_STATEMENTS(type, total, at, ...)                           \
    {                                                                  \
        typedef type number;                                           \
        const ptrdiff_t i = at;                                        \
        number sum = total;                                            \
        __VA_ARGS__;                                                   \
        total = sum;                                                   \
    }

static inline double vec_dot(const double *x, const double *y, ptrdiff_t n)
{
    VEC_SUM(n, sum += VEC_AT(x) * VEC_AT(y));
}

/* Sum of w x^2. */
static inline double vec_weigh(const double *w, const double *x, ptrdiff_t n)
{
    VEC_SUM(n, number xi = VEC_AT(x); sum += VEC_AT(w) * xi * xi);
}

/* Sum of w (x - y)^2. */
static inline double vec_weigh_apart(const double *w, const double *x, const double *y, ptrdiff_t n)
{
    VEC_SUM(n, number d = VEC_AT(x) - VEC_AT(y); sum += VEC_AT(w) * d * d);
}

/* out = a x; returns the sum of w out^2. */
static inline double vec_scale_weigh(double *out, double a, const double *x, const double *w,
                                     ptrdiff_t n)
{
    VEC_SUM(n, number xi = a * VEC_AT(x); VEC_AT(out) = xi; sum += VEC_AT(w) * xi * xi);
}

/* x += a s and y += b s; returns the sum of w s^2. */
static inline double vec_advance(double *x, double a, double *y, double b, const double *s,
                                 const double *w, ptrdiff_t n)
{
    VEC_SUM(n, number si = VEC_AT(s); VEC_AT(x) += a * si; VEC_AT(y) += b * si;
            sum += VEC_AT(w) * si * si);
}

/* Largest magnitude, not a number if an entry is none.  Magnitudes are ordered like their bits read as
 * integers, which are compared in lanes; fmax was a call for each entry. */
static inline double vec_largest(const double *x, ptrdiff_t n)
{
    typedef int64_t bits __attribute__((vector_size(8 * ANCF_LANES), aligned(8), may_alias));
    union { bits lanes; int64_t each[ANCF_LANES]; } largest = {{0}};
    union { int64_t bits; double value; } found = {0};
    ptrdiff_t i = 0;
    for (; i + ANCF_LANES <= n; i += ANCF_LANES) {
        bits size = *(const bits *)(x + i) & INT64_MAX, larger = size > largest.lanes;
        largest.lanes = (size & larger) | (largest.lanes & ~larger);
    }
    for (int lane = 0; lane < ANCF_LANES; ++lane)
        found.bits = largest.each[lane] > found.bits ? largest.each[lane] : found.bits;
    for (; i < n; ++i) {
        union { double value; int64_t bits; } entry = {fabs(x[i])};
        found.bits = entry.bits > found.bits ? entry.bits : found.bits;
    }
    return found.value;
}

/* Set sums[m] over n entries to the terms that statements add to `sum`. */
#define VEC_SUMS(m, sums, n, ...)                                      \
    vec total[m] = {{0}};                                              \
    double rest[m] = {0};                                              \
    ptrdiff_t i = 0;                                                   \
    for (; i + ANCF_LANES <= n; i += ANCF_LANES) {                     \
        typedef vec number;                                            \
        vec *const sum = total;                                        \
        __VA_ARGS__;                                                   \
    }                                                                  \
    for (; i < n; ++i) {                                               \
        typedef double number;                                         \
        double *const sum = rest;                                      \
        VEC_LEFT;                                                      \
        __VA_ARGS__;                                                   \
    }                                                                  \
    for (int k = 0; k < m; ++k)                                        \
        sums[k] = vec_total(total[k]) + rest[k]

/* The products that an update with a pair takes: y.y / w, s.y, p.y, and s.s w, p.p w. */
static inline void vec_pair(const double *w, const double *inverse, const double *s, const double *y,
                            const double *p, ptrdiff_t n, double *out)
{
    VEC_SUMS(5, out, n,
             number si = VEC_AT(s), yi = VEC_AT(y), pi = VEC_AT(p), wi = VEC_AT(w);
             sum[0] += VEC_AT(inverse) * yi * yi; sum[1] += si * yi; sum[2] += pi * yi;
             sum[3] += wi * si * si; sum[4] += wi * pi * pi);
}

/* Sums of w (x - y)^2 and of w (x - z)^2, and y takes the place of z. */
static inline void vec_compare(const double *w, const double *x, const double *y, double *z,
                               ptrdiff_t n, double *of_y, double *of_z)
{
    double sums[2];
    VEC_SUMS(2, sums, n, number dy = VEC_AT(x) - VEC_AT(y), dz = VEC_AT(x) - VEC_AT(z);
             sum[0] += VEC_AT(w) * dy * dy; sum[1] += VEC_AT(w) * dz * dz; VEC_AT(z) = VEC_AT(y));
    *of_y = sums[0];
    *of_z = sums[1];
}

/* Single precision, where a few digits are enough: half the memory and time. */
#if ANCF_LANES == 1
typedef float vec_single;
#define VEC_AS(type, v) ((type)(v))
#else
typedef float vec_single __attribute__((vector_size(4 * ANCF_LANES), aligned(4), may_alias));
#define VEC_AS(type, v) __builtin_convertvector(v, type)
#endif

static inline vec vec_load_single(const float *p)
{
    return VEC_AS(vec, *(const vec_single *)p);
}

/* d = x - y; adds up w d^2, w d e and w d f; d takes the place of f. */
static inline void vec_changes(const double *w, const double *x, const double *y, const float *e,
                               float *f, ptrdiff_t n, double *out)
{
    vec total[3] = {{0}}, d, wd;
    double rest[3] = {0}, di;
    ptrdiff_t i = 0;
    for (; i + ANCF_LANES <= n; i += ANCF_LANES) {
        d = vec_load(x + i) - vec_load(y + i);
        wd = vec_load(w + i) * d;
        total[0] += wd * d;
        total[1] += wd * vec_load_single(e + i);
        total[2] += wd * vec_load_single(f + i);
        *(vec_single *)(f + i) = VEC_AS(vec_single, d);
    }
    for (; i < n; ++i) {
        VEC_LEFT;
        di = x[i] - y[i];
        rest[0] += w[i] * di * di;
        rest[1] += w[i] * di * e[i];
        rest[2] += w[i] * di * f[i];
        f[i] = (float)di;
    }
    for (int k = 0; k < 3; ++k)
        out[k] += vec_total(total[k]) + rest[k];
}

/* out = x + a d + b e. */
static inline void vec_follow(double *out, const double *x, double a, const float *d, double b,
                              const float *e, ptrdiff_t n)
{
    ptrdiff_t i = 0;
    for (; i + ANCF_LANES <= n; i += ANCF_LANES)
        *(vec *)(out + i) = vec_load(x + i) + a * vec_load_single(d + i) + b * vec_load_single(e + i);
    for (; i < n; ++i) {
        VEC_LEFT;
        out[i] = x[i] + a * d[i] + b * e[i];
    }
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

/* Four numbers, (x, y, z) and the one that follows. */
typedef double ancf_row __attribute__((vector_size(32), aligned(8), may_alias));

/* x[0..3] = sum of weight[i] q[place[3 i] + 0..3] for i < 4: a vector (x, y, z), and a number without
 * meaning.  */
static inline void vec_sum_rows(const double *weight, const int32_t *place, const double *q, double *x)
{
    *(ancf_row *)x = weight[0] * *(const ancf_row *)(q + place[0])
                     + weight[1] * *(const ancf_row *)(q + place[3])
                     + weight[2] * *(const ancf_row *)(q + place[6])
                     + weight[3] * *(const ancf_row *)(q + place[9]);
}

#endif
