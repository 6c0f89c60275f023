"""When a step counts as solved: how far the motion may be off, without a scale of its own."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear.iteration import EPSILON, tolerance_of
from ancfsparse.nonlinear.loop_protocols import Tolerance
from ancfsparse.system import System

Vector = NDArray[np.float64]

# What a step may leave, over its first correction: that is beta dt^2 times the change of the
# accelerations, about three times the error of the integrator in the step.
SHARE = 5e-4
# And over the way that the step moves the scene, because it does work along that way: in each step
# at most twice this share of the kinetic energy.  Numerical damping takes what such work puts into
# short waves; without it less must be left, and least by an integrator that keeps energy.
DAMPED, UNDAMPED, KEEPING = 4e-7, 1e-7, 1e-8
# Differences of residuals that are this many times their rounding teach something.
FEW = 10.0
# Energies may be off by so many times their rounding.
MANY = 100.0


class ConvergenceCriterion:
    """Bounds on what the iteration of a step leaves.

    Motions, corrections and residuals are measured by mass, in metres, so that slopes and positions
    can be added up in any units: a correction s as the root of ``s.M s / mass``, a residual as what
    mass alone would make of it.  Along stiff bars that is far more than its correction, and stiff
    forces do work.

    Parameters
    ----------
    system : System
        What moves.
    integrator : Implicit
        How.
    tolerance : "default", "paper" or float
        As in `simulate`.

    Attributes
    ----------
    mass : (n_free,) float
        Diagonal of the mass matrix [kg, kg m2].
    total : float
        Mass of the scene [kg].
    norm : (n,) float
        What squares of corrections are multiplied by and squares of residuals are divided by: the
        mass, and for multipliers, whose residuals are metres, one over the mean mass of a place.
    energy : float
        Size of the terms that cancel in the strain energy [J].
    """

    def __init__(self, system: System, integrator: Implicit, tolerance: str | float) -> None:
        self._integrator, self._tolerance = integrator, tolerance
        self.mass, self.total = system.mass_diagonal, system.mass
        diagonal = np.abs(system.stiffness_diagonal(system.q0))
        q0, n = system.q0, system.n_free
        self.energy = float(np.max(diagonal * q0[:n] ** 2))
        self._stiffest = float(np.max(diagonal))
        self._fastest = float(np.max(diagonal / self.mass))
        self._force_scale = self._stiffest * float(np.max(np.abs(q0)))
        # A force K_ij q_j is at most sqrt(K_ii) sqrt(K_jj) |q_j|, and rounded like it.
        self._forces = math.sqrt(self.energy * float(np.sum(diagonal / self.mass)) / self.total)
        mean = self.total / n
        self.norm = np.concatenate([self.mass, np.full(system.n_multipliers, 1.0 / mean)])
        self._size = math.sqrt(float(self.mass @ q0[:n] ** 2) / self.total)
        places = system.positions
        terms = system.constraints.sizes(q0)  # of constraints, which are rounded like them
        self._largest = float(np.max(np.abs(np.concatenate([q0[places], terms]))))
        self._terms = float(np.linalg.norm(terms)) / math.sqrt(n)
        self._several = 4.0 if system.n_multipliers else 1.0  # constraints sum several squares
        # Work of the loads along the whole size of the scene.
        load, turns = np.abs(system.dead_load), np.abs(q0)
        turns[places] = self._largest
        self._work = float(load @ turns)

    def at(self, dt: float, error: float | None = None) -> Tolerance:
        """Return the bounds for steps of a length.

        Parameters
        ----------
        dt : float
            Step [s].
        error : float, optional
            Error of the coordinates that a step may leave [m], instead of the tolerance.
        """
        scale = self._integrator.scale * dt**2
        keeps = self._integrator.keeps_energy
        work = KEEPING if keeps else UNDAMPED if self._integrator.gamma == 0.5 else DAMPED
        return tolerance_of(
            self._tolerance if error is None else error / scale,
            scale,
            force_scale=self._force_scale,
            place=self._several * EPSILON * self._largest,
            noise=self._several * EPSILON * self._size,
            floor=self._rounding(dt),
            share=SHARE,
            work=work,
            sure=keeps,
        )

    def inertia_leads(self, dt: float) -> bool:
        """Whether mass is the larger part of every diagonal entry of the matrix of a step.

        What a step leaves is then about as large as a force as it is as a correction.
        """
        return self._integrator.scale * dt**2 * self._fastest <= 1.0

    def noise(self, dt: float) -> float:
        """Return the energy that rounding makes [J].

        Places that equations hold are found to a rounding of their size, in steps of that velocity.
        """
        held = MANY * EPSILON * self._largest if self._several > 1.0 else 0.0
        kinetic = self.total * held**2 / (self._integrator.scale * dt**2)
        return MANY * EPSILON * (self.energy + self._work) + kinetic

    def smallest_change(self, dt: float) -> float:
        """Return the difference of two scaled residuals that is only rounding [kg^(1/2) m]."""
        return FEW * self._rounding(dt) * math.sqrt(self.total)

    def _rounding(self, dt: float) -> float:
        """Return the rounding of a scaled residual [m]."""
        scale = self._integrator.scale * dt**2
        return EPSILON * math.hypot(scale * self._forces, self._terms)
