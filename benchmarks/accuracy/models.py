"""The pendulum by element, as the studies of accuracy compare it: planar, pinned by numbering."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.problems import Problem, pendulum

Tips = NDArray[np.float64]

# The tip is compared at so many instants, the last one at the end of the run.
INSTANTS = 4


@dataclass(frozen=True)
class Model:
    """An element and its options.

    Attributes
    ----------
    name : str
        For tables and charts.
    element : str
        As `Scene.add_beam` calls it.
    options : dict of str to str
        Options of the element.
    order : int
        Power of the element length with which the tip error falls on fine meshes.
    """

    name: str
    element: str
    options: dict[str, str] = field(default_factory=dict)
    order: int = 4

    def problem(self, n_elements: int) -> Problem:
        """Return the planar pendulum of so many of these elements.

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


def instants(t_end: float) -> NDArray[np.float64]:
    """Return when the tip is compared, (4,) [s]: every half second of two."""
    return np.linspace(t_end / INSTANTS, t_end, INSTANTS, dtype=np.float64)


def meets_instants(dt: float, t_end: float) -> bool:
    """Return whether whole steps lead to every instant."""
    parts = t_end / INSTANTS / dt
    return parts > 0.5 and abs(parts - round(parts)) < 1e-9 * parts


def step_up_to(dt: float, t_end: float) -> float:
    """Return the largest step no larger than `dt` that meets every instant [s]."""
    return t_end / INSTANTS / math.ceil(t_end / INSTANTS / dt * (1.0 - 1e-9))


def distance(tip: Tips, other: Tips) -> float:
    """Return the largest distance between two tips over the instants [m]; both (4, 2)."""
    return float(np.linalg.norm(tip - other, axis=1).max())
