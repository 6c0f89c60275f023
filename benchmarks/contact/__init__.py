"""Contact and friction against formulas."""
