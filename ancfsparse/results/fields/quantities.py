"""Quantities of points and elements of beams, over time, along a beam, or as colours."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results.fields.contact_forces import force_on_elements
from ancfsparse.results.fields.motion import UNITS, Motion
from ancfsparse.results.fields.section_forces import (
    SectionPoints,
    curvature,
    locate_points,
    section_force,
    strain,
)
from ancfsparse.results.geometry.deformed_shape import read_rows
from ancfsparse.scene import Beam, Body, ElasticBody, check_point
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System

QUANTITIES = {
    "N": ("axial force", "N"),
    "Q": ("shear force", "N"),
    "M": ("bending moment", "N m"),
    "T": ("torsion", "N m"),
    "strain": ("strain", "-"),
    "curvature": ("curvature", "1/m"),
    "pressure": ("pressure of contacts", "N/m"),
    "friction": ("friction of contacts", "N/m"),
}
"""Quantities of beams, over time or along a beam, with name and unit."""
CONTACT_QUANTITIES = "pressure", "friction"
ELEMENT_MEANS = ("strain", *CONTACT_QUANTITIES)
"""Quantities that are mean values of elements."""


def label_of(what: str) -> str:
    """Return the name of a quantity with its unit."""
    return "{} [{}]".format(*QUANTITIES[what])


def select_states(run: Motion, rows: NDArray[np.intp] | None = None) -> StateHistory:
    """Return the states of a run for the evaluation of quantities, or some rows of them."""
    none = np.empty((len(run.t), 0))
    if rows is None:
        return StateHistory(run.q, run.v, none, none, run.t, run.internal)
    q, v, history = (read_rows(table, rows) for table in (run.q, run.v, run.internal))
    return StateHistory(q, v, none[rows], none[rows], run.t[rows], history)


def evaluate_quantity(
    system: System, states: StateHistory, what: str, body: ElasticBody, s: SectionPoints = None
) -> Vector:
    """Evaluate a quantity at points of a body, (k, p) or (k, p, components).

    Friction is its magnitude; pressure and friction are mean values of the element of each point.
    """
    if what in CONTACT_QUANTITIES:
        own, where = locate_points(system, body, s)
        forces = force_on_elements(system, own, states)
        sizes = forces.pressure if what == "pressure" else np.linalg.norm(forces.friction, axis=2)
        return np.asarray(sizes[:, where.elements])
    if what == "strain":
        return strain(system, states.q, body, s)
    if what == "curvature":
        return curvature(system, states.q, body, s)
    inside = section_force(system, states.q, states.v, states.t, body, s)
    values: Vector | None = getattr(inside, what)
    if values is None:
        raise InputError(
            f"{body.name} has no torsion: it is "
            + ("planar" if body.dim == 2 else f"made of {body.element!r}; take 'thick'")
        )
    return values


def components_of(values: Vector, what: str, body: Body) -> list[tuple[Vector, str]]:
    """Return the components of values (n, c) with their names; a scalar (n,) has no name.

    Quantities of sections of thick beams are in the axes of the section, all others in space.
    """
    if values.ndim == 1:
        return [(values, "")]
    names = ["x", "y", "z"][: values.shape[1]]
    if what in QUANTITIES and not body.kind.is_cable:
        names = ["twist", "about y", "about z"] if what == "curvature" else ["y", "z"]
    return list(zip(values.T, names, strict=True))


def unit_of(what: str) -> str:
    """Return the unit of a quantity of a point or of a beam."""
    return UNITS[what] if what in UNITS else QUANTITIES[what][1]


def evaluate_history(run: Motion, node: object, what: str) -> Vector:
    """Evaluate a quantity at a point over all states; see `Trajectory.history`."""
    check_choice("quantity", what, (*UNITS, *QUANTITIES))
    point = check_point(f"the history of {what}", node)
    if what in UNITS:
        values: Any = getattr(run, what)(point)
        return np.asarray(values)
    if not isinstance(point.beam, ElasticBody):
        raise InputError(f"{what} needs a point of a beam or a mesh, got {point!r}")
    return evaluate_quantity(run.system, select_states(run), what, point.beam, [point])[:, 0]


class ValueRange(NamedTuple):
    """Minimum, mean and maximum value of a quantity along a beam, over all saved states.

    Attributes
    ----------
    s : ndarray, shape (p,)
        Arc coordinates [m].
    min, mean, max : ndarray, shape (p,) or (p, components)
        Values in the unit of the quantity; the mean is over the saved states.
    """

    s: Vector
    min: Vector
    mean: Vector
    max: Vector


def evaluate_range(run: Motion, what: str, line: object) -> ValueRange:
    """Evaluate the range of a quantity along a beam; see `Trajectory.range`."""
    check_choice("quantity", what, QUANTITIES)
    _, arcs, values = evaluate_along(run.system, select_states(run), what, line)
    return ValueRange(arcs, values.min(axis=0), values.mean(axis=0), values.max(axis=0))


def evaluate_along(
    system: System, states: StateHistory, what: str, line: object
) -> tuple[Beam, Vector, Vector]:
    """Evaluate a quantity along a beam: the beam, arc coordinates (p,) [m], values (k, p[, c]).

    Mean values of elements are those at their midpoints; other quantities also at both ends of the
    beam, where moments are often largest.
    """
    if not isinstance(line, Beam):
        raise InputError(
            f"{what} is evaluated along a beam of the run or, over time, at a point of it such as "
            f"rod.at(0.5), got {format_value(line)}"
        )
    own = locate_points(system, line, None)[0]
    ends = np.cumsum(own.lengths)
    arcs = ends - 0.5 * own.lengths
    if what not in ELEMENT_MEANS:
        arcs = np.concatenate([[0.0], arcs, ends[-1:]])
    return line, arcs, evaluate_quantity(system, states, what, line, arcs)
