"""Incomplete factorizations without fill-in, and deflation by sliding modes."""
