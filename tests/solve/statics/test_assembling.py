"""Assembly: mechanisms and lines out of place are put where their joints and drives hold."""

import math
from dataclasses import replace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import AssemblyError, InputError
from tests.beams import build_beam

SOFT = ancf.Material(1e7, 1000.0)


def four_bar(gap):
    """A four-bar linkage of rigid rods whose coupler does not reach the rocker by a gap."""
    scene = ancf.Scene((0.0, -9.81))
    crank = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0), orientation=math.pi / 2)
    b = np.array([1.6623437256, 2.1120311767])
    turn = math.atan2(b[1] - 1.0, b[0])
    coupler = scene.add_body(ancf.Rod(2.0), mass=2.0, position=(0, 1), orientation=turn)
    rocker = scene.add_body(
        ancf.Rod(2.5), mass=2.5, position=(3, 0), orientation=math.atan2(b[1], b[0] - 3.0) + gap
    )
    scene.pin(crank.origin)
    scene.pin(rocker.origin)
    scene.connect(crank.end, coupler.origin)
    scene.connect(coupler.end, rocker.end, apart=True)
    return scene, crank, coupler, rocker


@pytest.mark.parametrize("gap", [0.0, 0.3, -0.7])
def test_a_linkage_closes(gap):
    scene, crank, coupler, rocker = four_bar(gap)
    found = ancf.assemble(scene)
    ends = found.position(coupler.end), found.position(rocker.end)
    np.testing.assert_allclose(*ends, atol=1e-12)
    for body, start, length in ((crank, (0, 0), 1.0), (rocker, (3, 0), 2.5)):
        assert np.linalg.norm(found.position(body.end) - start) == pytest.approx(length, abs=1e-12)
    far = 2.0 * 2.5 * math.sin(0.5 * abs(gap))
    assert found.violation == pytest.approx(far, rel=0.5, abs=1e-9)
    if gap:
        assert "connection" in found.worst
        assert 0.2 * far < found.moved < far
        assert "moved by up to" in repr(found)
        with pytest.raises(InputError, match="connection"):
            ancf.simulate(scene, 0.1, 1e-3)
    run = ancf.simulate(scene, 0.5, 1e-3, start=found)
    apart = run.position(coupler.end) - run.position(rocker.end)
    assert np.abs(apart).max() < 1e-9
    assert run.energy.drift < 1e-2


@pytest.mark.parametrize("apart", [0.0, 0.3])
def test_a_driven_crank_takes_the_linkage_with_it(apart):
    scene, crank, coupler, _ = four_bar(apart)
    scene.drive_joint(scene.joints[0], lambda t: 0.5 * math.pi * t)
    found = ancf.assemble(scene, t=1.0)
    rest = ancf.solve_static(scene, t=1.0)
    near = ancf.solve_static(scene, start=found)
    for state in (found, rest, near):
        np.testing.assert_allclose(state.position(crank.end), (-1.0, 0.0), atol=1e-9)
        # At 180 degrees the two circles about the crank's end and the rocker's foot intersect here.
        x = 0.71875
        y = math.sqrt(4.0 - (x + 1.0) ** 2)
        np.testing.assert_allclose(state.position(coupler.end), (x, y), atol=1e-9)
    np.testing.assert_allclose(near.lam, rest.lam, rtol=1e-6, atol=1e-6)


def test_the_least_motion_by_mass():
    scene = ancf.Scene((0.0, 0.0))
    one = scene.add_body(mass=1.0, inertia=0.1, position=(0.0, 0.0))
    other = scene.add_body(mass=3.0, inertia=0.1, position=(1.0, 0.0))
    scene.connect(one.origin, other.origin, apart=True)
    found = ancf.assemble(scene)
    # By mass: the light one moves three quarters of the way.
    np.testing.assert_allclose(found.position(one.origin), (0.75, 0.0), atol=1e-9)
    assert found.moved == pytest.approx(0.75, abs=1e-9)


@pytest.mark.parametrize("element", ["thin", "string"])
def test_a_slack_line_between_supports_that_are_nearer_than_its_length(element):
    scene, rod = build_beam(element, (0, 0), (2.2, 0), 16, ancf.Circle(0.01), SOFT, "pin")
    scene.drive(rod.end, lambda t: (2.2 - 0.2 * min(t, 1.0), 0.0))
    found = ancf.assemble(scene, t=1.0)
    assert found.violation == pytest.approx(0.2)
    np.testing.assert_allclose(found.position(rod.end), (2.0, 0.0), atol=1e-12)
    rest = ancf.solve_static(scene, start=found)
    assert rest.t == 1.0
    if element == "thin":
        expected = ancf.solve_static(scene, t=1.0)
        middle = rest.position(rod.at(1.1)), expected.position(rod.at(1.1))
        np.testing.assert_allclose(*middle, atol=1e-7)
    assert rest.stable


