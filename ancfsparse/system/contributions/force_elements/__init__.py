"""Springs, joint springs, ropes."""
