"""Fill-reducing orderings of the unknowns."""
