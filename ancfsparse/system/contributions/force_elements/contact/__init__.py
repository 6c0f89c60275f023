"""Contact of beams with obstacles."""
