"""Updates of an inverse H with a secant pair; included by the two modules of inverses.

With a full step s = -H r the four updates need no second product with H: with p = H r_new,
H y = p + s and s - H y = -p.
"""
from libc.math cimport INFINITY, fabs, sqrt


include "../../abi/vectors.pxi"
include "inverse.pxi"


cdef enum Rule:
    BROYDEN
    DAVIDON
    DFP
    BFGS


RULES = {"broyden": BROYDEN, "davidon": DAVIDON, "dfp": DFP, "bfgs": BFGS}

# A pair is rejected if a denominator is this small relative to its norms.  Its sign is not tested:
# near a saddle point it is irrelevant (a negative curvature s.y may be correct).
cdef double SMALLEST_COSINE = 1e-8
cdef double SMALLEST_BROYDEN = 1e-3


cdef struct Guard:
    # The norm of a step is the root of sum(weight s^2), that of a difference of residuals the root
    # of sum(inverse y^2).  Unweighted sums of squares of metres, slopes, forces would depend on the
    # units.
    double *weight
    double *inverse
    double smallest_y
    # DFP and BFGS divide by s.y and by y.H y, which are equal if H is exact.  Near a saddle point
    # one of them can vanish by chance; it takes many iterations to recover from such a pair.
    double largest_ratio


cdef class SecantInverse(CompiledInverse):
    """An inverse that pairs update, with the criteria for skipping them."""

    cdef const ancf_seed *seed
    cdef Guard guard
    cdef dict own  # arrays

    def __cinit__(self, seed, *others):
        self.seed = <const ancf_seed *>PyCapsule_GetPointer(seed.capsule, "ancf_seed")
        self.own = {}

    def set_guard(self, weight, double smallest_y, double largest_ratio=INFINITY):
        """Set the criteria for skipping pairs.

        Parameters
        ----------
        weight : (n,) float
            Weights of the squares in the norm of a step; their inverses are those of a difference
            of residuals.  Denominators are compared with these norms.
        smallest_y : float
            Differences of residuals up to this norm are rounding, and skipped.
        largest_ratio : float, optional
            Skip pairs of DFP and BFGS whose ``s.y`` and ``y.H y`` differ in sign or by this factor.
        """
        cdef double[::1] ahead = np.array(weight, dtype=float)
        cdef double[::1] inverse = 1.0 / np.asarray(ahead)
        self.own["weight"], self.own["inverse"] = ahead, inverse
        self.guard.weight, self.guard.inverse = &ahead[0], &inverse[0]
        self.guard.smallest_y, self.guard.largest_ratio = smallest_y, largest_ratio


cdef inline bint vanishes(double product, double one, double other) noexcept nogil:
    """Return True if a product of two vectors is small relative to their norms, given squared."""
    return not fabs(product) >= SMALLEST_COSINE * sqrt(one * other)  # true for NaN


cdef inline bint alike(double a, double b, double ratio) noexcept nogil:
    """Return True if two numbers have one sign and magnitudes within a ratio, or it is infinite."""
    return ratio == INFINITY or ((a > 0.0) == (b > 0.0) and fabs(a) < ratio * fabs(b)
                                 and fabs(b) < ratio * fabs(a))


cdef int pair_terms(Rule rule, ptrdiff_t parts, ptrdiff_t n, const double *s, const double *y,
                    const double *p, const Guard *guard, double *a, double *w,
                    ptrdiff_t stride) noexcept nogil:
    """Write the terms of a pair to a[0], w[0] (and a[stride], w[stride]); return how many, or 0.

    ``p = H r_new``, so ``h = H y = p + s`` and ``u = s - h = -p``.  For Broyden's update a[0] is u,
    and the caller sets w.
    """
    cdef double[5] products
    cdef double yy, sy, py, ss, pp, yh
    if parts == 1 and rule != BROYDEN:
        vec_pair(guard.weight, guard.inverse, s, y, p, n, &products[0])
        yy, sy, py, ss, pp = products[0], products[1], products[2], products[3], products[4]
    else:
        yy = weigh_parts(parts, guard.inverse, y, n)
        sy = py = ss = pp = 0.0
        if rule != BROYDEN:
            py = dot_parts(parts, p, y, n)
        if rule == DAVIDON:
            pp = weigh_parts(parts, guard.weight, p, n)
        elif rule != BROYDEN:
            sy, ss = dot_parts(parts, s, y, n), weigh_parts(parts, guard.weight, s, n)
    if not yy > guard.smallest_y * guard.smallest_y:
        return 0
    if rule == BROYDEN:
        scaled(parts, a, -1.0, p, n)
        return 1
    if rule == DAVIDON:  # equation 14: u u^T / (u.y)
        if vanishes(py, pp, yy):
            return 0
        scaled(parts, w, -1.0, p, n)
        scaled(parts, a, 1.0 / py, p, n)
        return 1
    yh = sy + py
    if not alike(sy, yh, guard.largest_ratio):
        return 0
    if vanishes(sy, ss, yy):
        return 0
    combined(parts, w + stride, 1.0, p, 1.0, s, n)  # h
    if rule == DFP:  # equation 15: s s^T / (s.y) - h h^T / (y.h)
        scaled(parts, a, 1.0 / sy, s, n)
        scaled(parts, w, 1.0, s, n)
        if vanishes(yh, weigh_parts(parts, guard.weight, w + stride, n), yy):
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
