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
                     + (weight[2] * *(const ancf_row *)(q + place[6])
                        + weight[3] * *(const ancf_row *)(q + place[9]));
}

/* A row can also hold a number of each of three points; the fourth has no meaning.  Three rows are then
 * the components (x, y, z) of vectors of these points. */
#define VEC_ROW static inline __attribute__((always_inline))
#pragma GCC diagnostic ignored "-Wpsabi" /* of calls with rows; all are inlined */

typedef double vec_four __attribute__((vector_size(32)));
typedef int64_t vec_four_order __attribute__((vector_size(32)));
typedef double vec_two __attribute__((vector_size(16), aligned(8), may_alias));

VEC_ROW vec_four vec_row_same(double value) { return (vec_four){value, value, value, value}; }

VEC_ROW vec_four vec_row_load(const double *p) { return (vec_four)*(const ancf_row *)p; }

/* The numbers p[0], p[stride], p[2 stride] of three points. */
VEC_ROW vec_four vec_row_of(const double *p, ptrdiff_t stride)
{
    return (vec_four){p[0], p[stride], p[2 * stride], 0.0};
}

VEC_ROW void vec_row_store(double *p, vec_four v)
{
    *(vec_two *)p = (vec_two){v[0], v[1]};
    p[2] = v[2];
}

/* `yes` where a > b, otherwise `no`. */
VEC_ROW vec_four vec_row_where(vec_four a, vec_four b, vec_four yes, vec_four no)
{
    vec_four_order above = a > b;
    return (vec_four)((above & (vec_four_order)yes) | (~above & (vec_four_order)no));
}

VEC_ROW int vec_row_any_positive(vec_four v) { return v[0] > 0.0 || v[1] > 0.0 || v[2] > 0.0; }

VEC_ROW vec_four vec_row_sqrt(vec_four v)
{
#ifdef __AVX__
    return (vec_four)_mm256_sqrt_pd((__m256d)v);
#else
    return (vec_four){sqrt(v[0]), sqrt(v[1]), sqrt(v[2]), 0.0};
#endif
}

#define VEC_EVEN(a, b) __builtin_shufflevector(a, b, 0, 4, 2, 6)
#define VEC_ODD(a, b) __builtin_shufflevector(a, b, 1, 5, 3, 7)
#define VEC_LOW(a, b) __builtin_shufflevector(a, b, 0, 1, 4, 5)

/* The vectors of three points, (x, y, z, 0) each, from their components. */
VEC_ROW void vec_row_turn(const vec_four *v, vec_four *points)
{
    const vec_four x = v[0], y = v[1], z = v[2], zero = {0.0};
    const vec_four even_xy = VEC_EVEN(x, y), even_z = VEC_EVEN(z, zero);
    points[0] = VEC_LOW(even_xy, even_z);
    points[1] = VEC_LOW(VEC_ODD(x, y), VEC_ODD(z, zero));
    points[2] = __builtin_shufflevector(even_xy, even_z, 2, 3, 6, 7);
}

/* v[c] = sum of weight[4 i + k] q[place[3 i] + c] for i < 4: a vector of each point k < 3. */
VEC_ROW void vec_row_sum(const double *weight, const int32_t *place, const double *q, vec_four *v)
{
    const ancf_row *w = (const ancf_row *)weight;
    for (int c = 0; c < 3; ++c)
        v[c] = (vec_four)w[0] * q[place[0] + c] + w[1] * q[place[3] + c]
               + (w[2] * q[place[6] + c] + w[3] * q[place[9] + c]);
}

/* Subtract the forces f on three points, with the same weights. */
VEC_ROW void vec_row_subtract(const double *weight, const int32_t *place, const vec_four *f, double *r)
{
    vec_four force[3];
    vec_row_turn(f, force);
    for (int i = 0; i < 4; ++i) {
        const double *w = weight + 4 * i;
        double *out = r + place[3 * i];
        vec_four sum = w[0] * force[0] + w[1] * force[1] + w[2] * force[2];
        *(vec_two *)out -= (vec_two){sum[0], sum[1]};
        out[2] -= sum[2];
    }
}

/* The components of the vectors at p, p + stride and p + 2 stride, each followed by another number. */
VEC_ROW void vec_row_load_points(const double *p, ptrdiff_t stride, vec_four *v)
{
    const vec_four point[3] = {vec_row_load(p), vec_row_load(p + stride), vec_row_load(p + 2 * stride)};
    vec_row_turn(point, v);
}

/* Store the vectors v of three points one after the other. */
VEC_ROW void vec_row_store_points(double *out, const vec_four *v)
{
    vec_four point[3];
    vec_row_turn(v, point);
    for (int k = 0; k < 3; ++k)
        vec_row_store(out + 3 * k, point[k]);
}

#endif
