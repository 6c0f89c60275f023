"""Curves by their arc length, sections along them, and beams that follow them."""

import math
import re

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.integrate import quad

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.scene.geometry.splines import path_of
from ancfsparse.system import System

SECTION, MATERIAL = ancf.Circle(0.02), ancf.Material(1e7, 1e3)


def wave(u):
    return np.column_stack([2.0 * u, 0.3 * np.sin(2.0 * math.pi * u)])


def kinked(u):
    return np.column_stack([u, np.abs(u - 0.37)])


def folded(u):
    return np.column_stack([u, np.abs(u - 0.5)])


def beam(element="thin", dim=2, **options):
    scene = ancf.Scene((0.0, -9.81, 0.0)[:dim])
    return scene.add_beam(
        element, n_elements=options.pop("n_elements", 8), section=SECTION, material=MATERIAL,
        **options,
    )  # fmt: skip


@pytest.mark.parametrize("angle", [math.pi, -0.3, 2.0 * math.pi])
def test_arcs_by_their_arc_length(angle):
    flat = ancf.Arc((1, 2), (1, 5), angle)
    spatial = ancf.Arc((1, 2, 7), (1, 5, 7), angle, axis=(0, 0, 4))
    assert flat.length == pytest.approx(3.0 * abs(angle))
    s = np.linspace(0.0, flat.length, 7)
    r, t = flat.at(s)
    turn = math.pi / 2 + s / 3.0 * np.sign(angle)
    assert_allclose(r, np.array([1, 2]) + 3 * np.column_stack([np.cos(turn), np.sin(turn)]))
    assert_allclose(t, np.sign(angle) * np.column_stack([-np.sin(turn), np.cos(turn)]), atol=1e-15)
    for plane, space in zip((r, t), spatial.at(s), strict=True):
        assert_allclose(space[:, :2], plane, atol=1e-15)


def test_a_helix_has_its_curvature_and_torsion():
    helix = ancf.Helix(0.5, -0.2, 3.0, origin=(1, 0, 0), axis=(0, 2, 0), towards=(0, 1, 1))
    rise = -0.2 / (2.0 * math.pi)
    assert helix.length == pytest.approx(6.0 * math.pi * math.hypot(0.5, rise))
    h = 1e-3
    r, t = helix.at(1.7 + h * np.arange(-2, 3))
    assert_allclose((r[3] - r[1]) / (2 * h), t[2], atol=1e-5)
    bend = (t[3] - t[1]) / (2 * h)
    square = 0.25 + rise**2
    assert np.linalg.norm(bend) == pytest.approx(0.5 / square, rel=1e-5)
    third = (t[3] - 2 * t[2] + t[1]) / h**2
    torsion = np.cross(t[2], bend) @ third / (bend @ bend)
    assert torsion == pytest.approx(rise / square, rel=1e-4)
    assert_allclose(helix.at(np.zeros(1))[0][0], [1, 0, 0.5], atol=1e-15)
    assert_allclose(helix.at(np.array([helix.length]))[0][0], [1, -0.6, 0.5], atol=1e-14)


def test_functions_and_splines_run_by_their_arc_length():
    path = path_of("curve", wave, 2)
    speed = 0.6 * math.pi
    length = quad(lambda u: math.hypot(2.0, speed * math.cos(2 * math.pi * u)), 0, 1, epsabs=1e-13)
    assert path.length == pytest.approx(length[0], rel=1e-13)
    s = np.linspace(0.0, path.length, 9)
    r, t = path.at(s)
    u = r[:, 0] / 2.0
    assert_allclose(r[:, 1], 0.3 * np.sin(2 * math.pi * u), atol=1e-13)
    assert_allclose(np.linalg.norm(t, axis=1), 1.0, rtol=1e-14)
    for end, arc in zip(u[1:], s[1:], strict=True):
        here = quad(lambda u: math.hypot(2.0, speed * math.cos(2 * math.pi * u)), 0, end)
        assert here[0] == pytest.approx(arc, rel=1e-12)
    points = wave(np.linspace(0.0, 1.0, 65))
    assert path_of("curve", points, 2).length == pytest.approx(path.length, rel=1e-6)


def test_points_on_a_line_make_a_line_and_the_same_point_at_both_ends_closes_a_curve():
    path = path_of("curve", [(0, 0), (0.3, 0.4), (3, 4)], 2)
    assert_allclose(path.at(np.array([0.0, 2.5, 5.0]))[0], [(0, 0), (1.5, 2), (3, 4)], atol=1e-14)
    turn = np.linspace(0.0, 2.0 * math.pi, 33)
    ring = path_of("curve", np.column_stack([np.cos(turn), np.sin(turn)]), 2)
    r, t = ring.at(np.array([0.0, ring.length]))
    assert_allclose(r[0], r[1], atol=1e-14)
    assert_allclose(t[0], t[1], atol=1e-12)
    assert ring.length == pytest.approx(2.0 * math.pi, rel=1e-5)


