"""Rigid motions that the joints leave free are found and named."""

import itertools
import re

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.linearization.rigid_body_modes import MAX_FREE_MOTIONS, free_motions
from ancfsparse.system import System
from tests.beams import build_beam

SECTION, MATERIAL = ancf.Circle(0.02), ancf.Material(1e8, 1000.0)
TRANSLATIONS = [f"translation along {d} of beam 0" for d in "xyz"]
ROTATIONS = [f"rotation about {d} of beam 0" for d in "xyz"]


def beam(dim, element="thin", end=None, n=2):
    scene = ancf.Scene((0.0,) * dim)
    end = np.eye(dim)[0] if end is None else end
    return scene, scene.add_beam(element, (0.0,) * dim, end, n, SECTION, MATERIAL)


def kinds(system):
    """Free motions without the points that their axes go through."""
    return [re.sub(r" through \(.*?\) m", "", name) for name in free_motions(system)]


@pytest.mark.parametrize("as_constraint", [False, True])
def test_a_planar_pin_leaves_a_turn(as_constraint):
    for where in (0, 1, 2):
        scene, rod = beam(2)
        scene.pin(rod.node(where), as_constraint=as_constraint)
        assert kinds(System(scene)) == [ROTATIONS[2]]


@pytest.mark.parametrize(
    ("element", "stretch"), [("thin", "free"), ("thin", "fixed"), ("thick", "free")]
)
@pytest.mark.parametrize("end", [(1, 2), (0, 0, -1), (1, 2, 3)], ids=str)
def test_an_oblique_clamp_leaves_nothing(end, element, stretch):
    scene, rod = beam(len(end), element, end)
    scene.clamp(rod.start, stretch)
    assert kinds(System(scene)) == []


def test_rods_hold_like_their_directions():
    scene, rod = beam(2)
    scene.rod(rod.start, (0, 1))
    assert len(kinds(System(scene))) == 2
    scene.rod(rod.end, (1, 1))
    assert kinds(System(scene)) == ["translation along x of beam 0"]
    scene.rod(rod.node(1), (1.5, 0))
    assert kinds(System(scene)) == []


def test_connected_beams_are_one_body_with_both_names():
    scene, one = beam(2)
    two = scene.add_beam("thin", (1, 0), (1, 1), 2, SECTION, MATERIAL)
    scene.connect(one.end, two.start)
    found = kinds(System(scene))
    # What moves the first beam takes the second along; the second can also turn by itself.
    assert [each.endswith("of beam 0 and beam 1") for each in found] == [True, True, True, False]
    assert found[3] == "rotation about z of beam 1"


def test_separate_bodies_are_looked_at_one_by_one():
    scene, one = beam(2)
    scene.add_beam("thin", (0, 1), (1, 1), 2, SECTION, MATERIAL, name="loose")
    scene.clamp(one.start)
    found = kinds(System(scene))
    assert len(found) == 3
    assert all("loose" in each for each in found)


# The verdict does not depend on the unit of length.

SIZES = [1e-9, 1.0, 1e9]
# Without joints, and with a pin; a turn of a cable about its own axis moves nothing.
FREE = {
    (2, "thin"): ([*TRANSLATIONS[:2], ROTATIONS[2]], [ROTATIONS[2]]),
    (2, "thick"): ([*TRANSLATIONS[:2], ROTATIONS[2]], [ROTATIONS[2]]),
    (3, "thin"): ([*TRANSLATIONS, *ROTATIONS[1:]], ROTATIONS[1:]),
    (3, "thick"): ([*TRANSLATIONS, *ROTATIONS], ROTATIONS),
}


def sized(dim, element, size, *holds):
    end, section = np.eye(dim)[0], ancf.Circle(0.02 * size)
    options = {"gravity": 0 * end}
    return build_beam(element, 0 * end, size * end, 3, section, MATERIAL, *holds, **options)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize(("dim", "element"), FREE)
def test_what_is_free_does_not_depend_on_the_size(dim, element, size):
    for holds, expected in zip(((), ("pin",)), FREE[dim, element], strict=True):
        scene, _ = sized(dim, element, size, *holds)
        assert sorted(kinds(System(scene))) == sorted(expected)
    scene, _ = sized(dim, element, size, "pin", "pin")
    assert kinds(System(scene)) == (ROTATIONS[:1] if (dim, element) == (3, "thick") else [])
    scene, _ = sized(dim, element, size, "clamp")
    assert kinds(System(scene)) == []


