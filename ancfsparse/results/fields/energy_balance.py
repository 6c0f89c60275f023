"""The energy balance of a motion."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.recovery.reactions import drive_power, drive_work
from ancfsparse.system.system import System

ENERGIES = (
    "kinetic", "elastic", "potential", "contact", "work", "dissipated", "friction",
    "impact_damping", "total",
)  # fmt: skip
"""Energies of `Energy`, in the order of a plot or a table."""
BLOCK_SIZE = 4_000_000  # entries of a table of states that are evaluated together
ROUNDING = 64.0 * float(np.finfo(float).eps)  # of energy sums, over the largest energy


@dataclass(frozen=True, eq=False)
class Energy:
    """Energies at the saved states.

    Attributes
    ----------
    kinetic : ndarray, shape (k,)
        Kinetic energy [J].
    elastic : ndarray, shape (k,)
        Strain energy [J].
    potential : ndarray, shape (k,)
        Potential of gravity, and of the centrifugal forces of a rotating frame [J].
    contact : ndarray, shape (k,)
        Potential of the pressures of contacts [J].
    work : ndarray, shape (k,)
        Work of prescribed motions and of all applied forces except gravity since the first saved
        state [J]: their power, integrated by the trapezoidal rule over the saved states, which must
        therefore resolve the loads.  With `EnergyMomentum` and all steps saved, the work of
        prescribed motions is that of its mean forces, without quadrature error.  It includes the
        work that a drum with a given ``angular_velocity`` does by friction, summed over all steps.
    dissipated : ndarray, shape (k,)
        Energy dissipated by damping since the first saved state [J], integrated like ``work``.
    friction : ndarray, shape (k,)
        Energy lost by friction of contacts since the first saved state [J]: the work of friction
        along the sliding, and the energy stored in bristles, which can return.  It is the sum over
        all steps, also those that were not saved or are parts of divided ones.  With
        `EnergyMomentum` its forces are those between two states, without quadrature error;
        otherwise it follows from the forces at the ends of a step by the trapezoidal rule.
    impact_damping : ndarray, shape (k,)
        Energy lost by the damping of impacts since the first saved state [J].  Numerical damping
        is zero with `EnergyMomentum`, with explicit integrators, and in runs to an accuracy; the
        damping of a coefficient of restitution is not.  It is summed like ``friction``.
    """

    kinetic: Vector
    elastic: Vector
    potential: Vector
    contact: Vector
    work: Vector
    dissipated: Vector
    friction: Vector
    impact_damping: Vector

    @property
    def total(self) -> Vector:
        """Sum of kinetic, elastic, potential and contact energy, shape (k,) [J]."""
        return self.kinetic + self.elastic + self.potential + self.contact

    @property
    def lost(self) -> Vector:
        """Sum of the energies lost to damping, friction and damped impacts, shape (k,) [J]."""
        return self.dissipated + self.friction + self.impact_damping

    @property
    def drift(self) -> float:
        """Largest error of the energy balance, relative to the largest kinetic energy [-].

        ``max |E(t) - E(0) - work(t) + lost(t)| / max kinetic``; 0 if it is a rounding error of the
        energies, for example at rest.
        """
        error = float(np.abs(self.total - self.total[0] - self.work + self.lost).max())
        parts = (self.kinetic, self.elastic, self.potential, self.contact, self.work, self.lost)
        if error <= ROUNDING * max(float(np.abs(part).max()) for part in parts):
            return 0.0
        return error / float(self.kinetic.max())

    def __repr__(self) -> str:
        """Summarise the balance in one line."""
        return (
            f"Energy: {self.total[0]:.6g} J at the start, {self.total[-1]:.6g} J at the end, "
            f"work {self.work[-1]:.6g} J, dissipated {self.dissipated[-1]:.6g} J, "
            + (f"friction {self.friction[-1]:.6g} J, " if self.friction.any() else "")
            + (
                f"damped impacts {self.impact_damping[-1]:.6g} J, "
                if self.impact_damping.any()
                else ""
            )
            + f"drift {self.drift:.3g}"
        )


def evaluate_energy(system: System, states: StateHistory, lag: float = 0.0) -> Energy:
    """Evaluate the energy balance.

    Parameters
    ----------
    system : System
        The system of the states.
    states : StateHistory
        Its states; the tables may be in a file.
    lag : float, optional
        Time by which accelerations and multipliers precede the others, except in the first state
        [s]: half a step if they are means over it.

    Returns
    -------
    Energy
        Energies at those times.
    """
    q, v, a, lam, t, history = states
    # Blocks of rows: the states may be in a file and exceed the memory.
    step = max(1, BLOCK_SIZE // max(1, q.shape[1]))
    parts, drive_works, parametric_works = [], [], []
    every_step = lag > 0.0 and np.allclose(np.diff(t), 2.0 * lag, rtol=1e-6, atol=0.0)
    for i in range(0, len(t), step):
        q_part, v_part = q[i : i + step], v[i : i + step]
        t_part = t[i : i + step]
        power = system.power(q_part, v_part, t_part)
        driving = np.zeros(len(t_part))
        if system.is_driven:
            a_part, lam_part = a[i : i + step], lam[i : i + step]
            back = np.where(np.arange(i, i + len(t_part)) > 0, lag, 0.0)
            q_then = q_part - back[:, None] * v_part
            v_then = v_part - back[:, None] * a_part
            before = np.maximum(np.arange(i, i + len(t_part)) - (lag > 0.0), 0)
            z_then = 0.5 * (history[before] + history[i : i + step])
            then = StateHistory(q_then, v_then, a_part, lam_part, t_part - back, z_then)
            driving = drive_power(system, then)
            if every_step:
                rows = slice(max(i - 1, 0), i + step)
                drive_works.append(
                    drive_work(system, StateHistory(*(each[rows] for each in states)))
                )
        lost = system.dissipation(q_part, v_part, lam[i : i + step])
        parts.append((*system.energies(q_part, v_part, t_part), power, driving, lost))
        if system.has_parametric_work:
            rows = slice(max(i - 1, 0), i + step)
            parametric_works.append(system.parametric_work(q[rows], t[rows]))
    columns = (np.concatenate(part) for part in zip(*parts, strict=True))
    kinetic, elastic, potential, contact, power, driving, lost = columns
    work = _integrate(t, power)
    if drive_works:
        work[1:] += np.cumsum(np.concatenate(drive_works))
    else:
        work += _integrate(t, _interpolate_lagged(t, driving, lag) if lag else driving)
    if parametric_works:
        work[1:] += np.cumsum(np.concatenate(parametric_works))
    turning, friction, impact_damping = _contact_losses(system, history)
    work += turning
    dissipated = _integrate(t, lost)
    return Energy(kinetic, elastic, potential, contact, work, dissipated, friction, impact_damping)


def _contact_losses(system: System, history: Vector) -> Vector:
    """Return work of turning obstacles, losses to friction and damped impacts, (3, k) [J]."""
    losses: Vector = np.zeros((len(history), 3))
    for each in system.contributions:
        losses += each.contact_losses(history)
    losses -= losses[0]
    return losses.T


def _interpolate_lagged(t: Vector, values: Vector, lag: float) -> Vector:
    """Interpolate values linearly to times t, from times t - lag except for the first."""
    if len(t) < 3:
        return values
    then = np.append(t[0], t[1:] - lag)
    end = values[-1] + (values[-1] - values[-2]) / (then[-1] - then[-2]) * lag
    out: Vector = np.interp(t, np.append(then, t[-1]), np.append(values, end))
    return out


def _integrate(t: Vector, power: Vector) -> Vector:
    """Integrate over time by the trapezoidal rule, from zero at the first state."""
    out = np.zeros(len(t))
    np.cumsum(0.5 * np.diff(t) * (power[1:] + power[:-1]), out=out[1:])
    return out
