"""Tools of all studies: timing, tables, charts, pages, integrators and solvers by name."""
