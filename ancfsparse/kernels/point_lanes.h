/* Three points of each of several cubic elements in space: a number of each point in three vectors.
 *
 * Points are numbered through the elements: vector t has the points t L, ..., t L + L - 1 of L = ANCF_LANES elements.
 */
#ifndef ANCF_POINT_LANES_H
#define ANCF_POINT_LANES_H

#include <string.h>

#include "vectors.h"

#if ANCF_LANES == 1
#error "points need at least two lanes"
#endif

#define POINTS static inline __attribute__((always_inline))
#pragma GCC diagnostic ignored "-Wpsabi" /* of calls with vectors; all are inlined */

/* `vec` with the alignment of its size: those in memory are on the stack. */
typedef vec_plain lanes;

/* `yes` where a > b, otherwise `no`. */
POINTS lanes points_where(lanes a, lanes b, lanes yes, lanes no)
{
#if defined(__AVX512F__) && ANCF_LANES == 8
    return _mm512_mask_blend_pd(_mm512_cmp_pd_mask(a, b, _CMP_GT_OQ), no, yes);
#elif defined(__AVX__) && ANCF_LANES == 4
    return _mm256_blendv_pd(no, yes, _mm256_cmp_pd(a, b, _CMP_GT_OQ));
#elif defined(__x86_64__)
    const __m128d above = _mm_cmpgt_pd(a, b);
    return _mm_or_pd(_mm_and_pd(above, yes), _mm_andnot_pd(above, no));
#else
    typedef int64_t order __attribute__((vector_size(8 * ANCF_LANES)));
    const order above = (vec_plain)a > (vec_plain)b;
    return (vec_plain)((above & (order)yes) | (~above & (order)no));
#endif
}

POINTS int points_any_positive(lanes v)
{
#if defined(__AVX512F__) && ANCF_LANES == 8
    return _mm512_cmp_pd_mask(v, (lanes){0.0}, _CMP_GT_OQ) != 0;
#elif defined(__AVX__) && ANCF_LANES == 4
    return _mm256_movemask_pd(_mm256_cmp_pd(v, (lanes){0.0}, _CMP_GT_OQ)) != 0;
#elif defined(__x86_64__)
    return _mm_movemask_pd(_mm_cmpgt_pd(v, (lanes){0.0})) != 0;
#else
    return v[0] > 0.0 || v[1] > 0.0;
#endif
}

/* v, with zeros from number n on. */
POINTS lanes points_first(lanes v, ptrdiff_t n)
{
    if (n < ANCF_LANES)
        for (ptrdiff_t lane = 1; lane < ANCF_LANES; ++lane)
            if (lane >= n)
                v[lane] = 0.0;
    return v;
}

/* Shuffle by the numbers of two vectors, -1 where any will do. */
#define POINTS_FROM(a, b, ...) (lanes) __builtin_shufflevector((vec_plain)(a), (vec_plain)(b), __VA_ARGS__)

/* by_point[p]: the points p of all elements, from all points in their order. */
POINTS void points_divide(const lanes *all, lanes *by_point)
{
    const lanes a = all[0], b = all[1], c = all[2];
#if ANCF_LANES == 8
    by_point[0] = POINTS_FROM(POINTS_FROM(a, b, 0, 3, 6, 9, 12, 15, -1, -1), c, 0, 1, 2, 3, 4, 5, 10, 13);
    by_point[1] = POINTS_FROM(POINTS_FROM(a, b, 1, 4, 7, 10, 13, -1, -1, -1), c, 0, 1, 2, 3, 4, 8, 11, 14);
    by_point[2] = POINTS_FROM(POINTS_FROM(a, b, 2, 5, 8, 11, 14, -1, -1, -1), c, 0, 1, 2, 3, 4, 9, 12, 15);
#elif ANCF_LANES == 4
    by_point[0] = POINTS_FROM(POINTS_FROM(a, b, 0, 3, 6, -1), c, 0, 1, 2, 5);
    by_point[1] = POINTS_FROM(POINTS_FROM(a, b, 1, 4, 7, -1), c, 0, 1, 2, 6);
    by_point[2] = POINTS_FROM(POINTS_FROM(a, b, 2, 5, -1, -1), c, 0, 1, 4, 7);
#else
    by_point[0] = POINTS_FROM(a, b, 0, 3);
    by_point[1] = POINTS_FROM(a, c, 1, 2);
    by_point[2] = POINTS_FROM(b, c, 0, 3);
#endif
}