def test_sections_are_carried_along_without_turning():
    rod = beam("thick", 3, curve=ancf.Helix(0.5, 0.4, 2.0), n_elements=64)
    e_x, e_y, e_z = rod.frames.transpose(1, 0, 2)
    squares = rod.frames @ rod.frames.transpose(0, 2, 1)
    assert_allclose(squares, np.tile(np.eye(3), (65, 1, 1)), atol=1e-14)
    assert_allclose(np.cross(e_x, e_y), e_z, atol=1e-14)
    # Against the normal of the helix the section turns back by its torsion.
    normal = -rod.positions * [1, 1, 0] / 0.5
    angle = np.unwrap(
        np.arctan2(np.einsum("ni,ni->n", normal, e_z), np.einsum("ni,ni->n", normal, e_y))
    )
    rise = 0.4 / (2.0 * math.pi)
    torsion = rise / (0.25 + rise**2)
    assert_allclose(angle - angle[0], torsion * rod.arcs, atol=1e-5)


def test_sections_turn_by_a_twist_and_point_where_they_are_told():
    straight = dict(start=(0, 0, 0), end=(2, 0, 0))
    rod = beam("thick", 3, **straight, twist=1.2)
    turn = 0.6 * rod.arcs
    assert_allclose(rod.frames[:, 1, 1], np.cos(turn), atol=1e-14)
    assert_allclose(rod.frames[:, 1, 2], np.sin(turn), atol=1e-14)
    same = beam("thick", 3, **straight, twist=lambda s: 0.6 * s)
    assert_array_equal(same.vectors, rod.vectors)
    leant = beam("thick", 3, **straight, up=lambda s: np.column_stack([s, np.cos(s), np.sin(s)]))
    s = leant.arcs
    assert_allclose(leant.frames[:, 1], np.column_stack([0 * s, np.cos(s), np.sin(s)]), atol=1e-14)
    arc = ancf.Arc((0, 0, 0), (1, 0, 0), 3.0, axis=(0, 0, 1))
    ring = beam("thick", 3, curve=arc, up=(0, 0, 5))
    assert_allclose(ring.frames[:, 1], np.tile([0, 0, 1.0], (9, 1)), atol=1e-15)


def test_nodes_and_points_of_a_curved_beam():
    ring = beam(curve=ancf.Arc((0, 0), (2, 0), math.pi), n_elements=32)
    assert ring.length == pytest.approx(2.0 * math.pi)
    assert ring.at(math.pi).index == 16
    inside = ring.at(1.0)
    assert inside.s == pytest.approx(1.0)
    assert_allclose(inside.position, [2 * math.cos(0.5), 2 * math.sin(0.5)], atol=1e-7)
    assert ring.axes_of(16)[0] == pytest.approx([-1.0, 0.0])
    assert "curved" in ring.describe()["element"]


