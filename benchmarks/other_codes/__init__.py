"""Other codes for comparison: Exudyn, SUNDIALS, PyElastica."""
