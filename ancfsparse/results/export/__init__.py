"""Output files: CSV tables, VTKHDF, HDF5."""
