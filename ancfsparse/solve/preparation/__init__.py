"""Choice of solver, factorization, memory and threads before a run."""
