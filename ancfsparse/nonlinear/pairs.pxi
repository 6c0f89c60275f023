"""What a secant pair adds to an inverse H; text for the two modules of inverses.

With a full step s = -H r the four updates need no second product with H: p = H r_new gives
H y = p + s and s - H y = -p.
"""
from libc.math cimport fabs, sqrt


cdef extern from "vectors.h":
    double dot "vec_dot" (const double *, const double *, ptrdiff_t) noexcept nogil
    double dot_parts "vec_dot_parts" (
        ptrdiff_t, const double *, const double *, ptrdiff_t) noexcept nogil
    void scaled "vec_scale_parts" (
        ptrdiff_t, double *, double, const double *, ptrdiff_t) noexcept nogil
    void combined "vec_sum_parts" (
        ptrdiff_t, double *, double, const double *, double, const double *,
        ptrdiff_t) noexcept nogil

include "../kernels/solver_abi.pxi"


cdef enum Rule:
    BROYDEN
    DAVIDON
    DFP
    BFGS


RULES = {"broyden": BROYDEN, "davidon": DAVIDON, "dfp": DFP, "bfgs": BFGS}

# A pair is refused when a denominator is this small beside the norms in it.  The sign is not
# looked at: on a saddle point it says nothing (a curvature s.y may be negative and right).
cdef double SMALLEST_COSINE = 1e-8
cdef double SMALLEST_BROYDEN = 1e-3


cdef int pair_terms(Rule rule, ptrdiff_t parts, ptrdiff_t n, const double *s, const double *y,
                    const double *p, double smallest_y, double *a, double *w,
                    ptrdiff_t stride) noexcept nogil:
    """Write the terms of a pair to a[0], w[0] (and a[stride], w[stride]); return how many, or 0.

    ``p = H r_new``; so ``h = H y = p + s`` and ``u = s - h = -p``.  Broyden's w is left to the
    caller, a[0] is u.
    """
    cdef double sy, yh, uy, yy
    yy = dot_parts(parts, y, y, n)
    if not yy > smallest_y * smallest_y:
        return 0
    if rule == BROYDEN:
        scaled(parts, a, -1.0, p, n)
        return 1
    if rule == DAVIDON:  # equation 14: u u^T / (u.y)
        uy = -dot_parts(parts, p, y, n)
        if not fabs(uy) >= SMALLEST_COSINE * sqrt(dot_parts(parts, p, p, n) * yy):
            return 0
        scaled(parts, w, -1.0, p, n)
        scaled(parts, a, -1.0 / uy, p, n)
        return 1
    sy = dot_parts(parts, s, y, n)
    yh = sy + dot_parts(parts, p, y, n)
    if not fabs(sy) >= SMALLEST_COSINE * sqrt(dot_parts(parts, s, s, n) * yy):
        return 0
    combined(parts, w + stride, 1.0, p, 1.0, s, n)  # h
    if rule == DFP:  # equation 15: s s^T / (s.y) - h h^T / (y.h)
        scaled(parts, a, 1.0 / sy, s, n)
        scaled(parts, w, 1.0, s, n)
        if not fabs(yh) >= SMALLEST_COSINE * sqrt(
                dot_parts(parts, w + stride, w + stride, n) * yy):
            return 0
        scaled(parts, a + stride, -1.0 / yh, w + stride, n)
        return 2
    if rule == BFGS:  # equation 16: s ((1 + y.h / s.y) s - h)^T / (s.y) - h s^T / (s.y)
        scaled(parts, a, 1.0, s, n)
        combined(parts, w, (1.0 + yh / sy) / sy, s, -1.0 / sy, w + stride, n)
        scaled(parts, a + stride, 1.0, w + stride, n)
        scaled(parts, w + stride, -1.0 / sy, s, n)
        return 2
    return 0  # a rule without terms
