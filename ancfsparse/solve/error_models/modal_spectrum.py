"""Predict the error of an integrator from the vibrations of a motion.

At its start, and at jumps of the loads, a scene that is linearized about its shape begins to
vibrate in its modes, each with a known amplitude.  An integrator has a known error of phase and
amplitude for each, per step.  That is most of the error of a motion, also with large rotations: up
to a factor of five in nine of ten random scenes.  Waves excited nonlinearly by other modes, such as
axial waves caused by transverse motion, are not included: so a predicted error serves to plan runs,
and never as the estimate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.integrators.interface.integrator import Integrator
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.linearization.matrices import (
    free_submatrix,
    mass_matrix,
    symmetric_from_lower,
)
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.system import System

# Free coordinates up to which dense matrices give all modes: 300 take 0.1 s.
MAX_COORDINATES = 300
# Of the time of a run: with its middle alone, runs take 0.3 % more work.
SAMPLE_FRACTIONS = (0.25, 0.75)
ROUNDING = 1e-12  # of amplitudes, over the size of the scene
REST_RATIO = 1e-7  # frequency of a rigid motion over the highest one: rounding
MAX_LATER_RATIO = 10.0  # changes of the loads over the start and jumps, if neglected
# Without it, one run in 300 took 23 times the work.
MIN_SCALE = 0.3  # error of a run, or difference from a finer one, over the predicted error

Scheme = tuple[Integrator, float]
"""An integrator and its step [s]."""


@dataclass(frozen=True)
class ModalSpectrum:
    """Vibrations of a motion, or the one that represents the difference of two runs.

    Attributes
    ----------
    amplitude : (k,) float
        Largest displacement of a node in each [m].
    omega : (k,) float
        Angular frequencies [rad/s].
    time : (k,) float
        Duration of each, to the end or until it is damped out [s].
    """

    amplitude: Vector
    omega: Vector
    time: Vector

    @classmethod
    def of(
        cls, system: System, discontinuities: LoadDiscontinuities, t_end: float
    ) -> ModalSpectrum | None:
        """Find the vibrations of a scene; None if they are too many, or their cause is unknown.

        Parameters
        ----------
        system : System
            At its initial state.
        discontinuities : LoadDiscontinuities
            Discontinuities of the loads.
        t_end : float
            End of the motion [s].
        """
        n = system.n_free
        is_known = all(term.is_explicit_in_time for term in system.contributions)
        # The mass matrix of a flat rigid body alone is singular.
        rigid = any(system.constraints.mass)
        if not 0 < n <= MAX_COORDINATES or system.prescribed or not is_known or rigid:
            return None
        first = system.loads.amplitudes(np.array([system.t0]))[0]
        zero = np.zeros(system.n_multipliers)
        omega, shapes, mass, decay = _modal_analysis(system, system.q0, zero, first)
        speeds = shapes.T @ (mass @ system.v0[:n])
        causes = [(system.t0, speeds, -shapes.T @ _force(system, system.v0, first))]
        for low, high in zip(discontinuities.before, discontinuities.after, strict=True):
            before, after = (system.loads.amplitudes(np.array([t]))[0] for t in (low, high))
            zero_velocity = np.zeros(system.n_all)
            jump = _force(system, zero_velocity, after) - _force(system, zero_velocity, before)
            causes.append((high, np.zeros_like(speeds), -shapes.T @ jump))
        if _is_driven_later(system, discontinuities, shapes, causes, omega):
            return None
        vibrates, duration = _decay_times(omega, decay)
        amplitudes, times = [], []
        for begin, speed, rate in causes:
            amplitudes.append(_amplitudes(system, shapes, omega, speed, rate)[vibrates])
            times.append(np.minimum(t_end - begin, duration[vibrates]))
        omega = omega[vibrates]
        amplitude, time = np.concatenate(amplitudes), np.concatenate(times)
        if amplitude.sum() <= ROUNDING * np.max(np.abs(system.q0)):
            return None
        return cls(amplitude, np.tile(omega, len(causes)), time)

    @classmethod
    def during(cls, system: System, states: SampledStates) -> ModalSpectrum | None:
        """Find the vibrations of a run, including those excited by other modes.

        Amplitudes are means over some times, at each of which the scene is linearized.

        Parameters
        ----------
        system : System
            The moving system.
        states : SampledStates
            States of the run.

        Returns
        -------
        ModalSpectrum or None
            None if there are too many vibrations, or none.
        """
        n, length = system.n_free, float(states.t[-1] - states.t[0])
        if not 0 < n <= MAX_COORDINATES or any(system.constraints.mass):
            return None
        parts: list[tuple[Vector, Vector, Vector]] = []
        for fraction in SAMPLE_FRACTIONS:
            k = round(fraction * (len(states.t) - 1))
            load = system.loads.amplitudes(states.t[k : k + 1])[0]
            lam = np.asarray(states.lam[k])
            omega, shapes, mass, decay = _modal_analysis(system, states.q[k], lam, load)
            speed, rate = (shapes.T @ (mass @ x[k, :n]) for x in (states.v, states.a))
            vibrates, duration = _decay_times(omega, decay)
            size = _amplitudes(system, shapes, omega, speed, rate)[vibrates] / len(SAMPLE_FRACTIONS)
            parts.append((size, omega[vibrates], np.minimum(length, duration[vibrates])))
        amplitude, omega, time = map(np.concatenate, zip(*parts, strict=True))
        return cls(amplitude, omega, time) if amplitude.any() else None

    @classmethod
    def of_difference(
        cls, difference: float, omega: float, time: float, coarse: Scheme, fine: Scheme
    ) -> ModalSpectrum:
        """Return the vibration of a frequency that makes two runs differ [m]."""
        unit = cls(np.ones(1), np.array([omega]), np.array([time]))
        ratio = max(unit.difference(coarse, fine), 0.5 * unit.error(coarse))
        amplitude = difference / ratio if ratio > 0.0 else np.inf
        return cls(np.array([amplitude]), unit.omega, unit.time)

    def phase_errors(self, run: Scheme) -> Vector:
        """Return the phase error of each at its end [rad]."""
        integrator, h = run
        return integrator.phase_error(self.omega * h) * self.omega * self.time

    def error(self, run: Scheme) -> float:
        """Return the error of a run [m]."""
        return float(self.amplitude @ np.minimum(1.0, self.phase_errors(run)))

    def difference(self, coarse: Scheme, fine: Scheme) -> float:
        """Return the difference of two runs [m]."""
        one, other = (np.minimum(1.0, self.phase_errors(run)) for run in (coarse, fine))
        return float(self.amplitude @ np.abs(one - other))

    def common_error(self, coarse: Scheme, fine: Scheme) -> float:
        """Return the error that two runs have in common, which their difference does not show [m].

        Explicit methods of high order dissipate the fastest vibrations: both runs may have lost
        them.
        """
        one, other = (np.minimum(1.0, self.phase_errors(run)) for run in (coarse, fine))
        return float(self.amplitude @ (one * other))

    def extrapolated_error(self, coarse: Scheme, fine: Scheme) -> float:
        """Return the error of two runs after Richardson extrapolation of second order [m]."""
        weight = 1.0 / ((coarse[1] / fine[1]) ** 2 - 1.0)
        one, other = (self.phase_errors(run) for run in (coarse, fine))
        error = np.abs(
            (1.0 + weight) * (np.exp(1j * other) - 1.0) - weight * (np.exp(1j * one) - 1.0)
        )
        # Beyond a radian the errors of two runs need not cancel.
        bound = (1.0 + weight) * np.minimum(other, 2.0) + weight * np.minimum(one, 2.0)
        return float(self.amplitude @ np.where(one < 1.0, error, bound))

    def scale(self, difference: float, coarse: Scheme, fine: Scheme) -> float:
        """Return the difference of two runs over the predicted one."""
        predicted = max(self.difference(coarse, fine), MIN_SCALE * self.error(coarse))
        return difference / max(predicted, np.finfo(float).tiny)


def _decay_times(omega: Vector, decay: Vector) -> tuple[NDArray[np.bool_], Vector]:
    """Return the modes that vibrate, and the times of their decay [s]."""
    vibrates = (omega > REST_RATIO * omega.max(initial=0.0)) & (decay < 2.0 * omega)
    duration = np.full_like(omega, np.inf)
    np.divide(2.0, decay, out=duration, where=decay > 0.0)
    return vibrates, duration


def _amplitudes(
    system: System, shapes: Vector, omega: Vector, speed: Vector, rate: Vector
) -> Vector:
    """Return the largest displacement of a node in each vibrating mode [m]."""
    nodes = np.unique(system.positions)
    size = np.abs(shapes[nodes[nodes < system.n_free]]).max(axis=0, initial=0.0)
    slowest = np.maximum(omega, np.finfo(float).tiny ** 0.25)
    return np.asarray(size * np.hypot(speed / slowest, rate / slowest**2))


def _modal_analysis(
    system: System, q: Vector, lam: Vector, amplitudes: Vector
) -> tuple[Vector, Vector, Vector, Vector]:
    """Return frequencies, shapes of unit modal mass, the mass matrix, and decay rates."""
    import scipy.linalg

    mass = dense_symmetric(mass_matrix(system))
    stiffness, basis = tangent_stiffness(system, q, lam, amplitudes)
    squares, shapes = scipy.linalg.eigh(basis.T @ stiffness @ basis, basis.T @ mass @ basis)
    shapes = basis @ shapes
    decay = np.zeros(len(squares))
    if system.damped:
        values = system.assembly.matrix(0.0, 0.0, q, lam, amplitudes, damping_factor=1.0)
        damping = dense_symmetric(free_submatrix(system, values))
        decay = np.einsum("ik,ij,jk->k", shapes, damping, shapes)
    return np.sqrt(np.maximum(squares, 0.0)), shapes, mass, decay


def tangent_stiffness(
    system: System, q: Vector, lam: Vector, amplitudes: Vector
) -> tuple[Vector, Vector]:
    """Return the stiffness at a state, and a basis of admissible motions, both dense.

    Parameters
    ----------
    system : System
        The system.
    q : (n_all,) float
        Coordinates.
    lam : (m,) float
        Multipliers.
    amplitudes : (n_amplitudes,) float
        Amplitudes of the loads.
    """
    import scipy.linalg

    n = system.n_free
    values = system.assembly.matrix(0.0, 1.0, q, lam, amplitudes)
    basis = np.eye(n)
    if system.n_multipliers:
        basis = scipy.linalg.null_space(system.constraints.jacobian(q)[:, :n].toarray())
    return dense_symmetric(free_submatrix(system, values)), basis


def dense_symmetric(lower: Any) -> Vector:
    """Return a symmetric matrix from its sparse lower part."""
    return np.asarray(symmetric_from_lower(lower).toarray())


def _is_driven_later(
    system: System,
    discontinuities: LoadDiscontinuities,
    shapes: Vector,
    causes: list[tuple[float, Vector, Vector]],
    omega: Vector,
) -> bool:
    """Return whether continuous changes of the loads exceed the start and all jumps."""
    amplitudes, zero_velocity = discontinuities.amplitudes, np.zeros(system.n_all)
    first = amplitudes[0]
    known = sum(np.hypot(omega * speed, rate) for _, speed, rate in causes)
    later = np.zeros_like(omega)
    for column in range(len(first)):
        change = amplitudes[:, column] - first[column]
        largest = first.copy()
        largest[column] += change[np.argmax(np.abs(change))]
        later += np.abs(
            shapes.T
            @ (_force(system, zero_velocity, largest) - _force(system, zero_velocity, first))
        )
    return bool(np.linalg.norm(later) > MAX_LATER_RATIO * np.linalg.norm(known))


def _force(system: System, v: Vector, amplitudes: Vector) -> Vector:
    """Return the forces at the initial shape that balance M a, (n_free,) [N, N m]."""
    zero, lam = np.zeros(system.n_all), np.zeros(system.n_multipliers)
    r, _ = system.assembly.residual(system.q0, v, zero, lam, system.dead_load, amplitudes)
    return np.asarray(r[: system.n_free])