@pytest.mark.parametrize("as_constraint", [False, True])
@pytest.mark.parametrize("small", [1e-9, 1e-6, 1e-3])
def test_small_parts_on_large_ones_are_judged_by_their_own_size(small, as_constraint):
    scene, rod = sized(2, "thin", 1.0, "clamp")
    ends = (1.0, 0.0), (1.0, small)
    fine = scene.add_beam("thin", *ends, 2, ancf.Circle(0.02 * small), MATERIAL, name="hair")
    scene.connect(rod.end, fine.start)
    free = free_motions(System(scene))
    assert free == ["rotation about z through (1, 0) m of hair"]
    scene.pin(fine.end, as_constraint=as_constraint)
    assert free_motions(System(scene)) == []


@pytest.mark.parametrize("far", [1.0, 1e3, 1e6])
def test_what_is_free_does_not_depend_on_the_place(far):
    scene = ancf.Scene((0.0, 0.0, 0.0))
    at = np.array([far, -2.0 * far, 0.5 * far])
    rod = scene.add_beam("thin", at, at + np.array([1.0, 2.0, 3.0]), 4, SECTION, MATERIAL)
    scene.pin(rod.start)
    assert len(free_motions(System(scene))) == 2
    scene.pin(rod.end)
    assert free_motions(System(scene)) == []


@pytest.mark.parametrize("size", SIZES)
def test_a_group_that_is_held_only_together_is_held_at_any_size(size):
    # An arch of two cables: neither is held without the other.
    scene = ancf.Scene()
    section = ancf.Circle(0.02 * size)
    one = scene.add_beam("thin", (0, 0), (size, size), 2, section, MATERIAL)
    two = scene.add_beam("thin", (size, size), (2 * size, 0), 2, section, MATERIAL)
    scene.pin(one.start)
    scene.pin(two.end)
    scene.connect(one.end, two.start)
    assert free_motions(System(scene)) == []


def links(n, *, sag=0.0, hold_end=True):
    """A chain of n hinged cables between two pins."""
    scene = ancf.Scene()
    x = np.linspace(0.0, float(n), n + 1)
    y = -sag * np.sin(np.pi * x / n)
    cables = [
        scene.add_beam("thin", (x[k], y[k]), (x[k + 1], y[k + 1]), 1, SECTION, MATERIAL)
        for k in range(n)
    ]
    scene.pin(cables[0].start)
    if hold_end:
        scene.pin(cables[-1].end)
    for a, b in itertools.pairwise(cables):
        scene.connect(a.end, b.start)
    return scene


@pytest.mark.parametrize("n", [3, 10, 20])
def test_free_motions_of_a_chain_are_counted(n):
    # 3 n modes, less 2 for each of n - 1 hinges and 4 at the pins.
    assert len(free_motions(System(links(n, sag=1.0)))) == n - 2
    assert len(free_motions(System(links(n, sag=1.0, hold_end=False)))) == n


def test_a_long_chain_is_named_in_part():
    free = free_motions(System(links(300, sag=10.0)))
    assert len(free) == MAX_FREE_MOTIONS
    assert all(name.startswith("rotation about z") for name in free)


def test_a_long_held_truss_is_held():
    # Triangles of hinged bars along 60 bays: soft, not loose; each bar is held by others only.
    scene = ancf.Scene()
    low, high = ([(float(k), y) for k in range(61)] for y in (0.0, 1.0))
    nodes = np.array(low + high)
    edges = [*((k, k + 1) for k in range(60)), *((61 + k, 62 + k) for k in range(60))]
    edges += [*((k, 61 + k) for k in range(61)), *((k, 62 + k) for k in range(60))]
    mesh = scene.add_mesh(nodes, edges, "thin", SECTION, MATERIAL, smooth=0)
    scene.pin(mesh.node(0))
    assert len(free_motions(System(scene))) == 1
    scene.pin(mesh.node(61))
    assert free_motions(System(scene)) == []


def test_the_axis_of_a_free_turn_is_the_real_one():
    # A helix clamped at one end turns about its tangent there: a thin cable has no torsion.
    t = np.linspace(0, 2 * np.pi, 41)
    scene = ancf.Scene((0, 0, 0))
    edges = np.stack([np.arange(40), np.arange(1, 41)], 1)
    nodes = np.stack([np.cos(t), np.sin(t), 0.3 * t], 1)
    mesh = scene.add_mesh(nodes, edges, "thin", SECTION, MATERIAL, smooth=15)
    scene.clamp(mesh.node(0))
    (name,) = free_motions(System(scene))
    found = re.fullmatch(r"rotation about \((.*)\) through \((.*)\) m of mesh 0", name)
    axis, point = (np.array([float(x) for x in each.split(",")]) for each in found.groups())
    tangent = mesh.vectors[0, 0]
    np.testing.assert_allclose(axis, tangent, atol=1e-3)
    # The point is the one of the axis that is nearest to the start of the helix: the start itself.
    np.testing.assert_allclose(point, nodes[0], atol=1e-3)
