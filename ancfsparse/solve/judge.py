"""When a step counts as solved: how far the motion may be off, or forces out of balance."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ancfsparse.integrators import EnergyMomentum, Implicit
from ancfsparse.nonlinear import Method, Newton, QuasiNewton
from ancfsparse.nonlinear.iteration import EPSILON, Tolerance, tolerance_of
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Stiffness over mass of a node, times beta dt^2, from which a body is stiff for the step.  A seed
# that is a little old turns corrections along a stiff bar into some across it, where the bar moves:
# the more the stiffer it is, and always the same way, so that what is left of them does work.  The
# second is for steps whose last residual is evaluated anyway: to judge it takes no other.
STIFF, STIFF_IF_KNOWN = 10.0, 2.0

# Error of the accelerations that a step may leave [m/s2], also of one that must keep energy.
USUAL, KEEPING = 1e-3, 1e-4


class Judge:
    """Bounds on what the iteration of a step leaves.

    Corrections are judged, which saves a residual; or forces, with an integrator that keeps energy
    and where a step is long for a stiff body.  Newton's next error is the square of the last, and
    an inverse that outlives its step corrects once more by the last residual: both leave too little
    to do work that shows, and go on being judged by corrections.

    Parameters
    ----------
    system : System
        What moves.
    integrator : Implicit
        How.
    method : Method
        How steps are solved.
    tolerance : "default", "paper" or float
        As in `simulate`.

    Attributes
    ----------
    force_scale : float
        Size of the terms that cancel in the residual [N].
    """

    def __init__(
        self, system: System, integrator: Implicit, method: Method, tolerance: str | float
    ) -> None:
        self._integrator, self._tolerance = integrator, tolerance
        self._keeps = isinstance(integrator, EnergyMomentum)
        lasting = isinstance(method, QuasiNewton) and (method.memory == "full" or method.carry)
        if isinstance(method, Newton) or lasting:
            self._limit = math.inf
        elif isinstance(method, QuasiNewton) or system.n_multipliers:
            self._limit = STIFF_IF_KNOWN
        else:
            self._limit = STIFF
        self._size = rounding(system) / EPSILON
        diagonal = system.stiffness_diagonal(system.q0)
        self.force_scale = float(np.max(np.abs(diagonal), initial=0.0) * np.max(np.abs(system.q0)))
        self._stiffest = stiffest(system, diagonal)
        places = np.concatenate([p[:, : system.dim].ravel() for p in system.places])
        free = places[places < system.n_free]
        if len(free):
            self._mass = float(np.mean(system.mass_diagonal[free]))
        else:  # where slopes alone can move: what they weigh at the distance of an element
            lengths = np.concatenate([body.lengths for body in system.scene.beams])
            self._mass = float(np.mean(system.mass_diagonal) / np.mean(lengths))

    def at(self, dt: float, error: float | None = None) -> Tolerance:
        """Return the bounds for steps of a length.

        Parameters
        ----------
        dt : float
            Step [s].
        error : float, optional
            Error of the coordinates that a step may leave [m], in the place of the tolerance.
        """
        scale = self._integrator.scale * dt**2
        wish = self._tolerance if error is None else error / scale
        stiff = scale * self._stiffest > self._limit
        return tolerance_of(
            wish,
            scale,
            self.force_scale,
            self._size,
            self._mass if self._keeps or stiff else None,
            KEEPING if self._keeps else USUAL,
        )


def stiffest(system: System, diagonal: Vector) -> float:
    """Return the largest stiffness over mass of the place of a node [1/s2], however it is turned.

    Slopes do not count: the section of a thick beam is far stiffer than the beam, and at rest.
    """
    stiffness, mass = np.zeros((2, system.n_all))
    stiffness[: system.n_free], mass[: system.n_free] = diagonal, system.mass_diagonal
    most = 0.0
    for places in system.places:
        where = places[:, : system.dim]
        k, m = stiffness[where].sum(axis=1), mass[where].sum(axis=1)
        most = max(most, float(np.max(k[m > 0.0] / m[m > 0.0], initial=0.0)))
    return most


def rounding(system: System) -> float:
    """Size of the smallest correction that means anything [m]: constraints sum several squares."""
    return (4.0 if system.n_multipliers else 1.0) * EPSILON * float(np.max(np.abs(system.q0)))
