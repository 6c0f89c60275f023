"""Convergence criterion of a step: bounds relative to the motion, without an absolute scale."""

from __future__ import annotations

import math

import numpy as np

from ancfsparse.integrators import Implicit
from ancfsparse.nonlinear.iteration import EPSILON, make_tolerance
from ancfsparse.nonlinear.loop_protocols import Tolerance
from ancfsparse.solve.initial_conditions.consistent_accelerations import range_error
from ancfsparse.system import System

# The first correction of a step is beta dt^2 times the change of the accelerations, about three
# times the error of the integrator in the step.
CORRECTION_RATIO = 5e-4  # remaining error over the first correction
# The remaining residual does work along the displacement in a step, at most twice this ratio of the
# kinetic energy.  Numerical damping dissipates it in short waves; without it the bound is lower,
# and lowest for an integrator that conserves energy.
DAMPED_WORK_RATIO = 4e-7  # remaining error over the displacement in the step
UNDAMPED_WORK_RATIO = 1e-7  # the same without numerical damping
CONSERVING_WORK_RATIO = 1e-8  # the same for energy-conserving integrators
MIN_CHANGE_UNITS = 10.0  # difference of residuals over their rounding, for a secant pair


class ConvergenceCriterion:
    """Bounds on the remaining error of the iteration of a step.

    Motions, corrections and residuals are weighted by mass, in metres, so that slopes and positions
    add up in any units: a correction s as the root of ``s.M s / mass``, a residual as the
    displacement it would cause against mass alone.  Along stiff bars that is far more than the
    correction, and stiff forces do work.

    Parameters
    ----------
    system : System
        The moving system.
    integrator : Implicit
        The integrator.
    tolerance : "default", "paper" or float
        As in `simulate`.

    Raises
    ------
    InputError
        If a frequency leaves the range of floating-point numbers.

    Attributes
    ----------
    mass : (n_free,) float
        Diagonal of the mass matrix [kg, kg m2].
    total : float
        Mass of the scene [kg].
    norm : (n,) float
        Weights of squared corrections, by which squared residuals are divided: the mass, and for
        multipliers, whose residuals are lengths, one over the mean mass of a coordinate.
    stiffness : (n_free,) float
        Diagonal of the stiffness at the start, as magnitudes [N/m, N m].
    """

    def __init__(self, system: System, integrator: Implicit, tolerance: str | float) -> None:
        self._integrator, self._tolerance = integrator, tolerance
        self.mass, self.total = system.mass_diagonal, system.mass
        self.stiffness = diagonal = np.abs(system.stiffness_diagonal(system.q0))
        q0, n = system.q0, system.n_free
        energy = float(np.max(diagonal * q0[:n] ** 2))
        self._stiffest = float(np.max(diagonal))
        with np.errstate(over="ignore"):
            frequencies = diagonal / self.mass  # squared [1/s2]
        self._fastest = float(np.max(frequencies))
        if not math.isfinite(self._fastest):
            i = int(np.argmax(frequencies))
            raise range_error(
                f"{system.describe(i)} has a stiffness of {diagonal[i]:.3g} and a mass of "
                f"{self.mass[i]:.3g} in SI units"
            )
        self._force_scale = self._stiffest * float(np.max(np.abs(q0)))
        # A force K_ij q_j is at most sqrt(K_ii) sqrt(K_jj) |q_j|, with rounding relative to it.
        self._forces = math.sqrt(energy * float(np.sum(frequencies)) / self.total)
        mean = self.total / n
        self.norm = np.concatenate([self.mass, np.full(system.n_multipliers, 1.0 / mean)])
        self._size = math.sqrt(float(self.mass @ q0[:n] ** 2) / self.total)
        self._largest = system.largest_length()
        self._terms = float(np.linalg.norm(system.constraints.sizes(q0))) / math.sqrt(n)
        self._several = 4.0 if system.n_multipliers else 1.0  # constraints sum several squares

    def at(self, dt: float, error: float | None = None) -> Tolerance:
        """Return the bounds for a step size.

        Parameters
        ----------
        dt : float
            Step [s].
        error : float, optional
            Allowed error of the coordinates [m] in place of the tolerance.
        """
        scale = self._integrator.scale * dt**2
        keeps = self._integrator.keeps_energy
        work = (
            CONSERVING_WORK_RATIO
            if keeps
            else UNDAMPED_WORK_RATIO
            if self._integrator.gamma == 0.5
            else DAMPED_WORK_RATIO
        )
        return make_tolerance(
            self._tolerance if error is None else error / scale,
            scale,
            force_scale=self._force_scale,
            rounding=self._several * EPSILON * self._largest,
            noise=self._several * EPSILON * self._size,
            floor=self._rounding(dt),
            share=CORRECTION_RATIO,
            work=work,
            sure=keeps,
        )

    def inertia_leads(self, dt: float) -> bool:
        """Return whether mass dominates every diagonal entry of the matrix of a step.

        The remaining error is then about as large as a force as it is as a correction.
        """
        return self._integrator.scale * dt**2 * self._fastest <= 1.0

    def smallest_change(self, dt: float) -> float:
        """Return the difference of two scaled residuals that is rounding [kg^(1/2) m]."""
        return MIN_CHANGE_UNITS * self._rounding(dt) * math.sqrt(self.total)

    def _rounding(self, dt: float) -> float:
        """Return the rounding of a scaled residual [m]."""
        scale = self._integrator.scale * dt**2
        return EPSILON * math.hypot(scale * self._forces, self._terms)
