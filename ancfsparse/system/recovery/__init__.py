"""Reactions and end forces from a solution."""
