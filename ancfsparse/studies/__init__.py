"""Studies of the paper's pendulum: each returns data, writes files and draws charts."""
