"""The energy balance of a run."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.results.data.interpolation import Array
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.recovery.reactions import drive_power, drive_work
from ancfsparse.system.system import System

# Numbers of a table of states that are looked at together.
BLOCK = 4_000_000
# Share of the largest energy by which sums of energies are rounded.
ROUNDING = 64.0 * float(np.finfo(float).eps)


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
    work : ndarray, shape (k,)
        Work of drives and of all applied forces but gravity since the first saved state [J]: their
        power, summed by the trapezoidal rule over the saved states, so save often where loads
        change.  With `EnergyMomentum` and all steps saved, the work of drives is that of its mean
        forces, without an error of the sum.
    dissipated : ndarray, shape (k,)
        What damping took since the first saved state [J]: the power against its forces, summed
        like ``work``.
    """

    kinetic: Array
    elastic: Array
    potential: Array
    work: Array
    dissipated: Array

    @property
    def total(self) -> Array:
        """Kinetic, elastic and potential energy together, shape (k,) [J]."""
        return self.kinetic + self.elastic + self.potential

    @property
    def drift(self) -> float:
        """Largest energy gained or lost without cause, over the largest kinetic energy [-].

        ``max |E(t) - E(0) - work(t) + dissipated(t)| / max kinetic``; 0 where that is rounding of
        the energies, as where nothing ever moves.
        """
        gained = float(np.abs(self.total - self.total[0] - self.work + self.dissipated).max())
        parts = (self.kinetic, self.elastic, self.potential, self.work, self.dissipated)
        if gained <= ROUNDING * max(float(np.abs(part).max()) for part in parts):
            return 0.0
        return gained / float(self.kinetic.max())

    def __repr__(self) -> str:
        """Give the balance in one line."""
        return (
            f"Energy: {self.total[0]:.6g} J at the start, {self.total[-1]:.6g} J at the end, "
            f"work {self.work[-1]:.6g} J, dissipated {self.dissipated[-1]:.6g} J, "
            f"drift {self.drift:.3g}"
        )


def energy_of(system: System, states: StateHistory, lag: float = 0.0) -> Energy:
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
    q, v, a, lam, t = states
    # In blocks of rows: the states may be in a file and too large for memory.
    step = max(1, BLOCK // max(1, q.shape[1]))
    parts, works, wound = [], [], []
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
            then = StateHistory(q_then, v_then, a_part, lam_part, t_part - back)
            driving = drive_power(system, then)
            if every_step:
                rows = slice(max(i - 1, 0), i + step)
                works.append(drive_work(system, StateHistory(*(each[rows] for each in states))))
        lost = system.dissipation(q_part, v_part, lam[i : i + step])
        parts.append((*system.energies(q_part, v_part, t_part), power, driving, lost))
        if system.winds:
            rows = slice(max(i - 1, 0), i + step)
            wound.append(system.winding(q[rows], t[rows]))
    columns = (np.concatenate(part) for part in zip(*parts, strict=True))
    kinetic, elastic, potential, power, driving, lost = columns
    work = _summed(t, power)
    if works:
        work[1:] += np.cumsum(np.concatenate(works))
    else:
        work += _summed(t, _caught_up(t, driving, lag) if lag else driving)
    if wound:
        work[1:] += np.cumsum(np.concatenate(wound))
    return Energy(kinetic, elastic, potential, work, _summed(t, lost))


def _caught_up(t: Array, values: Array, lag: float) -> Array:
    """Return values at times t, from those at t - lag but for the first, by straight lines."""
    if len(t) < 3:
        return values
    then = np.append(t[0], t[1:] - lag)
    end = values[-1] + (values[-1] - values[-2]) / (then[-1] - then[-2]) * lag
    out: Array = np.interp(t, np.append(then, t[-1]), np.append(values, end))
    return out


def _summed(t: Array, power: Array) -> Array:
    """Integrate over time by the trapezoidal rule, from zero at the first state."""
    out = np.zeros(len(t))
    np.cumsum(0.5 * np.diff(t) * (power[1:] + power[:-1]), out=out[1:])
    return out
