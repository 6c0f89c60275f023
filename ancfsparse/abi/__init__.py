"""C structures by which compiled parts call each other, outcomes, and shared helpers."""
