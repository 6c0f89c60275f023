"""Contact of beams with obstacles and with each other."""
