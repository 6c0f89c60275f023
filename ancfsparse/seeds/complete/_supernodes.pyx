# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Symbolic factorization for L D L^T: elimination tree, supernodes, parts.

It is done once per sparsity pattern.
"""
from libc.stdint cimport INT64_MAX, int32_t, int64_t

import numpy as np

include "../../abi/sort.pxi"


def permuted_upper(const int64_t[::1] indptr, const int32_t[::1] indices,
                   const int32_t[::1] permutation):
    """Return the upper triangle by columns of a permuted matrix: starts and rows, diagonal included.

    Parameters
    ----------
    indptr, indices : (n + 1,) int64 and (nnz,) int32
        Lower triangle by columns.
    permutation : (n,) int32
        Unknown at each position.
    """
    cdef ptrdiff_t n = permutation.shape[0], j
    cdef int64_t p, to
    cdef int32_t row, column
    starts, places = np.zeros(n + 2, dtype=np.int64), np.empty(n, dtype=np.int32)
    rows = np.empty(indices.shape[0], dtype=np.int32)
    cdef int64_t[::1] start = starts
    cdef int32_t[::1] place = places, out_row = rows
    for j in range(n):
        place[permutation[j]] = <int32_t>j
    # Counts are stored two positions ahead, so that filling turns each of them into a column start.
    for j in range(n):
        for p in range(indptr[j], indptr[j + 1]):
            start[max(place[indices[p]], place[j]) + 2] += 1
    for j in range(n):
        start[j + 2] += start[j + 1]
    for j in range(n):
        for p in range(indptr[j], indptr[j + 1]):
            row, column = place[indices[p]], place[j]
            if row > column:
                row, column = column, row
            to = start[column + 1]
            start[column + 1] += 1
            out_row[to] = row
    return starts[:n + 1], rows


def lower_columns(const int64_t[::1] upper_start, const int32_t[::1] upper_row):
    """Transpose an upper triangle by columns, without the diagonal; rows are ascending."""
    cdef ptrdiff_t n = upper_start.shape[0] - 1, j
    cdef int64_t p
    starts = np.zeros(n + 2, dtype=np.int64)
    cdef int64_t[::1] start = starts
    cdef int32_t[::1] row
    for j in range(n):
        for p in range(upper_start[j], upper_start[j + 1]):
            start[upper_row[p] + 2] += upper_row[p] != j
    for j in range(n):
        start[j + 2] += start[j + 1]
    # One more entry than needed, so that a pointer to the first always exists.
    rows = np.zeros(start[n + 1] + 1, dtype=np.int32)
    row = rows
    for j in range(n):
        for p in range(upper_start[j], upper_start[j + 1]):
            if upper_row[p] != j:
                row[start[upper_row[p] + 1]] = <int32_t>j
                start[upper_row[p] + 1] += 1
    return starts[:n + 1], rows


def alike(const int64_t[::1] indptr, const int32_t[::1] indices):
    """Return the group (n,) int32 of each unknown: consecutive ones with the same rows are a group."""
    cdef ptrdiff_t n = indptr.shape[0] - 1, j, k, length
    cdef int32_t group = 0
    cdef bint same
    groups = np.zeros(n, np.int32)
    cdef int32_t[::1] out = groups
    for j in range(1, n):
        length = indptr[j + 1] - indptr[j]
        same = indptr[j] - indptr[j - 1] == length + 1
        k = 0
        while same and k < length:
            same = indices[indptr[j - 1] + 1 + k] == indices[indptr[j] + k]
            k += 1
        group += not same
        out[j] = group
    return groups


def contracted(const int64_t[::1] indptr, const int32_t[::1] indices, const int32_t[::1] group,
               ptrdiff_t n_groups):
    """Return the lower triangle by columns of coupled groups of unknowns, including the diagonal.

    Parameters
    ----------
    indptr, indices : (n + 1,) int64 and (nnz,) int32
        Lower triangle by columns of the matrix of the unknowns.
    group : (n,) int32
        Group of each unknown.
    n_groups : int
        Number of groups.
    """
    cdef ptrdiff_t n = group.shape[0], j
    cdef int64_t p, where
    cdef int32_t g, before
    starts, ends = np.zeros(n_groups + 2, dtype=np.int64), np.zeros(n_groups + 1, dtype=np.int64)
    cdef int64_t[::1] start = starts, end = ends
    cdef int32_t[::1] found, seen
    # Pairs of groups; consecutive equal ones in a column are counted once.
    for j in range(n):
        before = -1
        for p in range(indptr[j], indptr[j + 1]):
            g = group[indices[p]]
            if g != before:
                start[min(g, group[j]) + 2] += 1
            before = g
    for j in range(n_groups):
        start[j + 2] += start[j + 1]
    pairs = np.empty(start[n_groups + 1], dtype=np.int32)
    found = pairs
    for j in range(n):
        before = -1
        for p in range(indptr[j], indptr[j + 1]):
            g = group[indices[p]]
            if g != before:
                found[start[min(g, group[j]) + 1]] = max(g, group[j])
                start[min(g, group[j]) + 1] += 1
            before = g
    marks = np.full(n_groups, -1, dtype=np.int32)
    seen = marks
    where = 0
    for j in range(n_groups):
        for p in range(start[j], start[j + 1]):
            g = found[p]
            if seen[g] != j:
                seen[g] = <int32_t>j
                found[where] = g
                where += 1
        end[j + 1] = where
        sort(&found[end[j]], where - end[j])
    return ends, pairs[:where].copy()


def elimination_tree(const int64_t[::1] upper_start, const int32_t[::1] upper_row,
                     int64_t most=INT64_MAX):
    """Return the elimination tree and the length below the diagonal of each column of L, ``(n,)``.

    Row k of L has an entry in each column below k on the paths up the tree that start from the
    entries of column k of the upper triangle.  If there are more than ``most`` entries in total,
    the search stops and None is returned.
    """
    cdef ptrdiff_t n = upper_start.shape[0] - 1, k, i
    cdef int64_t total = 0
    cdef int64_t p
    parents, flags = np.full(n, -1, dtype=np.int32), np.zeros(n, dtype=np.int32)
    lengths = np.zeros(n, dtype=np.int32)
    cdef int32_t[::1] parent = parents, flag = flags, length = lengths
    for k in range(n):
        flag[k] = <int32_t>k
        for p in range(upper_start[k], upper_start[k + 1]):
            i = upper_row[p]
            while flag[i] != k:
                if parent[i] == -1:
                    parent[i] = <int32_t>k
                length[i] += 1
                total += 1
                flag[i] = <int32_t>k
                i = parent[i]
        if total > most:
            return None
    return parents, lengths


def postorder(const int32_t[::1] parent, const int32_t[::1] column_length):
    """Return the columns, ``(n,)`` int32, such that every subtree is consecutive, before its root.

    L keeps its entries.  Of the children of a column the longest comes last: it alone can be in one
    supernode with its parent.

    Parameters
    ----------
    parent, column_length : (n,) int32
        As `elimination_tree` returns them.
    """
    cdef ptrdiff_t n = parent.shape[0], k, place = 0
    cdef int32_t j
    firsts, others = np.full(n + 1, -1, dtype=np.int32), np.empty(n, dtype=np.int32)
    out = np.empty(n, dtype=np.int32)
    ascending = np.argsort(column_length, kind="stable").astype(np.int32)
    # A list of children for each column, and in the last place the list of roots.
    cdef int32_t[::1] first = firsts, following = others, order = out, by_length = ascending
    for k in range(n):
        j = by_length[n - 1 - k]
        following[j] = first[parent[j] if parent[j] >= 0 else n]
        first[parent[j] if parent[j] >= 0 else n] = j
    j = first[n]
    while j != -1:
        while first[j] != -1:  # down to a leaf, so that a column is listed after its children
            k = first[j]
            first[j] = -1
            j = <int32_t>k
        order[place] = j
        place += 1
        j = following[j] if following[j] != -1 else parent[j]
    return out


def supernodes(parent, column_length, breaks=()):
    """Return first columns (and n), supernode of each column, their tree, and starts of their rows.

    A column joins the previous one if it is its parent and has the same pattern below the diagonal,
    except for itself.

    Parameters
    ----------
    parent, column_length : (n,) int32
        As `elimination_tree` returns them.
    breaks : sequence of int, optional
        Columns that always start a supernode.
    """
    n = len(parent)
    starts = np.ones(n, dtype=bool)
    starts[1:] = (parent[:-1] != np.arange(1, n)) | (column_length[:-1] != column_length[1:] + 1)
    starts[[column for column in breaks if column < n]] = True
    first = np.append(np.flatnonzero(starts), n).astype(np.int32)
    super_of = np.cumsum(starts, dtype=np.int32)
    super_of -= np.int32(1)
    last = first[1:] - 1
    up = parent[last]
    super_parent = np.where(up >= 0, super_of[np.maximum(up, 0)], -1).astype(np.int32)
    row_start = np.zeros(len(last) + 1, dtype=np.int64)
    np.cumsum(column_length[last], out=row_start[1:])
    return first, super_of, super_parent, row_start


def supernode_rows(const int64_t[::1] upper_start, const int32_t[::1] upper_row,
                   const int32_t[::1] first, const int32_t[::1] super_of,
                   const int32_t[::1] parent, const int64_t[::1] row_start):
    """Return the rows below each supernode, ascending, one supernode after another, int32."""
    cdef ptrdiff_t n = super_of.shape[0], n_super = parent.shape[0], k, s
    cdef int64_t p
    # One more entry than needed, so that a pointer to the first always exists.
    rows = np.zeros(row_start[n_super] + 1, dtype=np.int32)
    filled, flags = np.array(row_start), np.full(n_super, -1, dtype=np.int32)
    cdef int32_t[::1] row = rows, flag = flags
    cdef int64_t[::1] end = filled
    for k in range(n):
        flag[super_of[k]] = <int32_t>k
        for p in range(upper_start[k], upper_start[k + 1]):
            s = super_of[upper_row[p]]
            while flag[s] != k:
                flag[s] = <int32_t>k
                row[end[s]] = <int32_t>k
                end[s] += 1
                s = parent[s]
    return rows


def subtree_sums(const int32_t[::1] parent, const int64_t[::1] work):
    """Return for each supernode the work of the subtree rooted at it, int64."""
    cdef ptrdiff_t s
    totals = np.array(work)
    cdef int64_t[::1] total = totals
    for s in range(parent.shape[0]):  # children come before their parents
        if parent[s] >= 0:
            total[parent[s]] += total[s]
    return totals


def inherit(const int32_t[::1] parent, int32_t[::1] owner):
    """Pass the owner (not -1) of each supernode on to all its descendants, in place."""
    cdef ptrdiff_t s
    for s in range(parent.shape[0] - 1, -1, -1):
        if owner[s] == -1 and parent[s] >= 0:
            owner[s] = owner[parent[s]]
