"""Deformed shapes are the cubics of the elements."""

import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.geometry.deformed_shape import trace_elements
from ancfsparse.results.geometry.scene_outline import make_part
from ancfsparse.scene import Circle, Material, Scene
from ancfsparse.solve import simulate


def lines_of(run, body, rows, pieces):
    return trace_elements(run.q[rows], make_part(run.system, body), pieces)


def test_an_element_is_the_cubic_through_its_ends(system):
    rod = system.rod
    q = np.array([system.state(0.0), system.state(-2.1, 0.5)])
    run = Trajectory(system, np.zeros(2), q, q, q, np.zeros((2, 0)), RunStats())
    lines = lines_of(run, rod, [0, 1], 4)
    assert lines.shape == (2, 4, 5, 2)
    for e in range(4):
        for k in range(5):
            place = run.position(rod.at((4 * e + k) / 8))
            np.testing.assert_allclose(lines[:, e, k], place, atol=1e-12)


@pytest.fixture(scope="module")
def net():
    """Let a small net fall whose nodes are not in order along its lines."""
    scene = Scene()
    nodes = [(0, 0), (2, 0), (1, 0), (1, 1), (1.5, 2.0)]
    edges = [(0, 2), (1, 2), (2, 3), (4, 3)]
    mesh = scene.add_mesh(nodes, edges, "thin", Circle(0.02), Material(1e6, 1e3), smooth=30.0)
    scene.pin(mesh.node(0))
    return mesh, simulate(scene, 0.2, 1e-2)


def test_edges_of_a_mesh_are_traced_along_their_lines(net):
    mesh, run = net
    assert mesh.flipped.any()
    lines = lines_of(run, mesh, [0, -1], 5)
    lines[:, mesh.flipped] = lines[:, mesh.flipped, ::-1]
    for e in range(4):
        for k in range(6):
            place = run.position(mesh.at(e, mesh.lengths[e] * k / 5))[[0, -1]]
            np.testing.assert_allclose(lines[:, e, k], place, atol=1e-12)


def test_too_many_points_are_refused(net):
    mesh, run = net
    with pytest.raises(InputError, match=r"a plot of these points would need about .* GB"):
        lines_of(run, mesh, [0], 10**15)
