"""Data of a time loop, and sums over its coordinates in parts; included by `loop.pxi`."""
from libc.math cimport fabs, sqrt
from libc.string cimport memcpy

import numpy as np


include "../../abi/vectors.pxi"

cdef extern from "vectors.h":
    double weigh_apart "vec_weigh_apart" (
        const double *, const double *, const double *, ptrdiff_t) noexcept nogil
    void vec_compare(const double *, const double *, const double *, double *, ptrdiff_t,
                     double *, double *) noexcept nogil
    void vec_changes(const double *, const double *, const double *, const float *, float *,
                     ptrdiff_t, double *) noexcept nogil
    void vec_follow(double *, const double *, double, const float *, double, const float *,
                    ptrdiff_t) noexcept nogil
    double vec_scale_weigh(
        double *, double, const double *, const double *, ptrdiff_t) noexcept nogil
    double vec_advance(double *, double, double *, double, const double *, const double *,
                       ptrdiff_t) noexcept nogil


cdef double STILL = 5e-28  # (100 eps)^2: smaller squares of relative displacements are rounding
cdef ptrdiff_t PIECE = 512  # length of the pieces of vectors that are read more than once


cdef struct Drives:
    # Prescribed functions of time, see drives.pxi.
    ptrdiff_t n, n_equations
    const double *row  # of the current step: n positions, velocities, accelerations, and all of s
    double *force0  # of the prescribed coordinates on the system, after the last accepted step
    double *force  # and after the current step, once its work is known
    double *lead0  # s after the last accepted step
    double *speeds  # workspace for velocities


cdef struct Trend:
    # Changes of accelerations, see trend.pxi.
    bint used  # whether they are followed at all
    bint near  # whether the last prediction was close
    double x, y  # the prediction is x last + y before
    double squares, product, squares_before  # of the last change, with the one before, and of that
    float *last
    float *before
    double *sums  # three of each part


cdef struct Motion:
    const ancf_system *system
    ptrdiff_t n_free, n_all, m, n_parts
    bint measures  # whether displacements are measured, for bounds on corrections
    bint corrected  # whether the iterate is no longer the predictor
    bint elsewhere  # whether the last predictor did not use the last acceleration
    bint ahead  # whether v0 and the work of the loads are already those of the current step
    bint shortens  # whether a step that would gain energy may be repeated in shorter ones
    double dt
    double scale  # derivative of a coordinate with respect to its new acceleration [s2]
    double softness  # violation of an equation per unit of its multiplier, over `scale` [1/kg]
    double jump_share  # fraction of |jump| |motion| by which the scheme's work may be off at a jump
    ancf_watch watch
    ancf_jumps jumps
    # Last accepted state, and the iterate of the current step.
    double *q0
    double *v0
    double *a0
    const double *start  # the acceleration of the predictor
    double *earlier  # the acceleration before a0, if the phase is not UNKNOWN
    double *phase  # of the accelerations, see start.pxi
    double *lam0
    double *q
    double *v  # only if forces depend on it
    double *a
    double *lam
    double *amplitudes0
    const double *dead_load
    const double *amplitudes
    double *r
    double *phi
    double *out  # where the scaled residual goes
    const double *s  # the current correction, its factor, and the sum of squares of each part
    double factor
    ptrdiff_t corrections  # in the current step, since its last start
    double *squares
    double *others
    Drives drives
    Trend trend
    double *ways  # squared displacement of each part, updated by an energy-conserving scheme
    ancf_equations *interface
    Scheme scheme


cdef double *kept(dict own, str name, values) except NULL:
    """Store a copy of an array by name; return its address."""
    cdef double[::1] view
    own[name] = view = np.array(values, dtype=float)
    return &view[0]


cdef double *reserved(dict own, str name, ptrdiff_t n) except NULL:
    """Allocate an array, which takes up memory only once it is written to."""
    cdef double[::1] view
    own[name] = view = np.zeros(n)
    return &view[0]


cdef float *reserved_singles(dict own, str name, ptrdiff_t n) except NULL:
    """The same in single precision."""
    cdef float[::1] view
    own[name] = view = np.zeros(n, dtype=np.float32)
    return &view[0]


cdef inline ptrdiff_t share(const Motion *self, ptrdiff_t part) noexcept nogil:
    """First free coordinate of a part: each part has whole cache lines."""
    if part == self.n_parts:
        return self.n_free
    return self.n_free // 8 * part // self.n_parts * 8


cdef inline double weighed(const Motion *self, const double *x, ptrdiff_t begin,
                           ptrdiff_t end) noexcept nogil:
    """Sum of mass x^2 over a range of free coordinates; ``x`` starts at that range."""
    if self.interface.mass == NULL:
        return dot(x, x, end - begin)
    return weigh(self.interface.mass + begin, x, end - begin)


cdef inline double way(const Motion *self, ptrdiff_t begin, ptrdiff_t end) noexcept nogil:
    """Sum of mass (q - q0)^2 over a range of free coordinates, if there are masses."""
    if self.interface.mass == NULL:
        return 0.0
    return weigh_apart(self.interface.mass + begin, self.q + begin, self.q0 + begin, end - begin)


cdef inline double total(const Motion *self, const double *parts) noexcept nogil:
    cdef double out = 0.0
    cdef ptrdiff_t i
    for i in range(self.n_parts):
        out += parts[i]
    return out
