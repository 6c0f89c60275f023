"""Newmark's family and the energy-momentum method, with their compiled time loops."""
