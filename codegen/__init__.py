"""From an energy written in SymPy to the kernels in `generated/`.

An element states its coordinates, its interpolation and its energy (`elements/`, in the words of
`fields`).  `modes` and `strains` turn fields and strains into nodes of a straight-line program
(`tape`), `derive` makes energy, force, inertia, residual, tangent and mass of them, `emit` prints
these as Cython, and `stamp` says from which sources they came.  Nothing here imports `ancfsparse`.
"""
