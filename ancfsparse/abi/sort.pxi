"""Sorting of indices in ascending order; an include file."""
cdef void sort(int32_t *x, int64_t n) noexcept nogil:
    # Columns of a mesh are short: insertion sort is the fastest.
    cdef int64_t i, k
    cdef int32_t held
    for i in range(1, n):
        held = x[i]
        k = i
        while k > 0 and x[k - 1] > held:
            x[k] = x[k - 1]
            k -= 1
        x[k] = held
