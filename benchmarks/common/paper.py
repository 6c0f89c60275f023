"""Table 1 of the paper, and the methods that take the place of its columns.

Source: *On the Numerical Treatment of Nonlinear Flexible Multibody Systems with the Use of
Quasi-Newton Methods*, section 4, Table 1: computation times in seconds, MATLAB, for two seconds
of the flexible pendulum with ten elements.
"""

from __future__ import annotations

T_END = 2.0
"""Simulated time [s]."""

DT = 5e-4
"""Time step of the Newmark method [s]."""

ELEMENTS = 10
"""Elements of the pendulum."""

RTOL, ATOL = 1e-3, 1e-6  # relative, absolute
"""Tolerances of the ode functions, MATLAB's default."""

ODE_FUNCTIONS = {"RK23": "ode23", "LSODA": "ode113", "Radau": "ode23t"}
"""SciPy's method by column, and the MATLAB function it stands for."""

QUASI_NEWTON = {"Broyden": "broyden", "Davidon": "davidon", "DFP": "dfp", "BFGS": "bfgs"}
"""Update by column; the paper writes DPF for DFP."""

SECONDS: dict[str, dict[str, float]] = {
    "L2T2": {
        "RK23": 5.3, "LSODA": 9.4, "Radau": 10.1,
        "Broyden": 3.69, "Davidon": 1.69, "DFP": 3.06, "BFGS": 2.96,
    },
    "Thin": {
        "RK23": 7.1, "LSODA": 11.9, "Radau": 11.5,
        "Broyden": 7.22, "Davidon": 2.96, "DFP": 6.32, "BFGS": 6.14,
    },
    "Thick": {
        "RK23": 311.0, "LSODA": 221.3, "Radau": 375.6,
        "Broyden": 19.20, "Davidon": 10.49, "DFP": 20.24, "BFGS": 27.61,
    },
}  # fmt: skip
"""The paper's seconds by row and by our column."""
