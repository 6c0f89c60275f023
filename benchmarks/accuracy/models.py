"""The planar pendulum by element, for the studies of accuracy."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.problems import Problem, pendulum

Tips = NDArray[np.float64]

OUTPUTS = 4  # times at which tips are compared, the last one at the end of the run


@dataclass(frozen=True)
class Model:
    """An element and its options."""

    name: str  # for tables and charts
    element: str  # as `Scene.add_beam` calls it
    options: dict[str, str] = field(default_factory=dict)  # options of the element
    order: int = 4  # power of the element length with which the tip error falls on fine meshes

    def problem(self, n_elements: int) -> Problem:
        """Return the planar pendulum of `n_elements` of these elements.

        The motion stays in the plane whether or not the scene is planar, so a planar scene has the
        same motion with fewer coordinates.
        """
        options: dict[str, Any] = self.options
        return pendulum(self.element, n_elements, 2, **options)


MODELS = {
    model.name: model
    for model in (
        Model("L2T2", "l2t2"),
        Model("Thin", "thin"),
        Model("Thin, Biot", "thin", {"strain": "biot"}),
        Model("Thick", "thick"),
        Model("Thick, nodal", "thick", {"section_strain": "nodal"}, order=2),
    )
}
"""By name: the paper's three elements, Exudyn's strain, and the thick beam without locking."""


def output_times(t_end: float) -> NDArray[np.float64]:
    """Return the times at which tips are compared, (4,) [s]: every half second of two."""
    return np.linspace(t_end / OUTPUTS, t_end, OUTPUTS, dtype=np.float64)


def meets_outputs(dt: float, t_end: float) -> bool:
    """Return True if whole steps lead to every output time."""
    parts = t_end / OUTPUTS / dt
    return parts > 0.5 and abs(parts - round(parts)) < 1e-9 * parts


def step_up_to(dt: float, t_end: float) -> float:
    """Return the largest step no larger than `dt` that meets every output time [s]."""
    return t_end / OUTPUTS / math.ceil(t_end / OUTPUTS / dt * (1.0 - 1e-9))


def distance(tip: Tips, other: Tips) -> float:
    """Return the largest distance between two tips over the output times [m]; both (4, 2)."""
    return float(np.linalg.norm(tip - other, axis=1).max())
