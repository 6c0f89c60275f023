"""Predicted errors and costs of a run: discontinuities, modal phase errors, stagnation."""
