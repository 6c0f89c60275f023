# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Quasi-Newton inverses H: a seed plus rank-one terms ``a w^T``, one or two for each secant pair.

With a full step s = -H r the four updates need no second product with H: p = H r_new gives
H y = p + s and s - H y = -p.  `Dense` adds the terms into a matrix (the paper's form, the whole
history); `Limited` keeps the last few as vectors on a sparse seed.
"""
from cpython.pycapsule cimport PyCapsule_GetPointer, PyCapsule_New
from libc.math cimport fabs, sqrt
from libc.string cimport memcpy

import numpy as np


cdef extern from "simd.h":
    const int LANES "ANCF_LANES"
    ctypedef double vec
    vec set1 "vec_set1" (double) noexcept nogil

cdef extern from "vectors.h":
    double dot "vec_dot" (const double *, const double *, ptrdiff_t) noexcept nogil
    double dot_parts "vec_dot_parts" (
        ptrdiff_t, const double *, const double *, ptrdiff_t) noexcept nogil
    void scaled "vec_scale_parts" (
        ptrdiff_t, double *, double, const double *, ptrdiff_t) noexcept nogil
    void combined "vec_sum_parts" (
        ptrdiff_t, double *, double, const double *, double, const double *,
        ptrdiff_t) noexcept nogil

cdef extern from "solver_abi.h":
    ctypedef struct ancf_seed:
        void *context
        ptrdiff_t n
        ptrdiff_t (*factor)(void *, const double *) noexcept nogil
        void (*solve)(void *, const double *, double *) noexcept nogil

    ctypedef struct ancf_inverse:
        void *context
        ptrdiff_t n
        int (*reseed)(void *) noexcept nogil
        void (*forget)(void *) noexcept nogil
        void (*apply)(void *, const double *, double *) noexcept nogil
        int (*learn)(void *, const double *, const double *, const double *, double *) noexcept nogil


cdef enum Rule:
    BROYDEN
    DAVIDON
    DFP
    BFGS


RULES = {"broyden": BROYDEN, "davidon": DAVIDON, "dfp": DFP, "bfgs": BFGS}
cdef enum:
    MOST_TERMS = 2  # that any rule makes of one pair

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
    # Equation 16 multiplied out: s ((1 + y.h / s.y) s - h)^T / (s.y) - h s^T / (s.y).
    scaled(parts, a, 1.0, s, n)
    combined(parts, w, (1.0 + yh / sy) / sy, s, -1.0 / sy, w + stride, n)
    scaled(parts, a + stride, 1.0, w + stride, n)
    scaled(parts, w + stride, -1.0 / sy, s, n)
    return 2


cdef struct DenseData:
    const ancf_seed *seed
    Rule rule
    ptrdiff_t n, padded, pending
    double smallest_y
    double *columns
    double *a  # two terms of `padded` numbers each, like w
    double *w
    double *product
    double *unit


cdef class Dense:
    """The inverse as a full matrix that learns for as long as the run lasts (``memory="full"``).

    Columns are stored one after another, padded to whole cache lines.  The terms of the newest pair
    wait until the next product, so that a correction passes over the matrix once.
    """

    cdef ancf_inverse interface
    cdef DenseData data
    cdef object owner, columns, terms, work
    cdef readonly object capsule

    def __cinit__(self, seed, str rule):
        cdef DenseData *data = &self.data
        cdef double[:, ::1] columns
        cdef double[:, :, ::1] terms
        cdef double[:, ::1] work
        self.owner = seed
        data.seed = <const ancf_seed *>PyCapsule_GetPointer(seed.capsule, "ancf_seed")
        data.rule = RULES[rule]
        data.n = data.seed.n
        data.padded = (data.n + 7) // 8 * 8
        self.columns = np.zeros((data.n, data.padded))
        self.terms, self.work = np.zeros((2, 2, data.padded)), np.zeros((2, data.padded))
        columns, terms, work = self.columns, self.terms, self.work
        data.columns, data.a, data.w = &columns[0, 0], &terms[0, 0, 0], &terms[1, 0, 0]
        data.product, data.unit = &work[0, 0], &work[1, 0]
        self.interface.context, self.interface.n = data, data.n
        self.interface.reseed, self.interface.forget = dense_reseed, dense_forget
        self.interface.apply, self.interface.learn = dense_apply, dense_learn
        self.capsule = PyCapsule_New(&self.interface, "ancf_inverse", NULL)

    def set_threads(self, ptrdiff_t threads):
        """Take no notice: a matrix this small belongs to one thread."""

    def set_smallest_y(self, double value):
        """Skip pairs whose difference of residuals is shorter than this: rounding."""
        self.data.smallest_y = value

    @property
    def matrix(self):
        """The inverse as an array (n, n), newest pair included."""
        n = self.data.n
        full = self.columns[:, :n].T.copy()
        for k in range(self.data.pending):
            full += np.outer(self.terms[0, k, :n], self.terms[1, k, :n])
        return full

    @matrix.setter
    def matrix(self, value):
        self.data.pending = 0
        self.columns[:, : self.data.n] = np.asarray(value).T

    def apply(self, const double[::1] r):
        """Return ``H r``."""
        z = np.empty(self.data.n)
        cdef double[::1] view = z
        dense_apply(&self.data, &r[0], &view[0])
        return z

    def learn(self, const double[::1] s, const double[::1] y, const double[::1] r_new):
        """Take in the pair; return ``(H_new r_new, accepted)``.  ``s`` must be ``-H r_old``."""
        z = np.empty(self.data.n)
        cdef double[::1] view = z
        return z, bool(dense_learn(&self.data, &s[0], &y[0], &r_new[0], &view[0]))


cdef int dense_reseed(void *context) noexcept nogil:
    cdef DenseData *self = <DenseData *>context
    cdef ptrdiff_t j
    self.pending = 0
    for j in range(self.n):
        self.unit[j] = 1.0
        self.seed.solve(self.seed.context, self.unit, self.columns + j * self.padded)
        self.unit[j] = 0.0
    return <int>self.n


cdef void dense_forget(void *context) noexcept nogil:
    # The pairs are in the matrix for good; only the waiting one can be dropped.
    (<DenseData *>context).pending = 0


cdef void dense_apply(void *context, const double *r, double *z) noexcept nogil:
    """Add the waiting terms to the matrix and multiply: one pass."""
    cdef DenseData *self = <DenseData *>context
    cdef ptrdiff_t n = self.n, step = self.padded // LANES, i, j
    cdef vec *h
    cdef vec *column
    cdef const vec *a0 = <const vec *>self.a
    cdef const vec *a1 = <const vec *>(self.a + self.padded)
    cdef vec *out = <vec *>self.product
    cdef const double *w0 = self.w
    cdef const double *w1 = self.w + self.padded
    cdef vec z0, z1, p0, p1, p2, p3, rj, wj, vj, t0, t1
    i = 0
    while i < step:
        h = <vec *>self.columns + i
        if i + 1 < step:
            z0 = set1(0.0)
            z1 = set1(0.0)
            if self.pending == 0:
                for j in range(n):
                    column = h + j * step
                    rj = set1(r[j])
                    z0 = z0 + column[0] * rj
                    z1 = z1 + column[1] * rj
            elif self.pending == 1:
                p0 = a0[i]
                p1 = a0[i + 1]
                for j in range(n):
                    column = h + j * step
                    rj = set1(r[j])
                    wj = set1(w0[j])
                    t0 = column[0] + p0 * wj
                    t1 = column[1] + p1 * wj
                    column[0] = t0
                    column[1] = t1
                    z0 = z0 + t0 * rj
                    z1 = z1 + t1 * rj
            else:
                p0 = a0[i]
                p1 = a0[i + 1]
                p2 = a1[i]
                p3 = a1[i + 1]
                for j in range(n):
                    column = h + j * step
                    rj = set1(r[j])
                    wj = set1(w0[j])
                    vj = set1(w1[j])
                    t0 = column[0] + p0 * wj + p2 * vj
                    t1 = column[1] + p1 * wj + p3 * vj
                    column[0] = t0
                    column[1] = t1
                    z0 = z0 + t0 * rj
                    z1 = z1 + t1 * rj
            out[i] = z0
            out[i + 1] = z1
            i = i + 2
        else:
            z0 = set1(0.0)
            p0 = a0[i]
            p2 = a1[i]
            for j in range(n):
                column = h + j * step
                t0 = column[0]
                if self.pending > 0:
                    t0 = t0 + p0 * set1(w0[j])
                if self.pending > 1:
                    t0 = t0 + p2 * set1(w1[j])
                column[0] = t0
                z0 = z0 + t0 * set1(r[j])
            out[i] = z0
            i = i + 1
    self.pending = 0
    memcpy(z, out, n * sizeof(double))


cdef int dense_learn(void *context, const double *s, const double *y, const double *r_new,
                     double *z) noexcept nogil:
    cdef DenseData *self = <DenseData *>context
    cdef ptrdiff_t n = self.n, i, j
    cdef int terms, k
    cdef double delta, factor, ss
    dense_apply(context, r_new, z)
    terms = pair_terms(self.rule, 1, n, s, y, z, self.smallest_y, self.a, self.w, self.padded)
    if terms == 0:
        return 0
    if self.rule == BROYDEN:  # equation 13: u (H^T s)^T / (s.h)
        ss = dot(s, s, n)
        delta = ss + dot(s, z, n)
        if not fabs(delta) >= SMALLEST_BROYDEN * ss:
            return 0
        for j in range(n):
            self.w[j] = dot(self.columns + j * self.padded, s, n) / delta
    for k in range(terms):
        factor = dot(self.w + k * self.padded, r_new, n)
        for i in range(n):
            z[i] += factor * self.a[k * self.padded + i]
    self.pending = terms
    return 1


cdef struct LimitedData:
    const ancf_seed *seed
    Rule rule
    ptrdiff_t n, parts, capacity, pairs, count  # pairs and terms held
    double smallest_y
    double *a  # terms of n numbers each, like w
    double *w
    const double *weights


cdef class Limited:
    """A sparse seed and the terms of the last pairs; all of them are dropped when there is no room.

    A rolling window would be wrong: the denominator of each pair presumes the pairs before it.
    Broyden works in product form, in the inner product of ``weights``.
    """

    cdef ancf_inverse interface
    cdef LimitedData data
    cdef object owner, terms, weights
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
            self.weights = np.ones(data.n) if weights is None else np.array(weights, dtype=float)
            terms, weights_view = self.terms, self.weights
            data.a, data.w, data.weights = &terms[0, 0, 0], &terms[1, 0, 0], &weights_view[0]
        self.interface.context, self.interface.n = data, data.n
        self.interface.reseed, self.interface.forget = limited_reseed, limited_forget
        self.interface.apply, self.interface.learn = limited_apply, limited_learn
        self.capsule = PyCapsule_New(&self.interface, "ancf_inverse", NULL)

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for passes over vectors."""
        self.data.parts = threads

    def set_smallest_y(self, double value):
        """Skip pairs whose difference of residuals is shorter than this: rounding."""
        self.data.smallest_y = value

    def apply(self, const double[::1] r):
        """Return ``H r``."""
        z = np.empty(self.data.n)
        cdef double[::1] view = z
        limited_apply(&self.data, &r[0], &view[0])
        return z

    def learn(self, const double[::1] s, const double[::1] y, const double[::1] r_new):
        """Take in the pair; return ``(H_new r_new, accepted)``.  ``s`` must be ``-H r_old``."""
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
    # Broyden's terms act on what the earlier terms made of r, the symmetric ones on r itself.
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
    if self.pairs == self.capacity:  # also with no room at all, which is modified Newton
        limited_forget(context)
        limited_apply(context, r_new, z)
        return 1
    limited_apply(context, r_new, z)
    terms = pair_terms(self.rule, self.parts, n, s, y, z, self.smallest_y,
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
