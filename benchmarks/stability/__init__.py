"""Outcome of runs over time step, stiffness, integrator and solver, and of a million steps."""
