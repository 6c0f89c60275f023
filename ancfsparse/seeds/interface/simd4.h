/* Vectors of four numbers; like `vec` in simd.h, but of the same length for all instruction sets. */
#ifndef ANCF_QUAD_H
#define ANCF_QUAD_H

#ifdef __x86_64__
#include <immintrin.h>
#endif

typedef double quad __attribute__((vector_size(32), aligned(8), may_alias));
typedef float short_quad __attribute__((vector_size(16), aligned(4), may_alias));

#define QUAD_INLINE static inline __attribute__((always_inline))

QUAD_INLINE quad quad_load(const double *p) { return *(const quad *)p; }
QUAD_INLINE void quad_store(double *p, quad v) { *(quad *)p = v; }

QUAD_INLINE quad quad_of_singles(const float *p)
{
#ifdef __AVX__
    return _mm256_cvtps_pd(_mm_loadu_ps(p)); /* GCC 12 would use two conversions */
#else
    return __builtin_convertvector(*(const short_quad *)p, quad);
#endif
}

QUAD_INLINE void quad_to_singles(float *p, quad v)
{
    *(short_quad *)p = __builtin_convertvector(v, short_quad);
}

QUAD_INLINE double quad_sum(quad v) { return (v[0] + v[2]) + (v[1] + v[3]); }

/* (sum of a, sum of b, sum of c, 0) */
QUAD_INLINE quad quad_sums(quad a, quad b, quad c)
{
    const quad zero = {0};
    quad ab = __builtin_shufflevector(a, b, 0, 4, 2, 6) +
              __builtin_shufflevector(a, b, 1, 5, 3, 7);
    quad c0 = __builtin_shufflevector(c, zero, 0, 4, 2, 6) +
              __builtin_shufflevector(c, zero, 1, 5, 3, 7);
    return __builtin_shufflevector(ab, c0, 0, 1, 4, 5) +
           __builtin_shufflevector(ab, c0, 2, 3, 6, 7);
}

#endif
