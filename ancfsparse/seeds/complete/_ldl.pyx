# cython: language_level=3, boundscheck=False, wraparound=False, cdivision=True, initializedcheck=False
"""Factor of a sparse symmetric quasi-definite matrix in a given order, and its solves.

Not from a library because the time loop factors thousands of small matrices.  The storage of
supernodes and the division of parts among threads are described in ``ldl.h``; this file allocates
the arrays.
"""
from cpython.pycapsule cimport PyCapsule_New
from libc.stdint cimport int32_t, int64_t

import numpy as np


include "../../abi/solver_abi.pxi"

cdef extern from "ldl.h":
    ctypedef struct Factor "ldl":
        ptrdiff_t n, n_super, n_positive
        const int32_t *permutation
        const int32_t *place
        const int64_t *start
        const int32_t *index
        const int32_t *super_of
        const int32_t *first
        const int64_t *row_start
        const int64_t *triangle_start
        const int64_t *block_start
        const int32_t *row
        double *entries
        const int32_t *place_of_entry
        double *triangle
        double *block
        double *diagonal
        int is_single
        double *work
        ptrdiff_t n_parts, root_column, n_root, n_boundary
        const int32_t *part
        const int32_t *boundary
        const int64_t *kept_start
        double *kept
        double *space
        ptrdiff_t space_of_part
        ptrdiff_t *outcome
    const int SLACK "LDL_SLACK"
    const int TAIL "LDL_TAIL"
    ptrdiff_t stride_of "ldl_stride" (ptrdiff_t) noexcept nogil

cdef extern from "ldl_spread.h":
    void find_places "ldl_places" (const Factor *, int32_t *) noexcept nogil

cdef extern from "ldl_factor.h":
    ptrdiff_t space_for "ldl_space" (ptrdiff_t, ptrdiff_t) noexcept nogil
    ptrdiff_t factor "ldl_factor" (void *, const double *) noexcept nogil

cdef extern from "ldl_sweeps.h":
    void solve "ldl_solve" (void *, const double *, double *) noexcept nogil

cdef extern from "ldl_inverse.h":
    void inverse "ldl_inverse" (void *, double *, ptrdiff_t, double *) noexcept nogil

cdef extern from "ldl_single.h":
    void round_to_single "ldl_round" (void *) noexcept nogil


# Number of matrix entries up to which the index of each is stored: 1 MB.
cdef ptrdiff_t FEW_ENTRIES = 250_000


