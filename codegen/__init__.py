"""From an energy written in SymPy to the kernels in `generated/`.

An element states its coordinates, its interpolation and its energy (`elements/`).  `derive` turns that
into straight-line programs for energy, force, inertia, residual, tangent and mass (`tape`), `emit` prints them
as Cython, and `stamp` says from which sources they came.  Nothing here imports `ancfsparse`.
"""
