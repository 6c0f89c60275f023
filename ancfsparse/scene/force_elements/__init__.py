"""Springs, ropes, masses, user forces, joint springs and contacts: methods of `Scene`."""
