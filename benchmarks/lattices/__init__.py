"""Exact and incomplete seeds on lattices and nets, by size."""
