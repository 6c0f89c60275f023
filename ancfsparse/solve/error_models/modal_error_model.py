"""The error of an integrator, predicted from the vibrations that a motion is made of.

At its start, and where loads jump, a scene that is linearized about its shape begins to move in its
vibrations, each of a known amplitude.  An integrator loses a known share of the phase and size of
each, step by step.  That is most of the error of a motion, also of one with large turns: all of it
but for a factor of five in nine of ten random scenes.  What is missing are waves that others set
off, as those along a beam that starts to move across itself: so a predicted error serves to plan
runs, and never as the estimate.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

from ancfsparse.integrators.explicit.nystrom_tableaus import Tableau
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.solve.error_models.phase_error import phase_lost
from ancfsparse.solve.linearization.matrices import (
    free_submatrix,
    mass_matrix,
    symmetric_from_lower,
)
from ancfsparse.solve.stepping.sampled_states import SampledStates
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Free coordinates up to which all vibrations are found: some milliseconds, and dense matrices.
MOST = 300
# The same where a run is analysed; and shares of its time at which it is.
MOST_DURING, SAMPLES = 150, (0.25, 0.75)
# What moves as a whole has no frequency, but for rounding: over the highest one.
AT_REST = 1e-7
ROUNDING = 1e-12  # of amplitudes, over the size of the scene
# Loads that change by more than so many times what starts and jumps hold leave the rest unknown.
LATER = 10.0
# Points of a table of the phase lost, and where it begins, over the order: below, it is a power.
POINTS, BEGIN = 300, 0.05


@dataclass(frozen=True)
class ModalSpectrum:
    """Vibrations that the start and the jumps of loads set off.

    Attributes
    ----------
    amplitude : (k,) float
        Largest motion of a node in each [m].
    omega : (k,) float
        Angular frequencies [rad/s].
    time : (k,) float
        How long each lasts, to the end or until it is damped out [s].
    """

    amplitude: Vector
    omega: Vector
    time: Vector

    @classmethod
    def of(cls, system: System, breaks: LoadDiscontinuities, t_end: float) -> ModalSpectrum | None:
        """Find the vibrations of a scene; None if it has too many, or what moves it is not known.

        Parameters
        ----------
        system : System
            At its initial state.
        breaks : Breaks
            Where loads jump.
        t_end : float
            End of the motion [s].
        """
        n = system.n_free
        foreseeable = all(each.foreseeable for each in system.contributions)
        # The mass of a flat rigid body alone is singular.
        rigid = any(system.constraints.mass)
        if not 0 < n <= MOST or system.prescribed or not foreseeable or rigid:
            return None
        first = system.loads.amplitudes(np.array([system.t0]))[0]
        none = np.zeros(system.n_multipliers)
        omega, shapes, mass, decay = _vibrations(system, system.q0, none, first)
        speeds = shapes.T @ (mass @ system.v0[:n])
        pushes = [(system.t0, speeds, -shapes.T @ _force(system, system.v0, first))]
        for low, high in zip(breaks.before, breaks.after, strict=True):
            before, after = (system.loads.amplitudes(np.array([t]))[0] for t in (low, high))
            rest = np.zeros(system.n_all)
            jump = _force(system, rest, after) - _force(system, rest, before)
            pushes.append((high, np.zeros_like(speeds), -shapes.T @ jump))
        if _pushed_later(system, breaks, shapes, pushes, omega):
            return None
        moving, lasting = _lasting(omega, decay)
        amplitudes, times = [], []
        for begin, speed, rate in pushes:
            amplitudes.append(_sizes(system, shapes, omega, speed, rate)[moving])
            times.append(np.minimum(t_end - begin, lasting[moving]))
        omega = omega[moving]
        amplitude, time = np.concatenate(amplitudes), np.concatenate(times)
        if amplitude.sum() <= ROUNDING * np.max(np.abs(system.q0)):
            return None
        return cls(amplitude, np.tile(omega, len(pushes)), time)

    @classmethod
    def during(cls, system: System, states: SampledStates) -> ModalSpectrum | None:
        """Find the vibrations of a run, with those that others have set off.

        Amplitudes are means over some times, each of the scene linearized about its shape then.

        Parameters
        ----------
        system : System
            What moves.
        states : States
            Of the run.

        Returns
        -------
        Waves or None
            None if there are too many vibrations, or none.
        """
        n, length = system.n_free, float(states.t[-1] - states.t[0])
        if not 0 < n <= MOST_DURING or any(system.constraints.mass):
            return None
        found: list[tuple[Vector, Vector, Vector]] = []
        for share in SAMPLES:
            k = round(share * (len(states.t) - 1))
            load = system.loads.amplitudes(states.t[k : k + 1])[0]
            lam = np.asarray(states.lam[k])
            omega, shapes, mass, decay = _vibrations(system, states.q[k], lam, load)
            speed, rate = (shapes.T @ (mass @ x[k, :n]) for x in (states.v, states.a))
            moving, lasting = _lasting(omega, decay)
            size = _sizes(system, shapes, omega, speed, rate)[moving] / len(SAMPLES)
            found.append((size, omega[moving], np.minimum(length, lasting[moving])))
        amplitude, omega, time = (np.concatenate(each) for each in zip(*found, strict=True))
        return cls(amplitude, omega, time) if amplitude.any() else None

    def lost(self, tableau: Tableau, h: float) -> Vector:
        """Return the share of each, from 0 to 1, that an explicit method loses in steps h."""
        share = _table_of(tableau).at(self.omega * h)
        return np.asarray(np.minimum(1.0, share * self.omega * self.time))

    def error(self, tableau: Tableau, h: float) -> float:
        """Return the error of a motion in steps h [m]."""
        return float(self.amplitude @ self.lost(tableau, h))

    def apart(self, tableaus: tuple[Tableau, Tableau], steps: tuple[float, float]) -> float:
        """Return the distance of two runs [m]."""
        one, other = (self.lost(*each) for each in zip(tableaus, steps, strict=True))
        return float(self.amplitude @ np.abs(one - other))

    def unseen(self, tableaus: tuple[Tableau, Tableau], steps: tuple[float, float]) -> float:
        """Return what two runs are both off, so that their distance does not show it [m].

        Explicit methods of high order dissipate the fastest vibrations: both runs may have lost
        them.
        """
        one, other = (self.lost(*each) for each in zip(tableaus, steps, strict=True))
        return float(self.amplitude @ (one * other))


@dataclass(frozen=True)
class _Table:
    """Phase lost by the logarithm of z, and its power below."""

    log_z: Vector
    log_lost: Vector
    order: int
    interval: float

    def at(self, z: Vector) -> Vector:
        log_z = np.log(z)
        table = np.exp(np.interp(log_z, self.log_z, self.log_lost))
        below = np.exp(self.order * np.minimum(log_z - self.log_z[0], 0.0))
        return np.asarray(np.where(z < self.interval, table * below, 1.0))


@cache
def _table_of(tableau: Tableau) -> _Table:
    z = np.geomspace(BEGIN * tableau.order, 0.999 * tableau.interval, POINTS)
    lost = np.array([phase_lost(tableau, float(each)) for each in z])
    return _Table(np.log(z), np.log(lost), tableau.order, tableau.interval)


def _lasting(omega: Vector, decay: Vector) -> tuple[NDArray[np.bool_], Vector]:
    """Return which modes vibrate, and the times in which they decay [s]."""
    moving = (omega > AT_REST * omega.max(initial=0.0)) & (decay < 2.0 * omega)
    lasting = np.full_like(omega, np.inf)
    np.divide(2.0, decay, out=lasting, where=decay > 0.0)
    return moving, lasting


def _sizes(system: System, shapes: Vector, omega: Vector, speed: Vector, rate: Vector) -> Vector:
    """Return the largest motion of a node in each mode [m]; of no use where a mode is at rest."""
    nodes = np.unique(system.positions)
    size = np.abs(shapes[nodes[nodes < system.n_free]]).max(axis=0, initial=0.0)
    slowest = np.maximum(omega, np.finfo(float).tiny ** 0.25)
    return np.asarray(size * np.hypot(speed / slowest, rate / slowest**2))


def _vibrations(
    system: System, q: Vector, lam: Vector, amplitudes: Vector
) -> tuple[Vector, Vector, Vector, Vector]:
    """Return frequencies, shapes of unit modal mass, the mass matrix, and rates of decay."""
    import scipy.linalg

    n = system.n_free

    def dense(values: Vector) -> Vector:
        return np.asarray(symmetric_from_lower(free_submatrix(system, values)).toarray())

    mass = np.asarray(symmetric_from_lower(mass_matrix(system)).toarray())
    stiffness = dense(system.assembly.matrix(0.0, 1.0, q, lam, amplitudes))
    held = np.eye(n)
    if system.n_multipliers:
        held = scipy.linalg.null_space(system.constraints.jacobian(q)[:, :n].toarray())
    squares, shapes = scipy.linalg.eigh(held.T @ stiffness @ held, held.T @ mass @ held)
    shapes = held @ shapes
    decay = np.zeros(len(squares))
    if system.damped:
        damping = dense(system.assembly.matrix(0.0, 0.0, q, lam, amplitudes, damping_factor=1.0))
        decay = np.einsum("ik,ij,jk->k", shapes, damping, shapes)
    return np.sqrt(np.maximum(squares, 0.0)), shapes, mass, decay


def _pushed_later(
    system: System,
    breaks: LoadDiscontinuities,
    shapes: Vector,
    pushes: list[tuple[float, Vector, Vector]],
    omega: Vector,
) -> bool:
    """Whether loads that change without a jump do more than the start and all jumps."""
    amplitudes, rest = breaks.amplitudes, np.zeros(system.n_all)
    first = amplitudes[0]
    known = sum(np.hypot(omega * speed, rate) for _, speed, rate in pushes)
    later = np.zeros_like(omega)
    for column in range(len(first)):
        change = amplitudes[:, column] - first[column]
        most = first.copy()
        most[column] += change[np.argmax(np.abs(change))]
        later += np.abs(shapes.T @ (_force(system, rest, most) - _force(system, rest, first)))
    return bool(np.linalg.norm(later) > LATER * np.linalg.norm(known))


def _force(system: System, v: Vector, amplitudes: Vector) -> Vector:
    """Return forces at the initial shape that must balance M a, (n_free,) [N, N m]."""
    none, lam = np.zeros(system.n_all), np.zeros(system.n_multipliers)
    r, _ = system.assembly.residual(system.q0, v, none, lam, system.dead_load, amplitudes)
    return np.asarray(r[: system.n_free])
