"""Explicit integrators, with steps limited by the fastest vibration."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from ancfsparse.array_types import Vector
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


class Explicit(Integrator, ABC):
    """Explicit integrator, which only solves for accelerations.

    Attributes
    ----------
    takes_velocities : bool
        Whether forces may depend on velocities, as by damping; the tableau has weights for them.
    """

    loop = "explicit"
    takes_velocities: ClassVar[bool] = False

    @property
    @abstractmethod
    def tableau(self) -> Tableau:
        """Coefficients."""

    @property
    def order(self) -> int:
        """Order of accuracy."""
        return self.tableau.order

    @property
    def stages(self) -> Vector:
        """Times of load evaluation after the start of a step, in steps."""
        return self.tableau.c[1:]

    def phase_error(self, z: Vector) -> Vector:
        """Return the relative error of phase or amplitude of vibrations of z radians per step."""
        return self.tableau.phase_error(z)

    @property
    def holds(self) -> bool:
        """True if constraints may have multipliers: velocities at the stages, or no stages."""
        return self.takes_velocities or self.tableau.forces == 1


@dataclass(frozen=True)
class CentralDifference(Explicit):
    """Central differences in velocity Verlet form: explicit, second order, symplectic, reversible.

    One evaluation of the forces per step, no iteration.  The step must be below ``2 / omega``, with
    the highest frequency omega of the mesh, or the run is refused.  With multipliers and rigid
    bodies it is RATTLE, which satisfies the constraints on positions and velocities to rounding
    with one sparse factorization per step.
    """

    @property
    def tableau(self) -> Tableau:
        """Coefficients."""
        return VERLET


@dataclass(frozen=True)
class RungeKuttaNystrom(Explicit):
    """Explicit Runge-Kutta-Nystrom methods of high order, for accurate runs of soft scenes.

    Parameters
    ----------
    order : int, optional
        4 takes three evaluations of the forces per step, 8 takes eight.  At the longest steps the
        error of the tip of the paper's pendulum is 1e-5 m with central differences, 5e-8 m with
        order 4 for 1.6 times the evaluations, and rounding with order 8 for five times as many.
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
    """Explicit Runge-Kutta method of order 8 by Dormand and Prince, twelve forces per step.

    It admits damping, rigid bodies and multipliers.  A few constraints between beams are satisfied
    by accelerations, and by positions and velocities up to the error of the steps.  In all other
    cases each step is projected on the constraints, with twelve sparse factorizations per step.
    The step must be below ``5.96 / omega``, with the highest frequency or decay rate omega of the
    mesh, or the run is refused.
    """

    takes_velocities = True

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
    rounding: float,
    sizes: Vector | None = None,
) -> ExplicitLoop:
    """Build the compiled loop.

    Parameters
    ----------
    system : System
        The system.
    dt : float
        Time step [s].
    integrator : Explicit
        Coefficients.
    q, v : (n_all,) float
        Initial coordinates [m, 1] and velocities; accelerations follow from the forces.
    inputs : (n_inputs,) float
        Initial loads [N, N m] and prescribed motions, see `System.inputs`.
    mass : seed
        Inverse of the mass matrix, or of the matrix with all constraints.
    largest_gain : float
        Largest energy increase, relative to the energy exchanged so far [-].
    noise, rounding : float
        Energy increase by rounding [J], and root of the energy of its errors in a step [J^(1/2)].
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
        rounding,
    )
    return loop
