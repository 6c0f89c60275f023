"""Mechanisms of cables beside Exudyn."""
