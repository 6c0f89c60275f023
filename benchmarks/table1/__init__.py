"""Table 1 and figures 1 and 2 of the paper, beside the paper's own numbers."""
