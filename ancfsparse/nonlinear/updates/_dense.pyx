# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The quasi-Newton inverse as a dense matrix; each pair adds terms ``a w^T`` (the paper's form)."""
from libc.string cimport memcpy, memset

cdef extern from "simd.h":
    const int LANES "ANCF_LANES"
    ctypedef double vec
    vec set1 "vec_set1" (double) noexcept nogil

include "secant_pairs.pxi"


cdef struct DenseData:
    const ancf_seed *seed
    Rule rule
    ptrdiff_t n, padded, pending
    const Guard *guard
    double *columns
    double *a  # two terms of `padded` numbers each, like w
    double *w
    double *product
    double *space  # of `ancf_seed.inverse`
    const double *weights  # inner product of Broyden's update, NULL for the plain one


cdef enum:
    CACHE_LINE = 8  # numbers


cdef double *aligned(dict own, str name, ptrdiff_t n) except NULL:
    """Allocate zeros from the start of a cache line, so that no vector crosses one."""
    cdef double[::1] room = np.zeros(n + CACHE_LINE)
    cdef ptrdiff_t past = <ptrdiff_t>&room[0] // <ptrdiff_t>sizeof(double) % CACHE_LINE
    own[name] = room = room[CACHE_LINE - past : CACHE_LINE - past + n]
    return &room[0]


cdef class Dense(SecantInverse):
    """The inverse as a dense matrix that keeps all pairs of the run (``memory="full"``).

    Columns are stored contiguously, padded to whole cache lines.  The terms of the newest pair are
    added in the next product, so that each correction passes over the matrix once.

    Parameters
    ----------
    seed : object with a ``capsule`` "ancf_seed"
    rule : str
        Name of the update.
    weights : (n,) float, optional
        Inner product for Broyden's update; default: the Euclidean one.
    """

    cdef DenseData data

    def __cinit__(self, seed, str rule, weights=None):
        cdef DenseData *data = &self.data
        cdef double[::1] weights_view
        self.set_guard(np.ones(self.seed.n), 0.0)
        data.seed, data.guard, data.rule = self.seed, &self.guard, RULES[rule]
        data.n = data.seed.n
        data.padded = (data.n + 7) // 8 * 8
        data.columns = aligned(self.own, "columns", data.n * data.padded)
        data.a = aligned(self.own, "a", 2 * data.padded)
        data.w = aligned(self.own, "w", 2 * data.padded)
        data.product = aligned(self.own, "product", data.padded)
        data.space = aligned(self.own, "space", 8 * data.n)
        if weights is not None:
            self.own["weights"] = weights_view = np.array(weights, dtype=float)
            data.weights = &weights_view[0]
        self.interface.context, self.interface.n = data, data.n
        self.interface.reseed, self.interface.forget = dense_reseed, dense_forget
        self.interface.apply, self.interface.learn = dense_apply, dense_learn

    def set_threads(self, ptrdiff_t threads):
        """Ignored: matrices this small are processed by one thread."""

    @property
    def matrix(self):
        """The inverse as an array (n, n), including the newest pair."""
        n, padded = self.data.n, self.data.padded
        full = np.reshape(self.own["columns"], (n, padded))[:, :n].T.copy()
        for k in range(0, self.data.pending * padded, padded):
            full += np.outer(self.own["a"][k : k + n], self.own["w"][k : k + n])
        return full

    @matrix.setter
    def matrix(self, value):
        self.data.pending = 0
        columns = np.reshape(self.own["columns"], (self.data.n, self.data.padded))
        columns[:, : self.data.n] = np.asarray(value).T


cdef int dense_reseed(void *context) noexcept nogil:
    cdef DenseData *self = <DenseData *>context
    cdef ptrdiff_t j
    self.pending = 0
    if self.seed.inverse != NULL:
        self.seed.inverse(self.seed.context, self.columns, self.padded, self.space)
        return <int>self.n
    memset(self.space, 0, self.n * sizeof(double))
    for j in range(self.n):
        self.space[j] = 1.0
        self.seed.solve(self.seed.context, self.space, self.columns + j * self.padded)
        self.space[j] = 0.0
    return <int>self.n


cdef void dense_forget(void *context) noexcept nogil:
    # The pairs are part of the matrix; only the pending one can be dropped.
    (<DenseData *>context).pending = 0


cdef void dense_apply(void *context, const double *r, double *z) noexcept nogil:
    """Add the pending terms to the matrix and multiply, in one pass."""
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
    cdef int terms
    cdef double delta, factor, other, ss
    cdef const double *weighed = s  # D s
    dense_apply(context, r_new, z)
    terms = pair_terms(self.rule, 1, n, s, y, z, self.guard, self.a, self.w, self.padded)
    if terms == 0:
        return 0
    if self.rule == BROYDEN:  # equation 13: u (H^T D s)^T / (s.D h), in the paper D = 1
        if self.weights != NULL:
            for i in range(n):
                self.product[i] = self.weights[i] * s[i]
            weighed = self.product
        ss = dot(weighed, s, n)
        delta = ss + dot(weighed, z, n)
        if not fabs(delta) >= SMALLEST_BROYDEN * ss:
            return 0
        for j in range(n):
            self.w[j] = dot(self.columns + j * self.padded, weighed, n) / delta
    factor = dot(self.w, r_new, n)
    if terms == 1:
        for i in range(n):
            z[i] += factor * self.a[i]
    else:
        other = dot(self.w + self.padded, r_new, n)
        for i in range(n):
            z[i] += factor * self.a[i] + other * self.a[self.padded + i]
    self.pending = terms
    return 1
