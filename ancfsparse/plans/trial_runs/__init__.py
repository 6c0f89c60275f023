"""Coarse runs, solution methods without time stepping, operation counts."""
