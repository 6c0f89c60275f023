/* Products and triangular solves of small dense blocks: the arithmetic of the elimination. */
#ifndef ANCF_LDL_DENSE_H
#define ANCF_LDL_DENSE_H

#include "ldl.h"
#include "simd.h"

/* Number of rows multiplied together, and of vectors of rows solved together. */
enum { LDL_ROWS = 4, LDL_ABREAST = 4 };

/* product[k] = sum over c of g[c] b[c * stride + k], for k < n; reads and writes up to LDL_SLACK more. */
LDL_INLINE void ldl_products(const double *restrict g, ptrdiff_t width, const double *restrict b,
                             ptrdiff_t stride, ptrdiff_t n, double *restrict product)
{
    ptrdiff_t k = 0;
    if (!__builtin_constant_p(width))
        for (; k + 4 < n; k += 2 * ANCF_LANES) {
            vec first = g[0] * vec_load(b + k), second = g[0] * vec_load(b + k + ANCF_LANES);
            for (ptrdiff_t c = 1; c < width; ++c) {
                first += g[c] * vec_load(b + c * stride + k);
                second += g[c] * vec_load(b + c * stride + k + ANCF_LANES);
            }
            *(vec *)(product + k) = first;
            *(vec *)(product + k + ANCF_LANES) = second;
        }
    for (; k < n; k += 4) {
        quad total = g[0] * quad_load(b + k);
        for (ptrdiff_t c = 1; c < width; ++c)
            total += g[c] * quad_load(b + c * stride + k);
        quad_store(product + k, total);
    }
}

/* The same for LDL_ROWS rows of g, with products `room` apart. */
LDL_INLINE void ldl_products_of_rows(const double *restrict g, ptrdiff_t width, const double *restrict b,
                                     ptrdiff_t stride, ptrdiff_t n, double *restrict product,
                                     ptrdiff_t room)
{
    for (ptrdiff_t k = 0; k < n; k += 2 * ANCF_LANES) {
        vec first[LDL_ROWS] = {{0}}, second[LDL_ROWS] = {{0}};
        for (ptrdiff_t c = 0; c < width; ++c) {
            vec one = vec_load(b + c * stride + k), two = vec_load(b + c * stride + k + ANCF_LANES);
#pragma GCC unroll 4
            for (int i = 0; i < LDL_ROWS; ++i) {
                first[i] += g[i * width + c] * one;
                second[i] += g[i * width + c] * two;
            }
        }
#pragma GCC unroll 4
        for (int i = 0; i < LDL_ROWS; ++i) {
            *(vec *)(product + i * room + k) = first[i];
            *(vec *)(product + i * room + k + ANCF_LANES) = second[i];
        }
    }
}

/* Four rows times the inverse of the block, by its factor: y[c] is column c of them. */
LDL_INLINE void ldl_divide(const double *triangle, const double *inverse, ptrdiff_t width, quad *y)
{
    const double *entry = triangle;
    for (ptrdiff_t c = 1; c < width; ++c) {
        for (ptrdiff_t k = 0; k < c; ++k)
            y[c] -= entry[k] * y[k];
        entry += c;
    }
    for (ptrdiff_t c = 0; c < width; ++c)
        y[c] *= inverse[c];
    for (ptrdiff_t c = width - 1; c > 0; --c) {
        entry -= c;
        for (ptrdiff_t k = 0; k < c; ++k)
            y[k] -= entry[k] * y[c];
    }
}

/* The same for several vectors of rows: column c starts at y[abreast c]. */
LDL_INLINE void ldl_divide_abreast(const double *triangle, const double *inverse, ptrdiff_t width,
                                   vec *y, int abreast)
{
    const double *entry = triangle;
    vec sum[LDL_ABREAST];
    for (ptrdiff_t c = 1; c < width; ++c) {
        for (int j = 0; j < abreast; ++j)
            sum[j] = y[abreast * c + j];
        for (ptrdiff_t k = 0; k < c; ++k)
            for (int j = 0; j < abreast; ++j)
                sum[j] -= entry[k] * y[abreast * k + j];
        for (int j = 0; j < abreast; ++j)
            y[abreast * c + j] = sum[j];
        entry += c;
    }
    for (ptrdiff_t c = width - 1; c >= 0; --c) {
        for (int j = 0; j < abreast; ++j)
            sum[j] = inverse[c] * y[abreast * c + j];
        entry = triangle + c * (c + 1) / 2 + c; /* row c + 1; then the rows below */
        for (ptrdiff_t below = c + 1; below < width; ++below) {
            for (int j = 0; j < abreast; ++j)
                sum[j] -= *entry * y[abreast * below + j];
            entry += below;
        }
        for (int j = 0; j < abreast; ++j)
            y[abreast * c + j] = sum[j];
    }
}

#endif
