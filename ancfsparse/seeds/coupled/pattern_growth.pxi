"""The pattern of a matrix with further entries; an include file."""


def grow_pattern(const int64_t[::1] indptr, const int32_t[::1] indices, const int32_t[::1] row,
          const int32_t[::1] column):
    """Return a pattern with further entries, in time linear in their number but for sorting columns.

    Parameters
    ----------
    indptr, indices : (n + 1,) int64 and (nnz,) int32
        Lower triangle by columns, diagonal included.
    row, column : (k,) int32
        Further entries in either triangle, which may repeat; those with a negative index are left out.

    Returns
    -------
    indptr, indices : arrays
        The new pattern.
    slot, slot_of_more : (nnz,) and (k,) int32
        Positions of the old entries in it, and of the further ones; of those left out, its size, and
        of those on the diagonal, which both triangles contain, p coded as -1 - p.
    """
    cdef ptrdiff_t n = indptr.shape[0] - 1, n_more = row.shape[0], j, k
    cdef int64_t p, begin, low, high, middle
    cdef int32_t i, c
    counts, seen_array = np.zeros(n + 2, np.int64), np.full(n, -1, np.int32)
    rows, starts = np.empty(n_more + 1, np.int32), np.zeros(n + 1, np.int64)
    out = np.empty(indices.shape[0] + n_more, np.int32)
    old, more = np.empty(indices.shape[0], np.int32), np.empty(n_more + 1, np.int32)
    cdef int64_t[::1] first = counts, start = starts
    cdef int32_t[::1] of_column = rows, seen = seen_array, index = out, slot = old, at = more
    # Counts are stored two positions ahead, so that filling turns each of them into a column start.
    for k in range(n_more):
        if row[k] >= 0 and column[k] >= 0:
            first[min(row[k], column[k]) + 2] += 1
    for j in range(n):
        first[j + 2] += first[j + 1]
    for k in range(n_more):
        if row[k] >= 0 and column[k] >= 0:
            c = min(row[k], column[k])
            of_column[first[c + 1]] = max(row[k], column[k])
            first[c + 1] += 1
    for j in range(n):
        p = start[j]
        for k in range(indptr[j], indptr[j + 1]):
            seen[indices[k]] = <int32_t>j
            index[p] = indices[k]
            p += 1
        begin = p
        for k in range(first[j], first[j + 1]):
            i = of_column[k]
            if seen[i] != j:
                seen[i] = <int32_t>j
                index[p] = i
                p += 1
        start[j + 1] = p
        if p > begin:
            sort(&index[start[j]], p - start[j])
        p = start[j]
        for k in range(indptr[j], indptr[j + 1]):
            while index[p] != indices[k]:
                p += 1
            slot[k] = <int32_t>p
    for k in range(n_more):
        if row[k] < 0 or column[k] < 0:
            at[k] = <int32_t>start[n]
            continue
        c, i = min(row[k], column[k]), max(row[k], column[k])
        low, high = start[c], start[c + 1]
        while high - low > 1:
            middle = (low + high) // 2
            if index[middle] <= i:
                low = middle
            else:
                high = middle
        at[k] = <int32_t>(low if c < i else -1 - low)
    return starts, out[:start[n]].copy(), old, more[:n_more]
