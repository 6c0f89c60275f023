# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The quasi-Newton inverse as a sparse seed and the terms ``a w^T`` of the last few pairs."""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New

import numpy as np


include "secant_pairs.pxi"


cdef enum:
    MOST_TERMS = 2  # per pair, over all rules


cdef struct LimitedData:
    const ancf_seed *seed
    Rule rule
    ptrdiff_t n, parts, capacity, pairs, count  # last two: number of pairs and of terms
    Guard guard
    double *a  # terms of n numbers each, like w
    double *w
    const double *weights


cdef class Limited:
    """A sparse seed and the terms of the last pairs; all pairs are dropped when storage is full.

    A rolling window would be wrong: the denominator of each pair depends on the previous pairs.
    Broyden's update is in product form, in the inner product of ``weights``.
    """

    cdef ancf_inverse interface
    cdef LimitedData data
    cdef object owner, terms, weights
    cdef dict own
    cdef readonly object capsule

    def __cinit__(self, seed, str rule, ptrdiff_t n_pairs, weights=None):
        cdef LimitedData *data = &self.data
        cdef double[:, :, ::1] terms
        cdef const double[::1] weights_view
        self.owner = seed
        data.seed = <const ancf_seed *>PyCapsule_GetPointer(seed.capsule, "ancf_seed")
        data.rule = RULES[rule]
        data.n, data.parts = data.seed.n, 1
        data.capacity = n_pairs
        if n_pairs > 0:
            self.terms = np.zeros((2, MOST_TERMS * n_pairs, data.n))
            terms = self.terms
            data.a, data.w = &terms[0, 0, 0], &terms[1, 0, 0]
            self.own = {}
            set_guard(&data.guard, self.own, np.ones(data.n), 0.0, INFINITY)
            if data.rule == BROYDEN:
                self.weights = np.ones(data.n) if weights is None else np.array(weights, dtype=float)
                weights_view = self.weights
                data.weights = &weights_view[0]
        self.interface.context, self.interface.n = data, data.n
        self.interface.reseed, self.interface.forget = limited_reseed, limited_forget
        self.interface.apply, self.interface.learn = limited_apply, limited_learn
        self.capsule = PyCapsule_New(&self.interface, "ancf_inverse", NULL)

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for vector operations."""
        self.data.parts = threads

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
        if self.data.capacity > 0:
            set_guard(&self.data.guard, self.own, weight, smallest_y, largest_ratio)

    def apply(self, const double[::1] r):
        """Return ``H r``."""
        z = np.empty(self.data.n)
        cdef double[::1] view = z
        limited_apply(&self.data, &r[0], &view[0])
        return z

    def learn(self, const double[::1] s, const double[::1] y, const double[::1] r_new):
        """Update with the pair; return ``(H_new r_new, accepted)``.  ``s`` must be ``-H r_old``."""
        z = np.empty(self.data.n)
        cdef double[::1] view = z
        return z, bool(limited_learn(&self.data, &s[0], &y[0], &r_new[0], &view[0]))


cdef int limited_reseed(void *context) noexcept nogil:
    limited_forget(context)
    return 0


cdef void limited_forget(void *context) noexcept nogil:
    (<LimitedData *>context).count = 0
    (<LimitedData *>context).pairs = 0


cdef void add_term(const LimitedData *self, ptrdiff_t k, const double *r, double *z) noexcept nogil:
    cdef const double *a = self.a + k * self.n
    cdef double factor
    # Broyden's terms act on the result of the earlier terms, the symmetric ones on r itself.
    factor = dot_parts(self.parts, self.w + k * self.n,
                       <const double *>z if self.rule == BROYDEN else r, self.n)
    combined(self.parts, z, 1.0, z, factor, a, self.n)


cdef void limited_apply(void *context, const double *r, double *z) noexcept nogil:
    cdef LimitedData *self = <LimitedData *>context
    cdef ptrdiff_t k
    self.seed.solve(self.seed.context, r, z)
    for k in range(self.count):
        add_term(self, k, r, z)


cdef int limited_learn(void *context, const double *s, const double *y, const double *r_new,
                       double *z) noexcept nogil:
    cdef LimitedData *self = <LimitedData *>context
    cdef ptrdiff_t n = self.n, i, k, terms
    cdef double delta, ss
    cdef double *w
    if self.pairs == self.capacity:  # always if the capacity is zero: modified Newton
        limited_forget(context)
        limited_apply(context, r_new, z)
        return 1
    limited_apply(context, r_new, z)
    terms = pair_terms(self.rule, self.parts, n, s, y, z, &self.guard,
                       self.a + self.count * n, self.w + self.count * n, n)
    if terms == 0:
        return 0
    if self.rule == BROYDEN:  # (I + u s^T D / (s.D h)) H
        w = self.w + self.count * n
        for i in range(n):
            w[i] = self.weights[i] * s[i]
        ss = dot_parts(self.parts, w, s, n)
        delta = ss + dot_parts(self.parts, w, z, n)
        if not fabs(delta) >= SMALLEST_BROYDEN * ss:
            return 0
        scaled(self.parts, w, 1.0 / delta, w, n)
    for k in range(self.count, self.count + terms):
        add_term(self, k, r_new, z)
    self.count += terms
    self.pairs += 1
    return 1
