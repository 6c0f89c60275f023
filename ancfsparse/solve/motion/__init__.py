"""`simulate`: its arguments and the three kinds of runs."""
