"""Element and mesh of every beam; planar reduction; prolongation."""
