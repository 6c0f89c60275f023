"""Other programs on the same scenes: Exudyn, SUNDIALS, PyElastica."""
