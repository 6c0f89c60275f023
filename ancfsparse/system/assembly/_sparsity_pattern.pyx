# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Sparsity pattern of cliques of unknowns, and the slots of their pairs, in time linear in the mesh."""
from libc.stdint cimport int32_t, int64_t

import numpy as np

include "../../abi/sort.pxi"


def lower_triangle(ptrdiff_t n, const int64_t[::1] start, const int32_t[::1] member):
    """Return ``indptr (n + 1,)`` and ``indices`` of the lower triangle by columns, diagonal included.

    Parameters
    ----------
    n : int
        Number of unknowns.
    start, member : (n_cliques + 1,) int64 and int32 arrays
        Clique c is ``member[start[c]:start[c + 1]]``, all of which are coupled; negative entries
        are ignored.
    """
    cdef ptrdiff_t n_cliques = start.shape[0] - 1, c, j
    cdef int64_t p, s, where, begin
    cdef int32_t i
    touched_by, touching = np.zeros(n + 1, np.int64), np.empty(member.shape[0], np.int32)
    indptr_array, seen_array = np.zeros(n + 1, np.int64), np.full(n, -1, np.int32)
    cdef int64_t[::1] first = touched_by, indptr = indptr_array
    cdef int32_t[::1] clique = touching, seen = seen_array, indices
    for p in range(member.shape[0]):
        if member[p] >= 0:
            first[member[p] + 1] += 1
    for j in range(n):
        first[j + 1] += first[j]
    for c in range(n_cliques):
        for p in range(start[c], start[c + 1]):
            if member[p] >= 0:
                clique[first[member[p]]] = <int32_t>c
                first[member[p]] += 1
    # Now first[j] is the end of list j, so list j begins at the end of list j - 1.
    for j in range(n):
        seen[j] = <int32_t>j
        indptr[j + 1] = indptr[j] + 1
        begin = first[j - 1] if j > 0 else 0
        for s in range(begin, first[j]):
            for p in range(start[clique[s]], start[clique[s] + 1]):
                i = member[p]
                if i > j and seen[i] != j:
                    seen[i] = <int32_t>j
                    indptr[j + 1] += 1
    indices_array = np.empty(indptr[n], np.int32)
    indices = indices_array
    seen_array[:] = -1
    for j in range(n):
        where = indptr[j]
        indices[where] = <int32_t>j
        begin = first[j - 1] if j > 0 else 0
        for s in range(begin, first[j]):
            for p in range(start[clique[s]], start[clique[s] + 1]):
                i = member[p]
                if i > j and seen[i] != j:
                    seen[i] = <int32_t>j
                    where += 1
                    indices[where] = i
        sort(&indices[indptr[j]], indptr[j + 1] - indptr[j])
    return indptr_array, indices_array


def pair_slots(const int64_t[::1] indptr, const int32_t[::1] indices, const int32_t[:, ::1] members):
    """Return the slots of the pairs of each row's unknowns, lower triangle by rows.

    Parameters
    ----------
    indptr, indices : arrays
        The pattern.
    members : (n_cliques, k) int32
        Unknowns; pairs with a negative one get the slot after the last.

    Returns
    -------
    (n_cliques, k (k + 1) / 2) int32
    """
    cdef ptrdiff_t n_cliques = members.shape[0], k = members.shape[1], c, a, b, pair
    cdef int32_t i, j
    cdef int64_t low, high, middle
    slots_array = np.empty((n_cliques, k * (k + 1) // 2), np.int32)
    cdef int32_t[:, ::1] slots = slots_array
    for c in range(n_cliques):
        pair = 0
        for a in range(k):
            for b in range(a + 1):
                i, j = members[c, a], members[c, b]
                if i < j:
                    i, j = j, i
                if j < 0:
                    slots[c, pair] = <int32_t>indices.shape[0]
                else:
                    low, high = indptr[j], indptr[j + 1]
                    while high - low > 1:
                        middle = (low + high) // 2
                        if indices[middle] <= i:
                            low = middle
                        else:
                            high = middle
                    slots[c, pair] = <int32_t>low
                pair += 1
    return slots_array
