"""Explicit integrators: no equations to solve, steps bounded by the fastest vibration."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.integrators.explicit.nystrom_tableaus import (
    EIGHTH,
    FOURTH,
    VERLET,
    Tableau,
    dormand_prince,
)
from ancfsparse.integrators.implicit.time_integration import Mechanics
from ancfsparse.integrators.interface.integrator import Integrator
from ancfsparse.messages import format_value

if TYPE_CHECKING:
    from ancfsparse.integrators.interface.time_loops import ExplicitLoop

Vector = NDArray[np.float64]


class Explicit(Integrator, ABC):
    """A method that solves no equations but for accelerations."""

    loop = "explicit"

    @property
    @abstractmethod
    def tableau(self) -> Tableau:
        """Coefficients."""

    @property
    def order(self) -> int:
        """Power of the step in the error."""
        return self.tableau.order

    @property
    def stages(self) -> Vector:
        """Times in a step at which loads are evaluated, over the step, after its start."""
        return self.tableau.c[1:]

    @property
    def takes_velocities(self) -> bool:
        """Whether forces may depend on velocities, so that there may be damping."""
        return self.tableau.B is not None

    @property
    def holds(self) -> bool:
        """Whether there may be multipliers: with velocities of the stages, or without stages."""
        return self.takes_velocities or self.tableau.forces == 1


@dataclass(frozen=True)
class CentralDifference(Explicit):
    """Central differences in velocity Verlet form: explicit, second order, symplectic, reversible.

    One evaluation of the forces per step, no iteration.  The step must stay below ``2 / omega``
    with the fastest vibration omega of the mesh, or the run is refused.  With constraints by
    multipliers and rigid bodies it is RATTLE, which keeps positions and velocities on them to
    rounding for one sparse factor per step.
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
                f"RungeKuttaNystrom has order 4 or 8, got {format_value(self.order)}: for order 2 "
                "take CentralDifference()"
            )

    @property
    def tableau(self) -> Tableau:
        """Coefficients."""
        return FOURTH if self.order == 4 else EIGHTH


@dataclass(frozen=True)
class DormandPrince(Explicit):
    """The explicit Runge-Kutta method of order 8 by Dormand and Prince, twelve forces per step.

    It takes damping, rigid bodies and constraints by multipliers.  Of a few constraints between
    beams it holds the accelerations: positions and velocities leave them by what the steps are off.
    Otherwise each step is projected on them, for twelve sparse factors per step.  Its step must
    stay below ``5.96 / omega`` with the fastest vibration or decay omega of the mesh, or the run is
    refused.
    """

    @property
    def tableau(self) -> Tableau:
        """Coefficients."""
        return dormand_prince()


def make_explicit(
    system: Mechanics,
    dt: float,
    integrator: Explicit,
    q: Vector,
    v: Vector,
    inputs: Vector,
    mass: Any,
    largest_gain: float,
    noise: float,
    sizes: Vector | None = None,
) -> ExplicitLoop:
    """Build the compiled loop.

    Parameters
    ----------
    system : System
        What moves.
    dt : float
        Time step [s].
    integrator : Explicit
        Coefficients.
    q, v : (n_all,) float
        The first state [m, 1] and its velocities; its accelerations are those of its forces.
    inputs : (n_inputs,) float
        What changes with time there: loads [N, N m], and what is prescribed, see `System.inputs`.
    mass : seed
        Inverse of the mass matrix, or of the matrix with all constraints.
    largest_gain : float
        Share of the energy exchanged so far by which the energy may exceed what was given.
    noise : float
        Energy that rounding makes [J].
    sizes : (m,) float, optional
        Magnitude of the terms of each constraint [m], if the seed includes the constraints.
    """
    method = integrator.tableau
    loop: ExplicitLoop = compiled_module(integrator.loop).Explicit(
        system,
        mass,
        dt,
        method.A,
        method.b,
        method.c,
        method.B,
        system.constraints,
        system.parts,
        sizes,
        q,
        v,
        system.dead_load,
        inputs,
        system.prescribed.n,
        system.prescribed.n_equations,
        largest_gain,
        noise,
    )
    return loop
