# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""The quasi-Newton inverse as a sparse seed and the terms ``a w^T`` of the last few pairs."""

include "secant_pairs.pxi"


cdef enum:
    MOST_TERMS = 2  # per pair, over all rules


cdef struct LimitedData:
    const ancf_seed *seed
    Rule rule
    ptrdiff_t n, parts, capacity, pairs, count  # last two: number of pairs and of terms
    const Guard *guard
    double *a  # terms of n numbers each, like w
    double *w
    const double *weights


cdef class Limited(SecantInverse):
    """A sparse seed and the terms of the last pairs; all pairs are dropped when storage is full.

    A rolling window would be wrong: the denominator of each pair depends on the previous pairs.
    Broyden's update is in product form, in the inner product of ``weights``.
    """

    cdef LimitedData data

    def __cinit__(self, seed, str rule, ptrdiff_t n_pairs, weights=None):
        cdef LimitedData *data = &self.data
        cdef double[:, :, ::1] terms
        cdef const double[::1] weights_view
        data.seed, data.guard, data.rule = self.seed, &self.guard, RULES[rule]
        data.n, data.parts = data.seed.n, 1
        data.capacity = n_pairs
        if n_pairs > 0:
            self.set_guard(np.ones(data.n), 0.0)
            self.own["terms"] = terms = np.zeros((2, MOST_TERMS * n_pairs, data.n))
            data.a, data.w = &terms[0, 0, 0], &terms[1, 0, 0]
            if data.rule == BROYDEN:
                weights_view = np.ones(data.n) if weights is None else np.array(weights, dtype=float)
                self.own["weights"] = weights_view
                data.weights = &weights_view[0]
        self.interface.context, self.interface.n = data, data.n
        self.interface.reseed, self.interface.forget = limited_reseed, limited_forget
        self.interface.apply, self.interface.learn = limited_apply, limited_learn

    def set_threads(self, ptrdiff_t threads):
        """Set the number of threads for vector operations."""
        self.data.parts = threads


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
    terms = pair_terms(self.rule, self.parts, n, s, y, z, self.guard,
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
