"""The paper's table 1 and figures 1 and 2, and the speed on its pendulum."""
