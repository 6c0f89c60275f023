"""From an energy written in SymPy to the kernels in `generated/`.

An element defines its coordinates, its interpolation and its energy (`elements/`, in terms of
`fields`).  `modes` and `strains` convert fields and strains to nodes of a straight-line program
(`tape`), `derive` computes energy, force, inertia, residual, tangent and mass from them, `emit`
prints these as Cython, and `stamp` records their sources.  Nothing here imports `ancfsparse`.
"""
