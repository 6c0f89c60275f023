"""Declarations of vectors.h and parallel.h; an include file."""

cdef extern from "parallel.h":
    const int MOST_PARTS "ANCF_MOST_PARTS"
    void in_parts "ancf_in_parts" (
        ptrdiff_t, void (*)(void *, ptrdiff_t) noexcept nogil, void *) noexcept nogil

cdef extern from "vectors.h":
    double dot "vec_dot" (const double *, const double *, ptrdiff_t) noexcept nogil
    double dot_parts "vec_dot_parts" (
        ptrdiff_t, const double *, const double *, ptrdiff_t) noexcept nogil
    double largest "vec_largest" (const double *, ptrdiff_t) noexcept nogil
    double weigh "vec_weigh" (const double *, const double *, ptrdiff_t) noexcept nogil
    double weigh_parts "vec_weigh_parts" (
        ptrdiff_t, const double *, const double *, ptrdiff_t) noexcept nogil
    void scaled "vec_scale_parts" (
        ptrdiff_t, double *, double, const double *, ptrdiff_t) noexcept nogil
    void combined "vec_sum_parts" (
        ptrdiff_t, double *, double, const double *, double, const double *,
        ptrdiff_t) noexcept nogil
    void vec_pair(const double *, const double *, const double *, const double *, const double *,
                  ptrdiff_t, double *) noexcept nogil