def test_two_beams_are_bent_together():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    one = scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 6, ancf.Circle(0.01), SOFT)
    other = scene.add_beam("thin", (2.0, 0.1, 0.05), (1.05, 0.1, 0.0), 6, ancf.Circle(0.01), SOFT)
    scene.clamp(one.start)
    scene.clamp(other.start)
    scene.connect(one.end, other.end, apart=True)
    found = ancf.assemble(scene)
    np.testing.assert_allclose(found.position(one.end), found.position(other.end), atol=1e-12)
    rest = ancf.solve_static(scene, start=found)
    np.testing.assert_allclose(rest.position(one.end), rest.position(other.end), atol=1e-10)
    # What statics still moves is little: it was nearly at rest.
    assert np.abs(rest.position(one.end) - found.position(one.end)).max() < 0.02


def test_statics_from_a_state_finds_the_other_equilibrium():
    scene = ancf.Scene((0.0, 0.0))
    section = ancf.Section(1e-4, 1e-4, 1e-4, 1e-4)  # which does not bend
    left = scene.add_beam("thin", (-1.0, 0.0), (0.0, 0.2), 1, section, SOFT)
    right = scene.add_beam("thin", (1.0, 0.0), (0.0, 0.2), 1, section, SOFT)
    scene.connect(left.end, right.end)
    scene.pin(left.start)
    scene.pin(right.start)
    scene.point_force(left.end, (0.0, -0.5))
    above = ancf.solve_static(scene)
    assert above.position(left.end)[1] == pytest.approx(0.2, abs=0.02)
    q = above.q.copy()
    heights = np.concatenate([table[:, 1::2].ravel() for table in above.state.layout.places])
    q[np.unique(heights)] *= -0.9
    below = ancf.solve_static(scene, start=replace(above.state, q=q))
    assert below.position(left.end)[1] == pytest.approx(-0.2, abs=0.02)
    assert below.stable
    again = ancf.solve_static(scene, start=below)
    np.testing.assert_allclose(again.q, below.q, atol=1e-12)


def test_what_is_in_place_stays_there_and_what_cannot_be_is_named():
    scene, *_ = four_bar(0.0)
    found = ancf.assemble(scene)
    assert found.moved < 1e-8
    apart = ancf.Scene((0.0, 0.0))
    one, other = (apart.add_body(ancf.Rod(1.0), mass=1.0, position=(x, 0)) for x in (0, 5))
    apart.pin(one.origin)
    apart.pin(other.origin)
    apart.connect(one.end, other.end, apart=True)
    with pytest.raises(AssemblyError, match=r"cannot be assembled: the .* stays violated"):
        ancf.assemble(apart)
    with pytest.raises(InputError, match="t "):
        ancf.assemble(scene, t=math.nan)
    with pytest.raises(InputError, match="apart"):
        scene.connect(scene.bodies[0].origin, scene.bodies[2].origin, apart="yes")
    with pytest.raises(InputError, match="apart=True and let assemble"):
        scene.connect(scene.bodies[0].end, scene.bodies[2].origin)
    with pytest.raises(InputError, match="start must be a state"):
        ancf.solve_static(scene, start=3)
    with pytest.raises(InputError, match="t must be"):
        ancf.solve_static(scene, t=np.ones(3))


def test_loads_and_forces_of_the_motion_do_nothing():
    scene, _, coupler, _ = four_bar(0.2)
    plain = ancf.assemble(scene)
    scene.point_force(coupler.end, (100.0, 0.0), follow=True)
    scene.force(coupler.end, lambda q, v, t: np.full_like(q, 50.0))
    scene.spring(coupler.end, (9.0, 9.0), stiffness=10.0)
    np.testing.assert_allclose(ancf.assemble(scene).q, plain.q, atol=1e-9)


def test_a_scene_with_ends_apart_is_written(tmp_path):
    scene, *_ = four_bar(0.2)
    scene.save(tmp_path / "scene.json")
    assert ancf.Scene.load(tmp_path / "scene.json") == scene
