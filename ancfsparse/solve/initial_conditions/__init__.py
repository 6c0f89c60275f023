"""Consistent positions, velocities, accelerations, multipliers; restart."""
