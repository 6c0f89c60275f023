"""Arc-length continuation, load paths, quasi-static motion."""
