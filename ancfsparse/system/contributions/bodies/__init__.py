"""Elements, masses, rotating frame, gravity."""
