"""A contact of a pair of sides that has one already, also if an obstacle is described otherwise."""

import math

import numpy as np
import pytest

import ancfsparse as ancf

SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(1e8, 5e3)
FLOOR = ancf.HalfSpace((0.0, 0.0), (0.0, 1.0))
CORNERS = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
SIDES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
])  # fmt: skip
PLANE_PAIRS = [
    (FLOOR, FLOOR),
    (FLOOR, ancf.HalfSpace((0.0, 0.0), (0.0, 1.0))),
    (FLOOR, ancf.HalfSpace((-3.7, 0.0), (0.0, 0.3))),
    (ancf.HalfSpace((0.3, -0.4), (3.0, 4.0)), ancf.HalfSpace((-3.7, 2.6), (0.6, 0.8))),
    (ancf.Ball((0.5, -0.3), 0.2), ancf.Drum((0.5, -0.3), 0.2, angular_velocity=1.0)),
    (
        ancf.Capsule((0.1, -0.3), (0.7, -0.4), 0.1),
        ancf.Capsule((0.7, -0.4), (0.1, -0.3), 0.1),
    ),
    (
        ancf.Block((0.5, -0.3), (0.4, 0.2), 0.05, 0.1),
        ancf.Block((0.5, -0.3), (0.2, 0.4), 0.05, 0.1 - 0.5 * math.pi),
    ),
    (ancf.Block((0.5, -0.3), (0.4, 0.2), 0.1), ancf.Capsule((0.4, -0.3), (0.6, -0.3), 0.1)),
    (
        ancf.HeightField((0, -0.5), [0.1, 0.2, 0.1], 0.4),
        ancf.HeightField((0, -0.4), [0, 0.1, 0], 0.4),
    ),
]
AXIS = np.array((1.0, -2.0, 3.0))
SPATIAL_PAIRS = [
    (ancf.HalfSpace((0, 0, -1), (1, 2, 9)), ancf.HalfSpace((-9, 0, 0), (0.5, 1, 4.5))),
    (
        ancf.Drum((0.5, 0.5, -2), 0.3, tuple(AXIS)),
        ancf.Drum(tuple((0.5, 0.5, -2) + 0.7 * AXIS), 0.3, tuple(-0.1 * AXIS)),
    ),
    (
        ancf.Torus((0.5, 0, -1), 0.3, 0.1, tuple(AXIS)),
        ancf.Torus((0.5, 0, -1), 0.3, 0.1, tuple(-3.0 * AXIS)),
    ),
    (
        ancf.Block((0.5, 0, -1), (0.4, 0.6, 0.8), orientation=(1, 0, 0, 0)),
        ancf.Block((0.5, 0, -1), (0.4, 0.8, 0.6), orientation=(math.sqrt(0.5),) * 2 + (0, 0)),
    ),
    (
        ancf.TriangleMesh((0, 0, -2), CORNERS, SIDES, 0.1),
        ancf.TriangleMesh((1.1, 0.3, -2), CORNERS - (1.1, 0.3, 0), SIDES[::-1], 0.1),
    ),
]


def line(dim, height=0.02):
    """Return a scene with one cable along x, above z = 0 or y = 0."""
    scene = ancf.Scene((*(0.0,) * (dim - 1), -9.81))
    start, end = np.zeros(dim), np.eye(dim)[0]
    start[-1] = end[-1] = height
    return scene, scene.add_beam("thin", start, end, 10, SECTION, MATERIAL)


@pytest.mark.parametrize(("one", "same"), [*PLANE_PAIRS, *SPATIAL_PAIRS])
def test_the_same_pair_twice(one, same):
    """Also if the same points are described by other arguments."""
    for first, again in ((one, same), (same, one)):
        scene, rod = line(first.dim)
        scene.contact(rod, first)
        with pytest.raises(ancf.InputError, match="added before: leave one of them out"):
            scene.contact(rod, again, friction=0.1)
        pulley = scene.add_body(
            mass=1.0, inertia=1.0 if first.dim == 2 else np.eye(3), position=first.base
        )
        if not again.spin.any():
            scene.contact(rod, again, on=pulley)  # it moves, the other one does not


@pytest.mark.parametrize(
    ("one", "other"),
    [
        (FLOOR, ancf.HalfSpace((0.0, 1.0), (0.0, -1.0))),
        (FLOOR, ancf.HalfSpace((0.0, -1e-6), (0.0, 1.0))),
        (FLOOR, ancf.HalfSpace((0.0, 0.0), (1e-6, 1.0))),
        (FLOOR, ancf.Block((0.5, -1.0), (4.0, 2.0))),
        (ancf.Ball((0.5, -0.3), 0.2), ancf.Ball((0.5, -0.3), 0.21)),
        (ancf.Ball((0.5, -0.3), 0.2), ancf.Torus((0.5, -0.3), 0.15, 0.05)),
        (ancf.Ball((0.5, -0.3), 0.2), ancf.Block((0.5, -0.3), (0.4, 0.4))),
        (ancf.Block((0.5, -0.3), (0.4, 0.2)), ancf.Block((0.5, -0.3), (0.4, 0.2), 0.05)),
        (ancf.Block((0.5, -0.6), (0.4, 0.4)), ancf.Block((0.5, -0.6), (0.4, 0.4), 0.0, 0.5)),
        (ancf.Capsule((0, -0.3), (1, -0.3), 0.1), ancf.Capsule((0, -0.3), (1.1, -0.3), 0.1)),
        (ancf.Drum((0, 0, -1), 0.3, (0, 1, 0)), ancf.Drum((0, 0, -1), 0.3, (0, 1, 1e-6))),
        (ancf.Drum((0, 0, -1), 0.3, (0, 1, 0)), ancf.Ball((0, 0, -1), 0.3)),
        (
            ancf.Torus((0.5, 0, -1), 0.3, 0.1, (0, 0, 1)),
            ancf.Torus((0.5, 0, -1), 0.3, 0.1, (0, 1e-6, 1)),
        ),
        (
            ancf.HeightField((0, -0.5), [0.1, 0.2, 0.1], 0.4),
            ancf.HeightField((0, -0.5), [0.1, 0.21, 0.1], 0.4),
        ),
    ],
)
def test_other_obstacles_are_other_pairs(one, other):
    scene, rod = line(one.dim)
    scene.contact(rod, one)
    scene.contact(rod, other)
