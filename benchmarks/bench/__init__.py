"""Timed: the paper's pendulum beside Exudyn, and every kernel by instruction set."""
