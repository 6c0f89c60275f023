"""Complete factorizations L D L^T by supernodes."""
