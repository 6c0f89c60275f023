# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""An inverse that rotates with the body: R H R^T, where H is stored in the axes of the seed.

Secant pairs are stored in those axes too, so they stay valid when R changes.
"""
from libc.string cimport memcpy

include "inverse.pxi"


cdef struct Turned:
    const ancf_inverse *inverse
    const ancf_frame *frame
    ptrdiff_t n
    # In the axes of the seed: argument and result of the last product, and a pair.
    double *r
    double *z
    double *s
    double *y
    double *r_new


cdef class Corotated(CompiledInverse):
    """Apply an inverse in a rotating frame.

    Parameters
    ----------
    inverse : object with a ``capsule`` "ancf_inverse"
    frame : object with a ``capsule`` "ancf_frame"
    """

    cdef Turned data
    cdef object vectors

    def __cinit__(self, inverse, frame):
        cdef Turned *data = &self.data
        cdef double[:, ::1] vectors
        data.inverse = <const ancf_inverse *>PyCapsule_GetPointer(inverse.capsule, "ancf_inverse")
        data.frame = <const ancf_frame *>PyCapsule_GetPointer(frame.capsule, "ancf_frame")
        data.n = data.inverse.n
        if data.frame.n != data.n:
            raise ValueError("inverse and frame differ in size")
        self.vectors = np.zeros((5, data.n))
        vectors = self.vectors
        data.r, data.z, data.s = &vectors[0, 0], &vectors[1, 0], &vectors[2, 0]
        data.y, data.r_new = &vectors[3, 0], &vectors[4, 0]
        self.interface.context, self.interface.n = data, data.n
        self.interface.reseed, self.interface.forget = reseed, forget
        self.interface.apply, self.interface.learn = apply, learn


cdef int reseed(void *context) noexcept nogil:
    cdef Turned *self = <Turned *>context
    return self.inverse.reseed(self.inverse.context)


cdef void forget(void *context) noexcept nogil:
    cdef Turned *self = <Turned *>context
    self.inverse.forget(self.inverse.context)


cdef void apply(void *context, const double *r, double *z) noexcept nogil:
    cdef Turned *self = <Turned *>context
    self.frame.backward(self.frame.context, r, self.r)
    self.inverse.apply(self.inverse.context, self.r, self.z)
    self.frame.forward(self.frame.context, self.z, z)


cdef int learn(void *context, const double *s, const double *y, const double *r_new,
               double *z) noexcept nogil:
    """Update with the pair of the last product, s = -z, y = r_new - r, which needs no rotation."""
    cdef Turned *self = <Turned *>context
    cdef ptrdiff_t i
    cdef int taken
    self.frame.backward(self.frame.context, r_new, self.r_new)
    for i in range(self.n):
        self.s[i] = -self.z[i]
        self.y[i] = self.r_new[i] - self.r[i]
    memcpy(self.r, self.r_new, self.n * sizeof(double))
    taken = self.inverse.learn(self.inverse.context, self.s, self.y, self.r_new, self.z)
    self.frame.forward(self.frame.context, self.z, z)
    return taken
