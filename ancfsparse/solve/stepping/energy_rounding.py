"""Estimate the energy that rounding adds to a motion: a gain that the energy watch allows."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.system import System

# With 10, `Newmark(0)` stops a run of a rigid body that joints hold.
ROUNDING_UNITS = 100.0  # error of works and of constrained positions in units of rounding


class EnergyRounding(NamedTuple):
    """Estimated energy that rounding adds to a motion."""

    total: float  # however many steps are taken [J]
    step: float  # root of the mean energy of the errors in a step [J^(1/2)]


def estimate_energy_rounding(system: System, stiffness: Vector, dt: float) -> EnergyRounding:
    """Estimate the energy that rounding adds to a motion.

    Errors eps q of the coordinates in a step have an energy of ``1/2 sum K_ii (eps q_i)^2`` in the
    mean over their signs, and the roots of the energies of all steps are added.  In 592 runs of
    2000 steps at rest, the root of the energy of the errors after 16 steps or more was at most 0.05
    of this sum with implicit methods, 0.13 with central differences and Runge-Kutta-Nystrom
    methods, and 1.2 with `DormandPrince`.

    Positions under constraints are rounded relative to their size too, by d, which changes
    velocities by 2 d / dt.  The next step corrects that, so these errors do not add up.

    Parameters
    ----------
    system : System
        At its initial state ``q0``.
    stiffness : (n_free,) float
        Diagonal of its stiffness [N/m, N m].
    dt : float
        Step [s].
    """
    q0, largest = system.q0, system.largest_length()
    sizes = np.abs(q0)
    sizes[system.positions] = largest
    work = float(np.abs(system.dead_load) @ sizes)
    speed = 2.0 * ROUNDING_UNITS * EPSILON * largest / dt if system.n_multipliers else 0.0
    total = ROUNDING_UNITS * EPSILON * work + 0.5 * system.mass * speed**2
    energy = 0.5 * float(np.abs(stiffness) @ (EPSILON * q0[: system.n_free]) ** 2)
    return EnergyRounding(total, math.sqrt(energy))