cdef class Ldl:
    """Factor of a symmetric quasi-definite matrix in permuted order.

    Parameters
    ----------
    indptr, indices : (n + 1,) int64 and int32 arrays
        Lower triangle of the matrix by columns.
    permutation : (n,) int32
        ``permutation[k]`` is the unknown eliminated k-th.
    n_positive : int
        The first unknowns must have positive pivots (coordinates), the others negative ones.
    shape : Shape
        Supernodes and parts.
    row : int32 array
        Rows below the supernodes, as ``shape.rows`` returns them; modified in place.
    may_round : bool, optional
        Whether compiled callers may round the factor to single precision.
    """

    cdef ancf_seed interface
    cdef Factor data
    cdef dict arrays
    cdef readonly object capsule

    def __cinit__(self, const int64_t[::1] indptr, const int32_t[::1] indices,
                  const int32_t[::1] permutation, ptrdiff_t n_positive, shape, row,
                  bint may_round=False):
        cdef Factor *data = &self.data
        cdef ptrdiff_t[::1] outcome
        cdef ptrdiff_t n_triangle
        first, super_of, row_start, parts = shape.first, shape.super_of, shape.row_start, shape.part
        n, n_parts = permutation.shape[0], shape.n_parts
        place = np.empty(n, dtype=np.int32)
        place[np.asarray(permutation)] = np.arange(n, dtype=np.int32)
        width, rows = np.diff(first).astype(np.int64), np.diff(row_start)
        triangle_start = np.concatenate([[0], np.cumsum(width * (width - 1) // 2)])
        block_start = np.concatenate([[0], np.cumsum(width * rows)])
        n_super, n_triangle = len(width), np.sum(width * (width - 1) // 2)
        room = max((space_for(w, r) for w, r in set(zip(width.tolist(), rows.tolist()))), default=1)
        root = int(first[parts[n_parts]])
        boundary = images(row, row_start, n, root, parts)
        kept = [width[s] * stride_of(rows[s]) for s in boundary]
        # Some arrays have an extra entry, so that the address of the first one is always valid.
        self.arrays = {
            "indptr": np.asarray(indptr), "indices": np.asarray(indices),
            "permutation": np.asarray(permutation), "place": place, "super_of": super_of,
            "first": first, "row_start": row_start, "triangle_start": triangle_start,
            "block_start": block_start, "row": row,
            "entries": np.zeros(n + n_triangle + block_start[n_super] + TAIL), "part": parts,
            "work": np.zeros(n + n_parts * (n - root)),
            "boundary": np.append(boundary, np.int32(0)),
            "kept_start": np.cumsum([0, *kept], dtype=np.int64), "kept": np.zeros(sum(kept) + SLACK),
            "space": np.zeros(n_parts * room), "outcome": np.zeros(n_parts, dtype=np.intp),
        }
        a = self.arrays
        data.n, data.n_super, data.n_positive = n, n_super, n_positive
        data.permutation, data.place = &permutation[0], ints(place)
        data.start, data.index = &indptr[0], &indices[0]
        data.super_of, data.first, data.row = ints(super_of), ints(first), ints(row)
        data.row_start, data.triangle_start = longs(row_start), longs(triangle_start)
        data.block_start = longs(block_start)
        a["entries"][:n] = 1.0
        data.entries, data.work = reals(a["entries"]), reals(a["work"])
        data.diagonal, data.triangle = data.entries, data.entries + data.n
        data.block = data.triangle + n_triangle
        data.n_parts, data.n_boundary = n_parts, len(boundary)
        data.root_column, data.n_root = root, n - root
        data.part, data.boundary = ints(parts), ints(a["boundary"])
        data.kept_start, data.kept = longs(a["kept_start"]), reals(a["kept"])
        data.space, data.space_of_part = reals(a["space"]), room
        outcome = a["outcome"]
        data.outcome = &outcome[0]
        if indices.shape[0] <= FEW_ENTRIES:
            a["place_of_entry"] = np.empty(indices.shape[0], dtype=np.int32)
            find_places(data, <int32_t *>ints(a["place_of_entry"]))
            data.place_of_entry = ints(a["place_of_entry"])
        self.interface.context, self.interface.n = data, n
        self.interface.factor, self.interface.solve = factor, solve
        if root == n:  # without rows of images
            self.interface.inverse = inverse
        if may_round:
            self.interface.round_to_single = round_to_single
        self.capsule = PyCapsule_New(&self.interface, "ancf_seed", NULL)

    @property
    def nbytes(self):
        """Bytes of all arrays except the sparsity pattern of the matrix, which the caller owns."""
        return sum(array.nbytes for name, array in self.arrays.items()
                   if name not in ("indptr", "indices"))

    @property
    def negative_pivots(self):
        """Number of negative pivots of the last factor; None if one was zero or NaN."""
        if self.data.is_single:
            raise ValueError("the factor is rounded to single precision: factor again")
        inverses = self.arrays["entries"][:self.data.n]
        return int(np.count_nonzero(inverses < 0.0)) if np.isfinite(inverses).all() else None

    def factor(self, const double[::1] values):
        """Factor; return 0, or 1 + the first unknown whose pivot has the wrong sign."""
        return factor(&self.data, &values[0])

    def round_to_single(self):
        """Round the factor to single precision, until the next factorization."""
        round_to_single(&self.data)

    def solve(self, const double[::1] r):
        """Return the solution ``x (n,)`` for the right-hand side ``r (n,)``."""
        x = np.empty(self.data.n)
        cdef double[::1] view = x
        solve(&self.data, &r[0], &view[0])
        return x

    def inverse(self):
        """Return the inverse (n, n) of the matrix, on one thread."""
        if self.interface.inverse == NULL:
            raise ValueError("with several threads, solve for unit vectors")
        columns, space = np.empty((self.data.n, self.data.n)), np.empty(8 * self.data.n)
        cdef double[:, ::1] view = columns
        cdef double[::1] space_view = space
        inverse(&self.data, &view[0, 0], self.data.n, &space_view[0])
        return columns.T

    @property
    def pivots(self):
        """Pivots ``(n,)`` of the last factor, those of the unknowns in their own order."""
        a, n = self.arrays, self.data.n
        out = np.empty(n)
        out[a["permutation"]] = 1.0 / a["entries"][:n]
        return out

    def columns(self):
        """Return ``(column_start, row, lower, pivot, permutation)`` of L by columns, for tests."""
        if self.data.is_single:
            raise ValueError("the factor is rounded to single precision: factor again")
        a = self.arrays
        width, rows = np.diff(a["first"]), np.diff(a["row_start"])
        length = [np.arange(w - 1, -1, -1) + r for w, r in zip(width, rows)]
        start = np.concatenate([[0], np.cumsum(np.concatenate(length))])
        n_lower = start[self.data.n]
        row, lower = np.empty(n_lower, dtype=np.int32), np.empty(n_lower)
        n_triangle = a["triangle_start"][self.data.n_super]
        pivot, triangles, blocks = np.split(a["entries"], [self.data.n, self.data.n + n_triangle])
        for s, (f, end) in enumerate(zip(a["first"][:-1], a["first"][1:])):
            below = a["row"][a["row_start"][s]:a["row_start"][s + 1]]
            image = below - self.data.n
            below = np.where(image < 0, below, self.data.root_column + image % self.data.n_root
                             if self.data.n_root else 0)
            left = np.eye(end - f)
            left[np.tril_indices(end - f, -1)] = (
                triangles[a["triangle_start"][s]:a["triangle_start"][s + 1]])
            block = blocks[a["block_start"][s]:a["block_start"][s + 1]].reshape(-1, end - f) @ left
            for c in range(end - f):
                place = slice(start[f + c], start[f + c + 1])
                row[place] = np.concatenate([np.arange(f + c + 1, end), below])
                lower[place] = np.concatenate([left[c + 1:, c], block[:, c]])
        return start, row, lower, 1.0 / pivot, a["permutation"].copy()


cdef images(int32_t[::1] row, row_start, ptrdiff_t n, ptrdiff_t root, parts):
    """Redirect rows of the root to the image of their part; return supernodes with such rows."""
    boundary = []
    if root == n:
        return np.empty(0, dtype=np.int32)
    rows = np.asarray(row)
    for t, (begin, end) in enumerate(zip(parts[:-2], parts[1:-1])):
        mine = rows[row_start[begin]:row_start[end]]
        in_root = mine >= root
        mine[in_root] += np.int32(n - root + t * (n - root))
        # Rows are sorted, so it suffices to check the last one.
        starts = row_start[begin:end + 1] - row_start[begin]
        filled = np.flatnonzero(np.diff(starts))
        boundary.append(begin + filled[in_root[starts[filled + 1] - 1]])
    return np.concatenate(boundary).astype(np.int32)


cdef const int32_t *ints(array) except NULL:
    cdef const int32_t[::1] view = array
    return &view[0]


cdef const int64_t *longs(array) except NULL:
    cdef const int64_t[::1] view = array
    return &view[0]


cdef double *reals(array) except NULL:
    cdef double[::1] view = array
    return &view[0]
