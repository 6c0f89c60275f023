"""Equilibrium: residual, Newton iteration, load stepping."""
