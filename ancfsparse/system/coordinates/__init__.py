"""Numbering, lowering of joints, constraints, state."""