/* All points in their order, from those of `points_divide`. */
POINTS void points_join(const lanes *by_point, lanes *all)
{
    const lanes a = by_point[0], b = by_point[1], c = by_point[2];
#if ANCF_LANES == 8
    all[0] = POINTS_FROM(POINTS_FROM(a, b, 0, 8, -1, 1, 9, -1, 2, 10), c, 0, 1, 8, 3, 4, 9, 6, 7);
    all[1] = POINTS_FROM(POINTS_FROM(a, b, -1, 3, 11, -1, 4, 12, -1, 5), c, 10, 1, 2, 11, 4, 5, 12, 7);
    all[2] = POINTS_FROM(POINTS_FROM(a, b, 13, -1, 6, 14, -1, 7, 15, -1), c, 0, 13, 2, 3, 14, 5, 6, 15);
#elif ANCF_LANES == 4
    all[0] = POINTS_FROM(POINTS_FROM(a, b, 0, 4, -1, 1), c, 0, 1, 4, 3);
    all[1] = POINTS_FROM(POINTS_FROM(a, b, 5, -1, 2, 6), c, 0, 5, 2, 3);
    all[2] = POINTS_FROM(POINTS_FROM(a, b, -1, 3, 7, -1), c, 6, 1, 2, 7);
#else
    all[0] = POINTS_FROM(a, b, 0, 2);
    all[1] = POINTS_FROM(c, a, 0, 3);
    all[2] = POINTS_FROM(b, c, 1, 3);
#endif
}

/* Components of the vectors (x, y, z) of as many points as there are lanes, one after the other in memory. */
POINTS void points_load(const double *p, lanes *v)
{
    const lanes all[3] = {vec_load(p), vec_load(p + ANCF_LANES), vec_load(p + 2 * ANCF_LANES)};
    points_divide(all, v);
}

/* Store the numbers of the first n points, or of all. */
POINTS void points_store(double *p, lanes v, ptrdiff_t n)
{
    if (n >= ANCF_LANES)
        *(vec *)p = v;
    else
        memcpy(p, &v, n * sizeof(double));
}

/* Store the components v of vectors of the first n points, or of all, one after the other. */
POINTS void points_store_vectors(double *p, const lanes *v, ptrdiff_t n)
{
    lanes all[3];
    points_join(v, all);
    if (n >= ANCF_LANES)
        for (int t = 0; t < 3; ++t)
            *(vec *)(p + t * ANCF_LANES) = all[t];
    else
        memcpy(p, all, 3 * n * sizeof(double));
}

/* The elements whose points are evaluated together, as many as there are lanes. */
typedef int32_t places __attribute__((vector_size(4 * ANCF_LANES), may_alias));
typedef struct {
    places place[4];  /* of four vectors (x, y, z) of each element */
    lanes weight[12]; /* of these vectors in each of three points */
    ptrdiff_t like;   /* element whose weights they are, or -1 */
} points_block;

/* Set n elements from the places of the components of their vectors (n, 4, 3) and from their weights (n, 3, 4); other
 * lanes repeat the last one. */
POINTS void points_take(points_block *block, ptrdiff_t n, const int32_t *place, const double *weight)
{
    block->like = -1;
    for (ptrdiff_t lane = 0; lane < ANCF_LANES; ++lane) {
        const ptrdiff_t element = lane < n ? lane : n - 1;
        for (int i = 0; i < 4; ++i)
            block->place[i][lane] = place[12 * element + 3 * i];
        for (int i = 0; i < 12; ++i)
            block->weight[i][lane] = weight[12 * element + i];
    }
}

/* Set elements that follow the element `like` by a number of elements, with its weights, at the distance of its places
 * from those of the next one. */
POINTS void points_repeat(points_block *block, ptrdiff_t like, ptrdiff_t number, const int32_t *place,
                          const double *weight)
{
    for (int i = 0; i < 4; ++i) {
        const int32_t step = place[12 + 3 * i] - place[3 * i];
        const int32_t first = place[3 * i] + (int32_t)number * step;
#if ANCF_LANES == 8
        const places lane = {0, 1, 2, 3, 4, 5, 6, 7};
#elif ANCF_LANES == 4
        const places lane = {0, 1, 2, 3};
#else
        const places lane = {0, 1};
#endif
        block->place[i] = first + step * lane;
    }
    if (block->like == like)
        return;
    block->like = like;
    for (int i = 0; i < 12; ++i)
        block->weight[i] = vec_set1(weight[i]);
}

