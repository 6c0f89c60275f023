"""Explicit integrators: no equations to solve, steps bounded by the fastest vibration."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np

from ancfsparse.checks import shown
from ancfsparse.dispatch import compiled
from ancfsparse.errors import InputError
from ancfsparse.integrators.march import Mechanics, Start
from ancfsparse.integrators.nystrom import EIGHTH, FOURTH, VERLET, Tableau


class Explicit(ABC):
    """A method for forces that depend on positions and time alone."""

    @property
    @abstractmethod
    def tableau(self) -> Tableau:
        """Coefficients."""


@dataclass(frozen=True)
class CentralDifference(Explicit):
    """Central differences in velocity Verlet form: explicit, second order, symplectic, reversible.

    One evaluation of the forces per step, no iteration.  The step must stay below ``2 / omega``
    with the fastest vibration omega of the mesh, or the run is refused.
    """

    @property
    def tableau(self) -> Tableau:
        """Coefficients."""
        return VERLET


@dataclass(frozen=True)
class RungeKuttaNystrom(Explicit):
    """Explicit methods of high order: for tight accuracy where nothing is stiff.

    Parameters
    ----------
    order : int, optional
        4 takes three evaluations of the forces per step, 8 takes eight.  At their longest steps the
        tip of the paper's pendulum is off by 1e-5 m with central differences, by 5e-8 m with order
        4 for 1.6 times the forces, and by rounding with order 8 for five times the forces.
    """

    order: int = 4

    def __post_init__(self) -> None:
        """Check the order."""
        if not isinstance(self.order, int | np.integer) or self.order not in (4, 8):
            raise InputError(
                f"RungeKuttaNystrom has order 4 or 8, got {shown(self.order)}: for order 2 take "
                "CentralDifference()"
            )

    @property
    def tableau(self) -> Tableau:
        """Coefficients."""
        return FOURTH if self.order == 4 else EIGHTH


def make_explicit(
    system: Mechanics,
    dt: float,
    integrator: Explicit,
    start: Start,
    mass: Any,
    largest_gain: float,
    noise: float,
) -> Any:
    """Build the compiled loop.

    Parameters
    ----------
    system : System
        What moves, without multipliers.
    dt : float
        Time step [s].
    integrator : Explicit
        Coefficients.
    start : Start
        The first state.
    mass : seed
        Inverse of the mass matrix.
    largest_gain : float
        Share of the energy exchanged so far by which the energy may exceed what was given.
    noise : float
        Energy that rounding makes [J].
    """
    method = integrator.tableau
    return compiled("explicit").Explicit(
        system,
        mass,
        dt,
        method.A,
        method.b,
        method.c,
        start.q,
        start.v,
        start.a,
        system.dead_load,
        start.amplitudes,
        largest_gain,
        noise,
    )
