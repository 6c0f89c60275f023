"""Outlines of rigid bodies: shapes and joint positions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.scene import Point
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.bodies.rigid_shapes import Cylinder
from ancfsparse.system.system import System

if TYPE_CHECKING:
    import h5py

FORMS = ("inertia", "rod", "box", "sphere", "cylinder x", "cylinder y", "cylinder z", "lines")
PACKED: dict[str, Any] = {"compression": "gzip", "shuffle": True}


@dataclass(frozen=True, eq=False)
class RigidOutline:
    """Outline of a rigid body.

    Attributes
    ----------
    name : str
        Name of the body.
    form : str
        One of `FORMS`.
    places : ndarray of int, shape (n_vectors + 1, dim)
        Coordinates of its origin and unit vectors.
    reach : ndarray, shape (3,)
        Half extents along its vectors [m]; for a body without shape those of the box of equal mass
        and inertia.
    points : ndarray, shape (n, n_vectors)
        Its centre in the frame of the body [m], followed by the points of its joints, ropes and
        springs for a body without shape; of the form "lines" the pairs of their ends.
    """

    name: str
    form: str
    places: NDArray[np.int32]
    reach: Vector
    points: Vector


def make_solid(system: System, body: RigidBody, used: Iterable[Point]) -> RigidOutline:
    """Return the outline of a rigid body with joints and force elements at the points `used`."""
    places = system.rows(body.origin)[0].reshape(body.n_vectors + 1, body.dim).astype(np.int32)
    centre = body.masses[0, 1:] / body.mass
    shape = body.shape
    if shape is None:
        n = body.n_vectors
        second = np.diag(body.masses)[1:] / body.mass - centre**2
        reach = np.zeros(3)
        reach[:n] = np.sqrt(3.0 * np.maximum(second, 0.0))
        points = [node.offsets or (0.0,) * n for node in used]
        return RigidOutline(body.name, FORMS[0], places, reach, np.array([centre, *points]))
    form = f"cylinder {shape.axis}" if isinstance(shape, Cylinder) else type(shape).__name__.lower()
    # A rod goes from its origin to its end wherever its centre of mass is.
    middle = shape.centre[:1] if shape.is_line else centre
    return RigidOutline(body.name, form, places, shape.half_extent, middle[None])


def write_solids(group: h5py.Group, solids: list[RigidOutline]) -> None:
    """Write outlines of rigid bodies to a group, in common tables."""
    group.attrs["rigid bodies"] = len(solids)
    if not solids:
        return
    tables = {
        "names": np.array([each.name.encode() for each in solids]),
        "forms": np.array([FORMS.index(each.form) for each in solids], np.int8),
        "sizes": np.array([(len(each.places), len(each.points)) for each in solids], np.int32),
        "reach": np.array([each.reach for each in solids]),
        "places": np.concatenate([each.places for each in solids]),
        "points": np.concatenate([each.points.ravel() for each in solids]),
    }
    for name, table in tables.items():
        group.create_dataset(f"rigid {name}", data=table, **PACKED)


def read_solids(group: h5py.Group) -> list[RigidOutline]:
    """Read outlines of rigid bodies; none from a file of an early version.

    Raises
    ------
    KeyError, ValueError
        If the tables are damaged.
    """
    if not group.attrs.get("rigid bodies", 0):
        return []
    names, forms, sizes, reach, places, points = (
        np.asarray(group[f"rigid {each}"])
        for each in ("names", "forms", "sizes", "reach", "places", "points")
    )
    solids, row, number = [], 0, 0
    for name, form, (n, k), extents in zip(names, forms, sizes, reach, strict=True):
        size = k * (n - 1)
        own = points[number : number + size].reshape(k, n - 1)
        solid = RigidOutline(name.decode(), FORMS[form], places[row : row + n], extents, own)
        solids.append(solid)
        row, number = row + n, number + size
    if (row, number) != (len(places), len(points)):
        raise ValueError("tables of rigid bodies are inconsistent")
    return solids
