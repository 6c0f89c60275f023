"""Which runs complete, over step, stiffness, integrator and solver."""
