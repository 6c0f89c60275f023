# cython: boundscheck=False, wraparound=False, initializedcheck=False
"""Call an element kernel from Python, for tests and benchmarks."""

from cpython.pycapsule cimport PyCapsule_GetPointer
from libc.stdint cimport int32_t

cdef extern from "kernel_abi.h" nogil:
    const char *ANCF_KERNEL_SIGNATURE
    ctypedef void (*ancf_kernel)(
        ptrdiff_t n_blocks, const int32_t *gather, const int32_t *scatter, const int32_t *set_of,
        const double *parameters, const double *q, const double *a, double *out,
    ) noexcept


SIGNATURE = ANCF_KERNEL_SIGNATURE.decode("ascii")


def call(
    object kernel, const int32_t[:, :, ::1] gather, const int32_t[:, :, ::1] scatter,
    const int32_t[::1] set_of, const double[:, :, ::1] parameters,
    const double[::1] q, const double[::1] a, double[::1] out, ptrdiff_t repeat=1,
):
    """Add the result of a kernel to `out`, `repeat` times.

    The arrays are those of `layout.Layout`; their indices are not checked.
    """
    cdef ancf_kernel run = <ancf_kernel>PyCapsule_GetPointer(kernel, ANCF_KERNEL_SIGNATURE)
    cdef ptrdiff_t n_blocks = set_of.shape[0]
    cdef ptrdiff_t i
    if n_blocks == 0:
        return
    if gather.shape[0] != n_blocks or scatter.shape[0] != n_blocks or a.shape[0] != q.shape[0]:
        raise ValueError("gather, scatter and set_of need one entry per block; a and q, equal size")
    with nogil:
        for i in range(repeat):
            run(n_blocks, &gather[0, 0, 0], &scatter[0, 0, 0], &set_of[0],
                &parameters[0, 0, 0], &q[0], &a[0], &out[0])
