"""Contact of beams with each other and with themselves."""
