"""Properties of integrators, protocols of the compiled time loops, grids of output times."""
