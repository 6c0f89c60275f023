"""Range of the trial runs, beyond which predictions may not hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ancfsparse.results import Trajectory
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.scene import ElasticBody
from ancfsparse.system import System

MAX_RATIO = 1.5  # of the extremes of a run to those of the trial runs
# Peaks of short forces that the trial runs contain depend on the saved states.
MAX_FORCE_RATIO = 10.0  # of a unilateral force; above, it is a contact absent from the trial runs
ROUNDING = 1e-9  # of strains and rotations [-, rad]
MAX_STATES = 200  # saved states that are evaluated
MAX_FORCE_STATES = 2000  # the same for unilateral forces, which may be short
MAX_TIMES = 20000  # at which loads are evaluated


@dataclass(frozen=True)
class ValidityRange:
    """Extremes of a motion.

    Attributes
    ----------
    strain : float
        Largest axial strain [-].
    turn : float
        Largest rotation of a slope in a step [rad].
    loads : tuple of float
        Largest amplitude of every load over the steps.
    forces : tuple of (str, float)
        Largest value of each unilateral force, such as that of a stop or a rope, by its name.
    """

    strain: float
    turn: float
    loads: tuple[float, ...]
    forces: tuple[tuple[str, float], ...] = ()

    def exceeded_by(self, other: ValidityRange) -> str:
        """Return a sentence on the range that another motion exceeds; empty if it does not."""
        rows = [
            ("strains reach", self.strain, other.strain, "", MAX_RATIO, ROUNDING),
            ("rotations in a step reach", self.turn, other.turn, "", MAX_RATIO, ROUNDING),
        ]
        if len(self.loads) == len(other.loads):
            pairs = zip(self.loads, other.loads, strict=True)
            rows += [("a load reaches", *each, " times its unit", MAX_RATIO, 0.0) for each in pairs]
        if len(self.forces) == len(other.forces):
            for (_, known), (name, reached) in zip(self.forces, other.forces, strict=True):
                rows.append((f"{name} reaches", known, reached, "", MAX_FORCE_RATIO, 0.0))
        for what, known, reached, unit, ratio, rounding in rows:
            if reached > ratio * known + rounding:
                return f"{what} {reached:.3g}{unit}, compared with {known:.3g} in the trial runs"
        return ""


def validity_range(run: Trajectory, steps: int) -> ValidityRange:
    """Return the extremes of a motion with a number of steps."""
    system = run.system
    assert isinstance(system, System)
    rows = _even_rows(run, MAX_STATES)
    states = select_states(run, rows)
    strain = 0.0
    for body in system.scene.beams:
        if isinstance(body, ElasticBody):
            strain = max(strain, float(np.abs(states.strain(body)).max()))
    dt = float(run.t[-1] - run.t[0]) / steps
    slopes = np.setdiff1d(np.arange(system.n_all), system.positions)
    v = np.asarray(run.v)[rows][:, slopes]
    turn = dt * float(np.abs(v).max(initial=0.0))
    times = np.linspace(run.t[0], run.t[-1], min(steps, MAX_TIMES) + 1)
    loads = np.abs(np.asarray(system.loads.amplitudes(times))).max(axis=0, initial=0.0)
    return ValidityRange(strain, turn, tuple(loads.tolist()), _unilateral_forces(run))


def _unilateral_forces(run: Trajectory) -> tuple[tuple[str, float], ...]:
    """Return the largest values of unilateral forces, by name."""
    system = run.system
    assert isinstance(system, System)
    rows = _even_rows(run, MAX_FORCE_STATES)
    q, v = (np.asarray(each)[rows] for each in (run.q, run.v))
    amplitudes = system.loads.amplitudes(np.asarray(run.t)[rows])
    return tuple(
        (name, float(np.abs(values).max()))
        for each in system.contributions
        for name, values in each.unilateral_forces(q, v, amplitudes)
    )


def _even_rows(run: Trajectory, count: int) -> NDArray[np.intp]:
    """Return the indices of at most `count` evenly spaced states."""
    return np.unique(np.linspace(0, len(run.t) - 1, count).astype(int))
