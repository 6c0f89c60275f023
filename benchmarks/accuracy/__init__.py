"""Error against cost on the paper's pendulum: in time, in total, and by its parts."""
