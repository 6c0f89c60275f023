"""Linear forms, joint coordinates, sliding curves."""
