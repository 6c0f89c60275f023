"""Distances between two motions at many times."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.stepping.sampled_states import (
    MAX_STEPS_AT_ONCE,
    distances,
    nodal_differences,
)
from ancfsparse.system import System

TIMES = 2 * MAX_STEPS_AT_ONCE + 7


@pytest.fixture
def motions():
    """A system of a beam and a body, and the coordinates of two motions that differ."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    section, material = ancf.Rectangle(1e-3, 1e-3), ancf.Material(1e6, 1000.0, 0.3)
    scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 2, section, material)
    scene.add_body(ancf.Box(length=0.4, width=0.1, height=0.2), mass=1.0, position=(0, 1, 0))
    rng = np.random.default_rng(5)
    system = System(scene)
    return system, *rng.normal(size=(2, TIMES, system.n_all))


def test_distances_are_those_of_single_states(motions):
    system, one, other = motions
    beam, body = system.scene.bodies
    nodes = [system.rows(beam.node(k))[0][:3] for k in range(3)]
    rows = system.rows(body.node(0))[0]
    expected = []
    for difference in one - other:
        origin, *axes = difference[rows].reshape(4, 3)
        ends = [origin + sign * body.size * axis for axis in axes for sign in (-1.0, 1.0)]
        points = [difference[node] for node in nodes] + [origin, *ends]
        expected.append(max(np.linalg.norm(point) for point in points))
    np.testing.assert_allclose(distances(system, one, other), expected, rtol=1e-14)


def test_differences_are_formed_for_many_states_at_once(motions):
    tables = list(nodal_differences(*motions))
    assert [len(table) for table in tables] == [MAX_STEPS_AT_ONCE, MAX_STEPS_AT_ONCE, 7]
