"""How the compiled parts call each other: C structures, outcomes, and what all of them share."""