/* Components (x, y, z) of vector i of all elements. */
POINTS void points_gather(const points_block *block, int i, const double *q, lanes *v)
{
#define POINTS_ROW(lane) (q + ((const int32_t *)&block->place[i])[lane])
#if ANCF_LANES == 8
#define POINTS_ROWS(first)                                                                \
    _mm512_insertf64x4(_mm512_castpd256_pd512(_mm256_loadu_pd(POINTS_ROW(first))),        \
                       _mm256_loadu_pd(POINTS_ROW((first) + 2)), 1)
    const __m512d a = POINTS_ROWS(0), b = POINTS_ROWS(1), c = POINTS_ROWS(4), d = POINTS_ROWS(5);
    const __m512d xz = _mm512_unpacklo_pd(a, b), more_xz = _mm512_unpacklo_pd(c, d);
    v[0] = _mm512_shuffle_f64x2(xz, more_xz, 0x88);
    v[1] = _mm512_shuffle_f64x2(_mm512_unpackhi_pd(a, b), _mm512_unpackhi_pd(c, d), 0x88);
    v[2] = _mm512_shuffle_f64x2(xz, more_xz, 0xdd);
#elif ANCF_LANES == 4
    const lanes a = vec_load(POINTS_ROW(0)), b = vec_load(POINTS_ROW(1));
    const lanes c = vec_load(POINTS_ROW(2)), d = vec_load(POINTS_ROW(3));
    const lanes xz = POINTS_FROM(a, b, 0, 4, 2, 6), more_xz = POINTS_FROM(c, d, 0, 4, 2, 6);
    v[0] = POINTS_FROM(xz, more_xz, 0, 1, 4, 5);
    v[1] = POINTS_FROM(POINTS_FROM(a, b, 1, 5, 3, 7), POINTS_FROM(c, d, 1, 5, 3, 7), 0, 1, 4, 5);
    v[2] = POINTS_FROM(xz, more_xz, 2, 3, 6, 7);
#else
    const lanes a = vec_load(POINTS_ROW(0)), b = vec_load(POINTS_ROW(1));
    v[0] = POINTS_FROM(a, b, 0, 2);
    v[1] = POINTS_FROM(a, b, 1, 3);
    v[2] = (lanes){POINTS_ROW(0)[2], POINTS_ROW(1)[2]};
#endif
}

/* Subtract vectors from those with number i of all elements, in order: they may share them. */
POINTS void points_scatter(const points_block *block, int i, const lanes *v, double *r)
{
    typedef double pair __attribute__((vector_size(16), aligned(8), may_alias));
    const int32_t *place = (const int32_t *)&block->place[i];
    const lanes x = v[0], y = v[1], z = v[2];
#define POINTS_PAIR(v, j) (pair) __builtin_shufflevector((vec_plain)(v), (vec_plain)(v), 2 * (j), 2 * (j) + 1)
#define POINTS_TAKE(j)                                                  \
    do {                                                                \
        double *one = r + place[2 * (j)], *two = r + place[2 * (j) + 1]; \
        const pair zs = POINTS_PAIR(z, j);                              \
        *(pair *)one -= POINTS_PAIR(even, j);                           \
        one[2] -= zs[0];                                                \
        *(pair *)two -= POINTS_PAIR(odd, j);                            \
        two[2] -= zs[1];                                                \
    } while (0)
#if ANCF_LANES == 8
    const lanes even = _mm512_unpacklo_pd(x, y), odd = _mm512_unpackhi_pd(x, y);
    POINTS_TAKE(0);
    POINTS_TAKE(1);
    POINTS_TAKE(2);
    POINTS_TAKE(3);
#elif ANCF_LANES == 4
    const lanes even = POINTS_FROM(x, y, 0, 4, 2, 6), odd = POINTS_FROM(x, y, 1, 5, 3, 7);
    POINTS_TAKE(0);
    POINTS_TAKE(1);
#else
    const lanes even = POINTS_FROM(x, y, 0, 2), odd = POINTS_FROM(x, y, 1, 3);
    POINTS_TAKE(0);
#endif
}

/* v[3 t + c]: component c of the points of vector t. */
POINTS void points_sum(const points_block *block, const double *q, lanes *v)
{
    const lanes *w = block->weight;
    lanes of_vector[3], of_point[3][3], all[3];
    for (int i = 0; i < 4; ++i) {
        points_gather(block, i, q, of_vector);
        for (int c = 0; c < 3; ++c)
            for (int p = 0; p < 3; ++p)
                of_point[c][p] = i == 0 ? w[4 * p] * of_vector[c] : of_point[c][p] + w[4 * p + i] * of_vector[c];
    }
    for (int c = 0; c < 3; ++c) {
        points_join(of_point[c], all);
        for (int t = 0; t < 3; ++t)
            v[3 * t + c] = all[t];
    }
}

/* Subtract the forces v on the points, with the same weights. */
POINTS void points_subtract(const points_block *block, const lanes *v, double *r)
{
    const lanes *w = block->weight;
    lanes of_point[3][3], sum[3];
    for (int c = 0; c < 3; ++c) {
        const lanes all[3] = {v[c], v[3 + c], v[6 + c]};
        points_divide(all, of_point[c]);
    }
    for (int i = 0; i < 4; ++i) {
        for (int c = 0; c < 3; ++c)
            sum[c] = w[i] * of_point[c][0] + w[4 + i] * of_point[c][1] + w[8 + i] * of_point[c][2];
        points_scatter(block, i, sum, r);
    }
}

#endif
