"""Modes, complex modes, modal superposition, buckling."""
