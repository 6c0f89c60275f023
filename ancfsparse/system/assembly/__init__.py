"""Sparsity pattern, compiled assembly, partition."""
