"""Rigid motions that the joints leave free are found and named."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from ancfsparse.system.freedom import free_motions

SECTION, MATERIAL = ancf.Circle(0.02), ancf.Material(1e8, 1000.0)
TRANSLATIONS = [f"translation along {d} of beam 0" for d in "xyz"]
ROTATIONS = [f"rotation about {d} of beam 0" for d in "xyz"]


def beam(dim, element="thin", end=None, n=2):
    scene = ancf.Scene((0.0,) * dim)
    end = np.eye(dim)[0] if end is None else end
    return scene, scene.add_beam(element, (0.0,) * dim, end, n, SECTION, MATERIAL)


def test_a_planar_beam_without_joints():
    scene, _ = beam(2)
    assert sorted(free_motions(System(scene))) == [ROTATIONS[2], *TRANSLATIONS[:2]]


@pytest.mark.parametrize("as_constraint", [False, True])
def test_a_planar_pin_leaves_a_turn(as_constraint):
    for where in (0, 1, 2):
        scene, rod = beam(2)
        scene.pin(rod.node(where), as_constraint=as_constraint)
        assert free_motions(System(scene)) == [ROTATIONS[2]]


@pytest.mark.parametrize("as_constraint", [False, True])
def test_two_planar_pins_leave_nothing(as_constraint):
    scene, rod = beam(2)
    scene.pin(rod.start, as_constraint=as_constraint)
    scene.pin(rod.end, as_constraint=as_constraint)
    assert free_motions(System(scene)) == []


def test_a_spatial_cable_without_joints():
    # Five: a turn about its own axis moves nothing.
    scene, _ = beam(3)
    assert sorted(free_motions(System(scene))) == sorted([*TRANSLATIONS, *ROTATIONS[1:]])


def test_a_thick_beam_has_all_six():
    scene, _ = beam(3, "thick")
    assert sorted(free_motions(System(scene))) == sorted([*TRANSLATIONS, *ROTATIONS])


def test_a_spatial_pin_leaves_turns():
    scene, rod = beam(3)
    scene.pin(rod.start)
    assert sorted(free_motions(System(scene))) == ROTATIONS[1:]


def test_a_thick_beam_between_pins_still_turns_about_its_axis():
    scene, rod = beam(3, "thick")
    scene.pin(rod.start)
    scene.pin(rod.end)
    assert free_motions(System(scene)) == [ROTATIONS[0]]
    scene, rod = beam(3, "thin")
    scene.pin(rod.start)
    scene.pin(rod.end)
    assert free_motions(System(scene)) == []


@pytest.mark.parametrize("stretch", ["free", "fixed"])
@pytest.mark.parametrize("end", [(1, 0), (0, 1), (1, 2), (1, 0, 0), (0, 0, -1), (1, 2, 3)], ids=str)
def test_a_clamp_leaves_nothing(end, stretch):
    scene, rod = beam(len(end), end=end)
    scene.clamp(rod.start, stretch)
    assert free_motions(System(scene)) == []


@pytest.mark.parametrize("end", [(1, 0), (1, 2, 3)], ids=str)
def test_a_thick_clamp_leaves_nothing(end):
    scene, rod = beam(len(end), "thick", end)
    scene.clamp(rod.start)
    assert free_motions(System(scene)) == []


def test_an_oblique_cable_between_pins_is_held():
    # Its own axis is no coordinate axis: the turn about it is a mixture that moves nothing.
    scene, rod = beam(3, end=(1, 2, 3))
    scene.pin(rod.start)
    scene.pin(rod.end)
    assert free_motions(System(scene)) == []


def test_an_oblique_cable_on_a_pin_has_two_turns():
    scene, rod = beam(3, end=(1, 2, 3))
    scene.pin(rod.start)
    assert len(free_motions(System(scene))) == 2


def test_rods_hold_like_their_directions():
    scene, rod = beam(2)
    scene.rod(rod.start, (0, 1))
    assert len(free_motions(System(scene))) == 2
    scene.rod(rod.end, (1, 1))
    assert free_motions(System(scene)) == ["translation along x of beam 0"]
    scene.rod(rod.node(1), (1.5, 0))
    assert free_motions(System(scene)) == []


def test_connected_beams_are_one_body_with_both_names():
    scene, one = beam(2)
    two = scene.add_beam("thin", (1, 0), (1, 1), 2, SECTION, MATERIAL)
    scene.connect(one.end, two.start)
    found = free_motions(System(scene))
    # What moves the first beam takes the second along; the second can also turn by itself.
    assert [each.endswith("of beam 0 and beam 1") for each in found] == [True, True, True, False]
    assert found[3] == "rotation about z of beam 1"


def test_a_hinge_on_a_clamped_beam_is_a_free_motion():
    scene, one = beam(2)
    two = scene.add_beam("thin", (1, 0), (2, 0), 2, SECTION, MATERIAL)
    scene.clamp(one.start)
    scene.connect(one.end, two.start)
    found = free_motions(System(scene))
    assert len(found) == 1
    assert "rotation about z" in found[0]


def test_separate_bodies_are_looked_at_one_by_one():
    scene, one = beam(2)
    scene.add_beam("thin", (0, 1), (1, 1), 2, SECTION, MATERIAL, name="loose")
    scene.clamp(one.start)
    found = free_motions(System(scene))
    assert len(found) == 3
    assert all("loose" in each for each in found)


def test_an_arch_of_two_beams_between_pins_is_held():
    scene = ancf.Scene()
    one = scene.add_beam("thin", (0, 0), (1, 1), 2, SECTION, MATERIAL)
    two = scene.add_beam("thin", (1, 1), (2, 0), 2, SECTION, MATERIAL)
    scene.pin(one.start)
    scene.pin(two.end)
    scene.connect(one.end, two.start)
    assert free_motions(System(scene)) == []
