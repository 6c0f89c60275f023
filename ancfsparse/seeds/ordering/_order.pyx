# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Fill-reducing orders of elimination by AMD and METIS, whose sources are in vendored/."""
from libc.stdint cimport INT32_MAX, int32_t, int64_t

import numpy as np

cdef extern from "amd.h" nogil:
    void amd_2(int32_t n, int32_t *start, int32_t *neighbour, int32_t *degree, int32_t size, int32_t first_free,
               int32_t *nv, int32_t *next, int32_t *last, int32_t *head, int32_t *elen, int32_t *approximate,
               int32_t *w, double *control, double *info)
    enum: AMD_INFO

cdef extern from "metis.h" nogil:
    int METIS_NodeND(int32_t *n, int32_t *start, int32_t *neighbour, int32_t *weight, int32_t *options,
                     int32_t *permutation, int32_t *position)
    enum: METIS_OK


def amd(const int64_t[::1] indptr, const int32_t[::1] indices):
    """Return the order of approximate minimum degree, ``(n,)`` int32.

    Parameters
    ----------
    indptr, indices : (n + 1,) int64 and (nnz,) int32
        Lower triangle by columns, with or without the diagonal.
    """
    cdef int32_t n = <int32_t>(indptr.shape[0] - 1)
    cdef int32_t[::1] start, neighbour, permutation
    cdef int32_t[:, ::1] work
    cdef double info[AMD_INFO]
    out = np.empty(n, dtype=np.int32)
    if n == 0:
        return out
    # Room for the elements that it forms; CHOLMOD gives it as much.
    starts, neighbours = _neighbours(indptr, indices, 1.5, n)
    start, neighbour, permutation = starts, neighbours, out
    work = np.empty((7, n), dtype=np.int32)
    cdef ptrdiff_t j
    with nogil:
        for j in range(n):
            work[0, j] = start[j + 1] - start[j]
        amd_2(n, &start[0], &neighbour[0], &work[0, 0], <int32_t>neighbour.shape[0], start[n], &work[1, 0],
              &work[2, 0], &permutation[0], &work[3, 0], &work[4, 0], &work[5, 0], &work[6, 0], NULL, info)
    return out


def metis(const int64_t[::1] indptr, const int32_t[::1] indices):
    """Return the order of nested dissection, as `amd`."""
    cdef int32_t n = <int32_t>(indptr.shape[0] - 1)
    cdef int32_t[::1] start, neighbour, permutation, position
    cdef int status
    starts, neighbours = _neighbours(indptr, indices, 1.0, 0)
    if len(neighbours) == 0:  # METIS takes no graph without edges
        return np.arange(n, dtype=np.int32)
    out = np.empty(n, dtype=np.int32)
    start, neighbour, permutation, position = starts, neighbours, out, np.empty(n, dtype=np.int32)
    with nogil:
        status = METIS_NodeND(&n, &start[0], &neighbour[0], NULL, NULL, &permutation[0], &position[0])
    if status != METIS_OK:
        raise MemoryError(f"no memory to order {n} unknowns, {len(neighbours) // 2} pairs of which are coupled")
    return out


cdef _neighbours(const int64_t[::1] indptr, const int32_t[::1] indices, double factor, ptrdiff_t more):
    """Return starts of neighbours of each unknown, int32, and the neighbours, ascending.

    Their array has room for their number times a factor, and for `more`.
    """
    cdef ptrdiff_t n = indptr.shape[0] - 1, j
    cdef int64_t p, size = 0
    cdef int32_t i
    with nogil:
        for j in range(n):
            for p in range(indptr[j], indptr[j + 1]):
                size += 2 * (indices[p] != j)
    cdef int64_t room = <int64_t>(factor * size) + more
    if room >= INT32_MAX:
        raise MemoryError(
            f"{size // 2} pairs of coupled unknowns need {room} indices to be ordered, "
            f"which are limited to {INT32_MAX}. Take an incomplete factorization."
        )
    starts, neighbours = np.zeros(n + 2, dtype=np.int32), np.empty(room, dtype=np.int32)
    cdef int32_t[::1] start = starts, neighbour = neighbours
    # Counts are stored two positions ahead, so that filling turns each of them into a start.
    with nogil:
        for j in range(n):
            for p in range(indptr[j], indptr[j + 1]):
                i = indices[p]
                if i != j:
                    start[i + 2] += 1
                    start[j + 2] += 1
        for j in range(n):
            start[j + 2] += start[j + 1]
        for j in range(n):  # first those before an unknown, column by column
            for p in range(indptr[j], indptr[j + 1]):
                i = indices[p]
                if i != j:
                    neighbour[start[i + 1]] = <int32_t>j
                    start[i + 1] += 1
        for j in range(n):  # then those after it
            for p in range(indptr[j], indptr[j + 1]):
                i = indices[p]
                if i != j:
                    neighbour[start[j + 1]] = i
                    start[j + 1] += 1
    return starts[:n + 1], neighbours
