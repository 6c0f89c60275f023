"""Springs, joint springs, ropes, contacts."""