def test_scenes_with_curves_are_saved_printed_refined_and_changed(tmp_path):
    scene = ancf.Scene((0.0, -9.81, 0.0))
    made = {"section": SECTION, "material": MATERIAL}
    helix = scene.add_beam("thick", curve=ancf.Helix(0.5, 0.4, 2.0), n_elements=12, **made,
                           twist=0.5, name="spring")  # fmt: skip
    scene.add_beam("thin", curve=[(0, 0, 0), (1, 1, 0), (2, 0, 1)], n_elements=4, rest="straight",
                   **made)  # fmt: skip
    scene.add_beam("thin", (0, 0, 1), (1, 0, 1), 6, length=1.5, **made)
    scene.add_beam("thin", (0, 0, 2), (1, 0, 2), 6, tension=10.0, **made)
    scene.clamp(helix.start)
    scene.point_force(helix.at(1.0), (0.0, 0.0, 1.0))
    scene.save(tmp_path / "scene.json")
    again = ancf.Scene.load(tmp_path / "scene.json")
    assert again == scene
    assert again.digest() == scene.digest()
    assert_array_equal(System(again).q_ref, System(scene).q_ref)
    text = str(scene)
    assert "curve Helix(radius=0.5, pitch=0.4, turns=2)" in text
    assert "tension 10 N" in text
    assert "array of shape 3 x 3" in text
    fine = scene.refined(2)
    assert [each.n_elements for each in fine.beams] == [24, 8, 12, 12]
    assert_allclose(fine.beams[0].positions[::2], helix.positions, atol=1e-14)
    assert fine.loads[0].node.s == pytest.approx(1.0)
    wide = scene.replaced(helix, curve=ancf.Helix(0.6, 0.4, 2.0))
    assert wide.body("spring").length > helix.length
    bent = scene.replaced(helix, rest="straight")
    assert bent.digest() != scene.digest()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"curve": ancf.Arc((0, 0), (1, 0), 1.0), "start": (0, 0)}, "leave `start` out"),
        ({"start": (0, 0)}, "has no end: give `start` and `end`, or a `curve`"),
        ({"start": (0, 0), "end": (1, 0), "n_elements": None}, "needs `n_elements`"),
        ({"curve": ancf.Helix(1.0, 1.0, 1.0)}, "has 3 dimensions, but the scene has 2"),
        ({"curve": [(0, 0)]}, "at least two points of 2 finite numbers"),
        ({"curve": [(0, 0), (1, 0), (1, 0), (2, 0)]}, "the same point twice, number 1 and 2"),
        ({"curve": "arc"}, "must be an Arc, a Helix, a table of points or a function"),
        ({"curve": kinked}, "is not smooth near parameter 0.37"),
        ({"curve": folded}, "has a corner at parameter 0.5"),
        ({"curve": lambda u: np.column_stack([u**3, 0 * u])}, "has zero velocity at parameter 0"),
        ({"curve": lambda u: np.zeros((len(u), 2))}, "is a single point"),
        ({"curve": lambda u: (u, u)}, "returned shape (2, 128) for parameters of shape (128,)"),
        ({"curve": lambda u: np.column_stack([u, 0 / (u - u)])}, "must be finite"),
        ({"curve": ancf.Arc((0, 0), (1, 0), 1.0), "rest": "bent"}, "unknown rest of beam 0 'bent'"),
        ({"curve": ancf.Arc((0, 0), (1, 0), 1.0), "length": 2.0}, "so `length` contradicts it"),
        ({"curve": ancf.Arc((0, 0), (1, 0), 1.0), "tension": 2.0}, "so `tension` contradicts it"),
        ({"curve": ancf.Arc((0, 0), (1, 0), 1.0), "element": "l2t2"}, "take 'thin', or rest="),
        ({"start": (0, 0), "end": (1, 0), "twist": 1.0}, "no meaning in a planar scene"),
        ({"start": (0, 0), "end": (1, 0), "length": -1.0}, "must be positive"),
        ({"start": (0, 0), "end": (1, 0), "length": 1.0, "tension": 1.0}, "one follows from the"),
        ({"start": (0, 0), "end": (1, 0), "tension": -1e4}, "must be above -604.6 N"),
        ({"start": (0, 0), "end": (0, 1), "length": 1.5}, "would hang folded"),
        ({"start": (0, 0), "end": (1, 0), "length": 0.1, "element": "thick"}, "to 10 times its"),
    ],
)  # fmt: skip
def test_mistakes_in_the_plane(options, words):
    with pytest.raises(InputError, match=re.escape(words)), np.errstate(all="ignore"):
        beam(**options)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"curve": ancf.Helix(1.0, 1.0, 1.0)}, "take 'thick', or rest='straight'"),
        ({"curve": ancf.Arc((0, 0), (1, 0), 1.0)}, "has 2 dimensions, but the scene has 3"),
        ({"start": (0, 0, 0), "end": (1, 0, 0), "twist": 1.0}, "no torsion and no section"),
        (
            {"element": "thick", "curve": ancf.Arc((0, 0, 0), (1, 0, 0), math.pi, axis=(0, 0, 1)),
             "up": (-1, 0, 0)},
            "is parallel to the beam at s = 1.5708 m",
        ),
        (
            {"element": "thick", "start": (0, 0, 0), "end": (1, 0, 0), "up": lambda s: (0, 1, 0)},
            "must return finite numbers of shape (9, 3)",
        ),
        (
            {"element": "thick", "start": (0, 0, 0), "end": (1, 0, 0), "twist": math.inf},
            "must be finite",
        ),
    ],
)  # fmt: skip
def test_mistakes_in_space(options, words):
    with pytest.raises(InputError, match=re.escape(words)):
        beam(**{"element": "thin", **options}, dim=3)


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: ancf.Arc((0, 0), (0, 0), 1.0), "zero length"),
        (lambda: ancf.Arc((0, 0), (1, 0), 0.0), "zero length"),
        (lambda: ancf.Arc((0, 0, 0), (1, 0, 0), 1.0), "give its axis"),
        (lambda: ancf.Arc((0, 0), (1, 0), 1.0, axis=(0, 0, 1)), "leave the axis out"),
        (lambda: ancf.Arc((0, 0, 0), (1, 0, 1), 1.0, axis=(0, 0, 1)), "lies 1 m outside the plane"),
        (lambda: ancf.Arc((0, 0, 0, 0), (1, 0, 1), 1.0), "2 or 3 finite numbers"),
        (lambda: ancf.Helix(-1.0, 1.0, 1.0), "radius of the helix must be positive"),
        (lambda: ancf.Helix(1.0, 1.0, 1.0, towards=(0, 0, 1)), "is parallel to its axis"),
        (lambda: ancf.Helix(1.0, 1.0, 1.0, axis=(0, 0, 0)), "must be positive"),
    ],
)
def test_mistakes_in_shapes(make, words):
    with pytest.raises(InputError, match=re.escape(words)):
        make()
