"""The protocol of a solved system, stored tables, HDF5 files and their locks."""
