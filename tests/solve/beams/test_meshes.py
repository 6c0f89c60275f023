"""Meshes move and rest as the beams that could stand in their place."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import SingularSceneError
from ancfsparse.system import System
from tests.grids import level_grid
from tests.solve.refusals import assert_refused

SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(1e8, 4000.0)


def spin(x):
    return 3.0 * np.stack([-x[:, 1], x[:, 0], *(0.0 * x[:, 2:].T)], axis=1)


@pytest.mark.parametrize(
    ("element", "dim", "strain"),
    [("l2t2", 2, None), ("thin", 2, "green"), ("thin", 2, "biot"), ("thin", 3, "green")],
)
def test_a_chain_as_a_mesh_moves_as_the_beam(element, dim, strain):
    gravity, zero = (0.0, -9.81, 0.0)[:dim], (0.0,) * (dim - 2)
    runs = []
    options = {"velocity": spin, "strain": strain}
    for mesh in (False, True):
        scene = ancf.Scene(gravity)
        if mesh:
            edges = np.stack([np.arange(10), np.arange(1, 11)], axis=1)
            nodes = runs[0][1].positions
            body = scene.add_mesh(nodes, edges, element, SECTION, MATERIAL, **options)
            inside = body.at(3, 0.05)
        else:
            ends = (0, 0, *zero), (2, 0, *zero)
            body = scene.add_beam(element, *ends, 10, SECTION, MATERIAL, **options)
            inside = body.at(0.65)
        scene.pin(body.node(0))
        scene.point_force(body.node(7), (0.0, 1.0, *zero))
        scene.distributed_force(body, (0.1, 0.0, *zero))
        run = ancf.simulate(scene, 0.1, 5e-4)
        runs.append((run, body, inside))
    (one, rod, inside), (two, mesh, edge) = runs
    np.testing.assert_allclose(two.q, one.q, rtol=0, atol=1e-13)
    np.testing.assert_allclose(two.position(edge), one.position(inside), rtol=0, atol=1e-13)
    np.testing.assert_allclose(two.slope(edge), one.slope(inside), rtol=0, atol=1e-12)
    reactions = [run.reaction(body.node(0)) for run, body in ((one, rod), (two, mesh))]
    np.testing.assert_allclose(*reactions, rtol=1e-8, atol=1e-8)


def net(n, dim):
    """Give nodes and shuffled edges of a square net of n x n nodes and 1 m."""
    nodes, edges, _ = level_grid(n)
    rng = np.random.default_rng(1)
    edges = rng.permutation(edges)
    turned = rng.random(len(edges)) < 0.5
    edges[turned] = edges[turned, ::-1]
    return nodes[:, :dim], edges


@pytest.mark.parametrize("dim", [2, 3])
def test_a_net_as_a_mesh_moves_as_crossing_cables(dim):
    n, gravity = 5, (0.0, -9.81) if dim == 2 else (0.0, 0.0, -9.81)
    place = np.linspace(0, 1, n)
    one, two = ancf.Scene(gravity), ancf.Scene(gravity)
    mesh = one.add_mesh(*net(n, dim), "thin", SECTION, MATERIAL)
    zero = (0.0,) * (dim - 2)
    along = [
        two.add_beam("thin", (0, y, *zero), (1, y, *zero), n - 1, SECTION, MATERIAL) for y in place
    ]
    across = [
        two.add_beam("thin", (x, 0, *zero), (x, 1, *zero), n - 1, SECTION, MATERIAL) for x in place
    ]
    for i in range(n):
        for j in range(n):
            two.connect(along[j].node(i), across[i].node(j))
    for i, j in ((0, 0), (0, n - 1), (n - 1, n - 1)):
        one.pin(mesh.node(i * n + j))
        two.pin(along[j].node(i))
    assert System(one).n_free == System(two).n_free
    assert System(one).n_multipliers == 0
    a, b = (ancf.simulate(scene, 0.1, 1e-3, tolerance=1e-10) for scene in (one, two))
    for i in range(n):
        for j in range(n):
            np.testing.assert_allclose(
                a.position(mesh.node(i * n + j)),
                b.position(along[j].node(i)),
                rtol=0,
                atol=1e-12,
            )
    assert a.energy.total[-1] == pytest.approx(b.energy.total[-1], rel=1e-9)


def test_edges_that_meet_at_a_corner_are_hinged():
    # A hanging L: the free leg swings down although its hinge's other leg is clamped.
    scene = ancf.Scene()
    mesh = scene.add_mesh([(0, 0), (1, 0), (2, 1)], [(0, 1), (1, 2)], "thin", SECTION, MATERIAL)
    scene.clamp(mesh.node(0))
    scene.pin(mesh.node(1))
    run = ancf.simulate(scene, 0.2, 1e-3)
    leg = run.position(mesh.node(2)) - [1, 0]
    np.testing.assert_allclose(np.linalg.norm(leg, axis=1), np.sqrt(2), rtol=1e-2)
    assert leg[-1, 1] < 0.9


def test_a_clamp_holds_every_slope_at_a_node():
    scene = ancf.Scene()
    nodes = [(0, 0), (1, 0), (0, 1), (-1, -1)]
    mesh = scene.add_mesh(nodes, [(0, 1), (0, 2), (0, 3)], "thin", SECTION, MATERIAL)
    scene.clamp(mesh.node(0))
    with pytest.warns(
        ancf.UnstableEquilibriumWarning
    ):  # the leg that stands is beyond its buckling load
        rest = ancf.solve_static(scene, load_steps=20)
    for edge in range(3):
        near = mesh.at(edge, 1e-5)
        direction = rest.slope(near) / np.linalg.norm(rest.slope(near))
        np.testing.assert_allclose(direction, mesh.vectors[mesh.ends[edge, 0], 0], atol=1e-3)


def test_a_slope_at_a_crossing_must_say_of_which_line():
    scene = ancf.Scene()
    mesh = scene.add_mesh(*net(3, 2), "thin", SECTION, MATERIAL)
    run = ancf.simulate(scene, 1e-3, 1e-3)
    assert_refused("node 4 has 2 slopes, one for each line", run.slope, mesh.node(4))
    scene.point_moment(mesh.node(4), 1.0)
    assert_refused("has 2 slopes", ancf.simulate, scene, 1e-3, 1e-3)


@pytest.mark.parametrize("legs", [1, 210])
def test_a_floating_part_is_named_in_statics(legs):
    # Fans of hinged legs: with 210 of them the mesh is looked at by connected part, not by line.
    angle = np.linspace(0.2, 2.0, legs)
    fan = np.stack([np.cos(angle), -np.sin(angle)], 1)
    nodes = np.vstack([[[0.0, 0.0]], fan, [[10.0, 0.0], [11.0, 0.0]]])
    edges = [*((0, k) for k in range(1, legs + 1)), (legs + 1, legs + 2)]
    scene = ancf.Scene()
    mesh = scene.add_mesh(nodes, edges, "thin", SECTION, MATERIAL, name="fans")
    for k in range(legs + 1):
        scene.pin(mesh.node(k))
    floating = rf"3 rigid motions are free, .* of fans \(nodes {legs + 1} to {legs + 2}\)"
    assert_refused(floating, ancf.solve_static, scene, error=SingularSceneError)
