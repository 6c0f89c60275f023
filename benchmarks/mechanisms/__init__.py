"""Mechanisms of cables by this package and by Exudyn."""
