"""Range of the trial runs, beyond which predictions may not hold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.plans.models.rigid_links import ROUNDING
from ancfsparse.plans.trial_runs.trial_runs import MAX_INTERVALS
from ancfsparse.results import Trajectory
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.scene import ElasticBody
from ancfsparse.system import System

# Rates of slopes after a jump of a load grow with the mesh, and a plan with 200 elements seemed out
# of range for a rotation of 2e-3 rad.  The phase error of a step is a twelfth of its cube.
NEGLIGIBLE_TURN = 1e-2  # rad in a step
MAX_RATIO = 1.5  # of the extremes of a run to those of the trial runs
# Peaks of short forces that the trial runs contain depend on the saved states.
MAX_FORCE_RATIO = 10.0  # of a unilateral force; above, it is a contact absent from the trial runs


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
            ("strains reach", self.strain, other.strain, "", MAX_RATIO),
            (
                "rotations in a step reach",
                max(self.turn, NEGLIGIBLE_TURN),
                other.turn,
                "",
                MAX_RATIO,
            ),
        ]
        if len(self.loads) == len(other.loads):
            pairs = zip(self.loads, other.loads, strict=True)
            rows += [("a load reaches", *each, " times its unit", MAX_RATIO) for each in pairs]
        known_forces = dict(self.forces)
        rows += [
            (f"{name} reaches", known_forces[name], reached, "", MAX_FORCE_RATIO)
            for name, reached in other.forces
            if name in known_forces
        ]
        for what, known, reached, unit, ratio in rows:
            if reached > ratio * known + ROUNDING:
                return f"{what} {reached:.3g}{unit}, compared with {known:.3g} in the trial runs"
        return ""


def validity_range(run: Trajectory, steps: int) -> ValidityRange:
    """Return the extremes of a motion with a number of steps."""
    system = run.system
    assert isinstance(system, System)
    last = len(run.t) - 1
    states = select_states(run, np.unique(np.linspace(0, last, MAX_INTERVALS).astype(int)))
    bodies = (body for body in system.scene.beams if isinstance(body, ElasticBody))
    strain = max((float(np.abs(states.strain(body)).max()) for body in bodies), default=0.0)
    slopes = np.setdiff1d(np.arange(system.n_all), system.positions)
    rate = float(np.abs(states.v[:, slopes]).max(initial=0.0))
    times = np.linspace(run.t[0], run.t[-1], steps + 1)
    loads = np.abs(np.asarray(system.loads.amplitudes(times))).max(axis=0, initial=0.0)
    amplitudes = system.loads.amplitudes(states.t)
    forces = tuple(
        (name, float(np.abs(values).max()))
        for each in system.contributions
        for name, values in each.unilateral_forces(states.q, states.v, amplitudes)
    )
    turn = float(run.t[-1] - run.t[0]) / steps * rate
    return ValidityRange(strain, turn, tuple(loads.tolist()), forces)
