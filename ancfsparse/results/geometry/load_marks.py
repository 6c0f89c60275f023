"""Symbols of masses and loads in pictures."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.scene import Beam, Point
from ancfsparse.scene.force_elements.masses import PointMass
from ancfsparse.scene.force_elements.user_forces import Force
from ancfsparse.scene.loads.loads import DistributedForce, PointForce, PointMoment
from ancfsparse.system.system import System

MAX_ARROWS = 7  # of a distributed force, which are enough to see where it acts


def make_load_marks(system: System) -> Iterator[tuple[str, Point, Vector]]:
    """Return kind, point and direction of the symbols of point masses and loads.

    Directions are unit vectors of forces fixed in space at t = 0, zero of forces that are zero
    then, follow the body or are functions of the motion; and (1, 0) or (-1, 0) of moments in the
    plane.
    """
    none = np.zeros(system.scene.dim)
    for element in system.attachments:
        if isinstance(element, PointMass):
            yield "mass", element.node, none
        elif isinstance(element, Force):
            for point in element.points:
                yield "force", point, none
    for load in system.external_loads:
        if isinstance(load, PointForce):
            yield "force", load.node, none if load.follow else _direction(load.at(0.0))
        elif isinstance(load, PointMoment):
            sign = np.sign(load.at(0.0)[0]) * np.eye(system.scene.dim)[0]
            yield "moment", load.node, sign if system.scene.dim == 2 else none
        elif isinstance(load, DistributedForce):
            yield from _arrows(load, none)


def _arrows(load: DistributedForce, none: Vector) -> Iterator[tuple[str, Point, Vector]]:
    """Return the symbols of a distributed force, at some nodes of its body."""
    body, factors = load.beam, np.ones(load.beam.n_nodes)
    if load.along is not None and isinstance(body, Beam):
        factors = load.factors(body.arcs)
    has_direction = not load.follow and (load.along is None or isinstance(body, Beam))
    value = load.at(0.0)
    for node in np.unique(np.linspace(0, body.n_nodes - 1, MAX_ARROWS).astype(int)):
        yield (
            "force",
            body.node(int(node)),
            _direction(factors[node] * value) if has_direction else none,
        )


def _direction(force: Vector) -> Vector:
    """Return the unit vector of a force, zero of none."""
    return force / (float(np.linalg.norm(force)) or 1.0)
