"""Solutions as returned to the user: trajectory, equilibrium, modes and their like."""
