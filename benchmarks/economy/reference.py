"""References of plans and of the search: fine runs, extrapolated, of the right model."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from ancfsparse.array_types import Vector
from ancfsparse.integrators import Explicit, GeneralizedAlpha, Implicit
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.solve import simulate, solve_static
from benchmarks.economy.scenes import RICHEST, Case, Discretization

SAVE_EVERY = 4  # steps of the finest run
THICK_ELEMENTS = 128  # of a thick reference
MAX_MODEL_ERROR = 0.1  # difference of models that may be neglected, over the least tolerance
REFINEMENTS = (1, 2, 4)  # of a reference until it is certain
MAX_UNCERTAINTY = 0.2  # of a certain reference, over the least tolerance
COMPARED_STATES = 400  # of other runs


class Reference:
    """The quantity over time, of the richest model where the models differ.

    Parameters
    ----------
    case : Case
        The scene.
    least : float
        Least tolerance, over the size of the quantity [-].

    Attributes
    ----------
    size : float
        Scale of the errors [unit of the quantity].
    uncertain : float
        Uncertainty over that size [-].
    is_thick : bool
        True if it is of thick elements.
    """

    def __init__(self, case: Case, least: float) -> None:
        self.t_end = case.t_end
        for finer in REFINEMENTS:
            values = self._found(case, least, finer)
            if self.uncertain <= MAX_UNCERTAINTY * least:
                break
        self._at = CubicSpline(self._t, values) if case.t_end else lambda t: values

    def _found(self, case: Case, least: float, finer: int) -> Vector:
        """Return the values of meshes and steps refined by a factor."""
        element, options = case.elements[0]
        self._t, values, self.size, self.uncertain = _extrapolated(case, element, options, finer)
        self.is_thick = element == RICHEST[0]
        if not self.is_thick and case.is_thick_tried:
            _, thick, _, uncertain = _extrapolated(case, *RICHEST, finer)
            difference = float(np.linalg.norm(thick - values, axis=1).max()) / self.size
            if difference > MAX_MODEL_ERROR * least + self.uncertain:
                self.is_thick, self.uncertain = True, uncertain
                values = thick
        return values

    def error(self, t: Vector, history: Vector) -> float:
        """Return the largest error over the size of the quantity [-]."""
        return float(np.linalg.norm(history - self._at(t), axis=1).max()) / self.size


def _extrapolated(
    case: Case, element: str, options: Mapping[str, str], finer: int
) -> tuple[Vector, Vector, float, float]:
    """Return times, values, their size and their uncertainty, of three runs.

    Each has twice the steps and elements of the one before.  Two give values without the error of
    second order; three give the difference of these.
    """
    most = finer * (max(case.most, THICK_ELEMENTS) if element == RICHEST[0] else case.most)
    steps = finer * case.steps
    histories = []
    for part in (4, 2, 1):
        scene, quantity = case.build(Discretization(element, most // part, options))
        run = run_in(
            scene, case.t_end, steps // part, GeneralizedAlpha(0.9), SAVE_EVERY * finer // part
        )
        histories.append(values_of(quantity, run))
    times = times_of(run)
    one, other = (fine + (fine - coarse) / 3.0 for coarse, fine in pairwise(histories))
    size = float(np.linalg.norm(other[-1])) if case.t_end is None else quantity.size(other)
    difference = float(np.linalg.norm(other - one, axis=1).max())
    return times, other, size, difference / 3.0 / size


def run_in(
    scene: Any,
    t_end: float | None,
    steps: int,
    integrator: Implicit | Explicit,
    every: int | None = None,
) -> Any:
    """Run a scene in a number of steps, or find its equilibrium."""
    if t_end is None:
        return solve_static(scene)
    every = max(1, steps // COMPARED_STATES) if every is None else every
    return simulate(scene, t_end, t_end / steps, integrator=integrator, save_every=max(1, every))


def times_of(run: Any) -> Vector:
    """Return the saved times (k,) [s]; 0 of an equilibrium."""
    return np.asarray(getattr(run, "t", 0.0)) * np.ones(1)


def values_of(quantity: Quantity, run: Any) -> Vector:
    """Return values (k, m); of an equilibrium (1, m)."""
    return np.atleast_2d(quantity.history(run))
