"""Copies of a scene: finer, changed, and compared."""

import copy
import itertools
import pickle

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import lattice
from ancfsparse.system import System
from tests.scene.everything import everything

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


def bar(n=4):
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (2, 0), n, SECTION, MATERIAL)
    scene.clamp(rod.start)
    scene.point_force(rod.at(1.3), (0.0, -1.0))
    return scene, rod


def same_system(one, other):
    one, other = System(one), System(other)
    for name in ("q_ref", "q0", "v0"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
    v = np.random.default_rng(1).normal(size=one.n_all)
    q = one.q_ref + 1e-3 * v
    q, v, t = q[None], v[None], np.array([0.3])
    np.testing.assert_array_equal(one.energies(q, v), other.energies(q, v))
    np.testing.assert_allclose(one.power(q, v, t), other.power(q, v, t), rtol=1e-14)


@pytest.mark.parametrize("factor", [2, 4])
def test_a_refined_scene_is_the_one_made_by_hand(factor):
    refined, made = everything().refined(factor), everything(factor)
    assert refined == made
    assert refined.digest() == made.digest()
    same_system(refined, made)


def test_refinement_by_three_moves_nothing():
    scene = everything()
    fine = scene.refined(3)
    assert fine.beams[0].n_elements == 12
    points = [
        point
        for body in scene.beams[:2]
        for point in (body.start, body.node(2), body.end, body.at(0.2), body.at(0.9))
    ] + [scene.beams[2].node(3), scene.beams[2].at(1, 0.1), scene.beams[2].at(2, 0.9)]
    for point in points:
        twin = fine.counterpart(point)
        assert twin.beam is fine.body(point.beam.name)
        np.testing.assert_allclose(twin.position, point.position, rtol=0, atol=1e-14)
        assert twin.is_node or not point.is_node
    for before, after in zip(scene.loads[:2], fine.loads[:2], strict=True):
        np.testing.assert_allclose(after.node.position, before.node.position, atol=1e-14)


@pytest.mark.parametrize("steps", [(2, 3), (3, 2), (2, 2)])
def test_refining_twice_is_refining_once_by_the_product(steps):
    scene = everything()
    once, twice = scene.refined(steps[0] * steps[1]), scene.refined(steps[0]).refined(steps[1])
    same_system(once, twice)
    points = [record.node for record in once.records if hasattr(record, "node")]
    others = [record.node for record in twice.records if hasattr(record, "node")]
    for one, other in zip(points, others, strict=True):
        assert (one.body, one.index) == (other.body, other.index)
        assert one.xi == pytest.approx(other.xi, abs=1e-14)


@pytest.mark.parametrize("smooth", [0.0, 5.0, 90.0])
def test_edges_of_several_elements_are_those_divided_by_hand(smooth):
    nodes = np.array([(0, 0), (1, 0), (2, 0.05), (1, 1), (1, -1), (2, 1)], dtype=float)
    edges = np.array([(0, 1), (2, 1), (1, 3), (4, 1), (3, 5)])
    scene = ancf.Scene()
    mesh = scene.add_mesh(
        nodes, edges, "thin", SECTION, MATERIAL, n_elements=3, smooth=smooth
    )  # fmt: skip
    # By hand: the nodes inside follow, edge by edge.
    inside = [
        nodes[a] + (nodes[b] - nodes[a]) * share for a, b in edges for share in (1 / 3, 2 / 3)
    ]
    pairs = []
    for k, (a, b) in enumerate(edges):
        chain = [a, 6 + 2 * k, 7 + 2 * k, b]
        pairs += itertools.pairwise(chain)
    plain = ancf.Scene().add_mesh(
        np.vstack([nodes, inside]), pairs, "thin", SECTION, MATERIAL, smooth=max(smooth, 0.01)
    )  # fmt: skip
    np.testing.assert_allclose(mesh.positions, plain.positions, atol=1e-15)
    np.testing.assert_allclose(mesh.lengths, plain.lengths, rtol=1e-14)
    coarse = ancf.Scene().add_mesh(nodes, edges, "thin", SECTION, MATERIAL, smooth=smooth)
    assert mesh.n_lines == coarse.n_lines
    assert len(mesh.row_nodes) == len(coarse.row_nodes) + 10
    for k, point in enumerate(mesh.at(edge, share) for edge in range(5) for share in (0.1, 0.7)):
        tail, head = nodes[edges[k // 2]]
        along = (head - tail) / np.linalg.norm(head - tail)
        np.testing.assert_allclose(point.position, tail + along * (0.1, 0.7)[k % 2], atol=1e-14)
        assert point.s == pytest.approx((0.1, 0.7)[k % 2], abs=1e-14)
    if smooth > 0.0:  # at zero no edges of the one divided by hand continue each other
        np.testing.assert_array_equal(mesh.edges, plain.edges)
        np.testing.assert_allclose(mesh.vectors, plain.vectors, atol=1e-14)
        np.testing.assert_array_equal(mesh.row_nodes, plain.row_nodes)


def test_a_refined_net_has_the_same_lines_and_weight():
    scene = lattice(3).scene
    fine = scene.refined(2)
    coarse, finer = scene.beams[-1], fine.beams[-1]
    assert finer.n_elements == 2 * coarse.n_elements
    assert finer.n_lines == coarse.n_lines
    potentials = []
    for system in (System(scene), System(fine)):
        still = np.zeros((1, system.n_all))
        potentials.append(system.energies(system.q_ref[None], still)[2][0])
    assert potentials[0] == pytest.approx(potentials[1], rel=1e-12)


def test_a_refined_static_shape_converges_at_the_order_of_the_element():
    # Cubics whose energy has second derivatives: 2 (4 - 2).
    scene = ancf.Scene((0.0, 0.0))
    section, material = ancf.Rectangle(0.2, 0.2), ancf.Material(1e9, 4000.0)
    rod = scene.add_beam("l2t2", (0, 0), (2, 0), 2, section, material)
    scene.clamp(rod.start)
    scene.point_moment(rod.end, 1e4)
    scene.point_force(rod.end, (5e3, 1e4))
    tips = []
    for _ in range(6):
        tips.append(ancf.solve_static(scene).position(scene.counterpart(rod.end)))
        scene = scene.refined()
    changes = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    assert np.log2(changes[-2] / changes[-1]) == pytest.approx(4.0, abs=0.3)


def test_a_replaced_argument_is_the_only_one():
    scene, rod = bar()
    stiff = ancf.Material(2e8, 4000.0)
    other = scene.replaced(rod, material=stiff)
    assert scene != other
    assert other.replaced(other.beams[0], material=MATERIAL) == scene
    assert (other.beams[0].material, scene.beams[0].material) == (stiff, MATERIAL)
    assert scene.replaced(scene.loads[0], value=(0.0, -2.0)).loads[0].at(0.0)[1] == -2.0
    assert scene.replaced(scene.loads[0], node=rod.end).loads[0].node.s == 2.0
    assert scene.replaced(gravity=(0.0, -1.62)).gravity[1] == -1.62
    assert scene == bar()[0]


def test_points_stay_where_they_are_if_a_beam_is_replaced():
    scene, rod = bar()
    other = scene.replaced(rod, n_elements=7, name="arm")
    assert [record.node.body for record in other.records[1:]] == ["arm", "arm"]
    assert other.loads[0].node.s == pytest.approx(1.3, abs=1e-15)


def test_what_cannot_be_replaced_is_named():
    scene, rod = bar()
    stranger = bar()[1]
    with pytest.raises(ancf.InputError, match="a handle that a method of this scene"):
        scene.replaced(stranger, n_elements=3)
    with pytest.raises(ancf.InputError, match="unknown argument of add_beam 'n_element': did you"):
        scene.replaced(rod, n_element=3)
    with pytest.raises(ancf.InputError, match="'value' but no handle: give the beam, joint"):
        scene.replaced(value=3)
    with pytest.raises(ancf.InputError, match="n_elements of beam 0 must be"):
        scene.replaced(rod, n_elements="many")
    with pytest.raises(ancf.InputError, match="beam 0 at s = 2 m of another scene"):
        scene.replaced(scene.loads[0], node=stranger.end)
    moved = scene.replaced(scene.joints[0], node=rod.node(1))
    with pytest.raises(ancf.InputError, match="a clamp needs a node, but beam 0 at s = "):
        moved.replaced(moved.beams[0], n_elements=3)
    with pytest.raises(ancf.InputError, match="factor of refined must be"):
        scene.refined(0)
    with pytest.raises(ancf.InputError, match="the scene has no body 'rod': valid are 'beam 0'"):
        scene.counterpart(scene.replaced(rod, name="rod").beams[0])
    other = ancf.Scene()
    other.add_mesh([(0, 0), (1, 0)], [(0, 1)], "thin", SECTION, MATERIAL, name=rod.name)
    with pytest.raises(ancf.InputError, match="beam 0 of this scene is not a Beam"):
        other.counterpart(rod.end)
    with pytest.raises(ancf.InputError, match="counterpart needs a beam, a mesh or a point on one"):
        scene.counterpart(3)


def test_scenes_are_equal_if_what_was_specified_is():
    assert everything() == everything()
    assert everything() != everything(2)
    assert bar()[0] != ancf.Scene()
    assert ancf.Scene() != ancf.Scene((0.0, 0.0))
    assert ancf.Scene() != ancf.Scene((0.0, -9.81, 0.0))
    assert ancf.Scene() != "a scene"
    with pytest.raises(TypeError, match="unhashable"):
        hash(ancf.Scene())


@pytest.mark.parametrize("again", [copy.deepcopy, lambda scene: pickle.loads(pickle.dumps(scene))])
def test_copies_in_memory_and_through_pickle_are_equal(again):
    scene = everything()
    twin = again(scene)
    assert twin == scene
    same_system(twin, scene)
    rod = twin.beams[0]
    twin.point_force(rod.end, (0.0, 0.0, 1.0))  # handles belong to the copy
    assert twin != scene
    assert twin.replaced(rod, n_elements=8).beams[0].n_elements == 8


def test_a_scene_is_printed_line_by_line():
    scene, rod = bar()
    scene.add_mass(rod.end, 0.5)
    scene.point_force(rod.end, lambda t: (t, 0.0))
    assert str(scene).splitlines() == [
        "planar scene, gravity (0, -9.81) m/s2",
        "beam: element thin, start (0, 0) m, end (2, 0) m, n_elements 4, "
        "section Rectangle(width=0.01, height=0.01), "
        "material Material(youngs_modulus=1e+08, density=4000), name beam 0",
        "clamp: node beam 0 at s = 0 m",
        "point force: node beam 0 at s = 1.3 m, value (0, -1) N",
        "mass: node beam 0 at s = 2 m, mass 0.5 kg",
        "point force: node beam 0 at s = 2 m, value function "
        "test_a_scene_is_printed_line_by_line.<locals>.<lambda>",
    ]
    assert len(str(everything()).splitlines()) == 1 + len(everything().records)


def test_axes_and_numbers_of_single_precision_are_kept_by_copies(tmp_path):
    rng, scene = np.random.default_rng(26), ancf.Scene((0.0, 0.0, -9.81))
    for axis in rng.standard_normal((30, 3)):
        body = scene.add_body(
            ancf.Sphere(0.1), mass=np.float32(0.1), position=(0, 0, 0),
            orientation=np.array([1.0, 0.0, 0.0, 0.0], dtype=np.float32),
        )  # fmt: skip
        scene.revolute(body.origin, axis=axis)
    scene.add_body(
        ancf.Box(length=1, width=1, height=1), density=np.float32(0.1), position=(0, 0, 0)
    )
    ends, section = ((0, 0, 1), (1, 0, 1)), ancf.Circle(0.01)
    scene.add_beam("thick", *ends, 1, section, ancf.Material(1e8, 1e3), length=np.float32(1.1))
    scene.save(tmp_path / "scene.json")
    for other in (scene.refined(1), ancf.Scene.load(tmp_path / "scene.json")):
        assert other == scene
        assert [body.mass for body in other.bodies[:-1]] == [
            body.mass for body in scene.bodies[:-1]
        ]
        assert other.beams[0].lengths == scene.beams[0].lengths


def test_a_large_axis_is_a_direction():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    body = scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(0, 0, 0))
    axis = scene.revolute(body.origin, axis=(0, 1e308, 1e308)).axes[0]
    np.testing.assert_allclose(axis, (0.0, np.sqrt(0.5), np.sqrt(0.5)), rtol=1e-15)


def test_a_shallow_copy_is_a_scene_of_its_own():
    scene, rod = bar()
    other = copy.copy(scene)
    assert other == scene
    other.pin(other.counterpart(rod.end))
    assert len(scene.joints) == len(scene.records) - 2 == 1


def test_gravity_is_changed_in_copies_alone():
    scene, _ = bar()
    with pytest.raises(AttributeError):
        scene.gravity = (0.0, -1.62)
