"""Plans relative to the best choice of a search: errors, tolerances and cost."""
