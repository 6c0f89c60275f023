"""The plan as data, its run, its verification, and planning again."""
