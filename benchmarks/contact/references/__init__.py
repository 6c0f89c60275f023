"""Groups of values of contact and friction next to their references."""
