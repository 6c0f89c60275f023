"""Springs, ropes, masses, user forces and joint springs, with their methods of `Scene`."""
