"""Friction in equilibria: slopes, capstans and loops, against closed formulas."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import SingularSceneError
from ancfsparse.problems.contacts import DRUM_RADIUS, WIRE_RADIUS
from ancfsparse.system import System
from tests.matrices import full
from tests.solve.contact.test_contact_motion import LINE_MASS, MATERIAL, SECTION

TENSION, STIFFNESS = 10.0, 1e6
WEIGHT = LINE_MASS * 9.81


def rope_on_slope(slope, dim=2, share=1.0, **friction):
    """A rope of 1 m that touches a slope with a share of its weight."""
    pad = (0.0,) * (dim - 2)
    along = np.array([math.cos(slope), math.sin(slope), *pad])
    normal = np.array([-along[1], along[0], *pad])
    depth = share * (WEIGHT * math.cos(slope) / STIFFNESS + 2.5e-6)
    scene, start = ancf.Scene((0.0, -9.81, *pad)), (0.005 - depth) * normal
    rope = scene.add_beam("thin", start, start + along, 8, SECTION, MATERIAL)
    floor = ancf.HalfSpace((0.0,) * dim, tuple(normal))
    return scene, rope, scene.contact(rope, floor, stiffness=STIFFNESS, **friction), along


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("ratio", [0.5, 0.99])
def test_a_rope_rests_on_a_rough_slope(dim, ratio):
    """Friction is its weight along the slope, by bristles of a tenth of the stiffness."""
    mu = 0.4
    slope = math.atan(ratio * mu)
    scene, rope, contact, along = rope_on_slope(slope, dim, friction=mu)
    rest = ancf.solve_static(scene)
    assert rest.stable
    force = rest.contact_force(contact)
    np.testing.assert_allclose(force.force, np.eye(dim)[1] * WEIGHT, atol=1e-7 * WEIGHT)
    way = rest.displacement(rope.at(0.5)) @ along
    assert way == pytest.approx(-WEIGHT * math.sin(slope) / (0.1 * STIFFNESS), rel=1e-2)
    assert rest.contacts()[0].friction == pytest.approx(WEIGHT * math.sin(slope), rel=1e-6)


@pytest.mark.parametrize("friction", [0.0, 0.4])
def test_a_rope_on_a_steeper_slope_is_refused(friction):
    scene, *_ = rope_on_slope(math.atan(0.4 * 1.01), friction=friction)
    with pytest.raises(SingularSceneError, match="does not come to rest under its loads"):
        ancf.solve_static(scene)


def test_a_static_coefficient_holds_more_than_the_kinetic_one():
    friction = {"friction": 0.3, "static_friction": 0.4}
    scene, *_ = rope_on_slope(math.atan(0.39), **friction)
    assert ancf.solve_static(scene).stable
    scene, *_ = rope_on_slope(math.atan(0.41), **friction)
    with pytest.raises(SingularSceneError, match="does not come to rest"):
        ancf.solve_static(scene)


def test_a_motion_from_an_equilibrium_has_its_deflections():
    scene, rope, contact, _ = rope_on_slope(math.atan(0.3), friction=0.4)
    rest = ancf.solve_static(scene)
    run = ancf.simulate(scene, 0.1, 1e-3, start=rest, integrator=ancf.GeneralizedAlpha(0.5))
    assert np.abs(run.q - rest.q).max() < 1e-10
    np.testing.assert_allclose(run.contact_force(contact).force[-1], (0.0, WEIGHT), atol=1e-6)
    again = ancf.solve_static(scene, start=run.last)
    assert np.abs(again.q - rest.q).max() < 1e-10
    assert run.velocity(rope.end).shape == (101, 2)


@pytest.mark.parametrize("second", [{}, {"friction": 0.4, "slip_speed": 1e-3}])
def test_a_motion_from_an_equilibrium_has_the_penetrations_of_all_contacts(second):
    """Those of the reference shape would push the second rope in the first step: by 1e-6 m."""
    scene, *_ = rope_on_slope(math.atan(0.3), friction=0.4)
    depth = 0.2 * WEIGHT / STIFFNESS
    rope = scene.add_beam("thin", (2.0, 0.005 - depth), (3.0, 0.005 - depth), 8, SECTION, MATERIAL)
    scene.contact(rope, ancf.HalfSpace((0, 0), (0, 1)), stiffness=STIFFNESS, **second)
    rest = ancf.solve_static(scene)
    run = ancf.simulate(scene, 0.02, 1e-3, start=rest, integrator=ancf.GeneralizedAlpha(0.5))
    assert np.abs(run.q - rest.q).max() < 1e-10


def wire_around_drum(mu, angle, reach, **drum):
    """A wire with a force at one end, whose other end has a prescribed motion along the wire."""
    phi, outside = math.radians(angle), DRUM_RADIUS + WIRE_RADIUS
    scene = ancf.Scene((0.0, 0.0))
    wire = ancf.Rectangle(2 * WIRE_RADIUS, 2 * WIRE_RADIUS), ancf.Material(2.5e10, 2.5e4)
    arc = scene.add_beam(
        "thin", curve=ancf.Arc((0, 0), (-outside, 0), -phi), n_elements=int(0.28 * angle),
        section=wire[0], material=wire[1],
    )  # fmt: skip
    end = outside * np.array([-math.cos(phi), math.sin(phi)])
    leaving = np.array([math.sin(phi), math.cos(phi)])
    tails = (
        scene.add_beam("thin", (-outside, 0), (-outside, -0.05), 4, *wire),
        scene.add_beam("thin", end, end + 0.05 * leaving, 4, *wire),
    )
    scene.connect(arc.start, tails[0].start)
    scene.connect(arc.end, tails[1].start)
    scene.point_force(tails[0].end, (0.0, -TENSION))
    stiffness = 100.0 * TENSION / (outside * WIRE_RADIUS) * math.exp(0.5 * mu * phi)
    contacts = [
        scene.contact(
            part, ancf.Drum((0, 0), DRUM_RADIUS, **drum), stiffness=stiffness,
            radius=WIRE_RADIUS, friction=mu,
        )
        for part in (arc, *tails)
    ]  # fmt: skip
    if reach is None:
        scene.clamp(tails[1].end)
    else:
        points = np.array(tails[1].end.position) + np.outer(reach, leaving)
        times = np.arange(len(reach), dtype=float).tolist()
        scene.drive(tails[1].end, ancf.Table(times, points.tolist(), smooth=True))
    return scene, tails[1].end, contacts


@pytest.mark.parametrize(("mu", "angle"), [(0.1, 180), (0.3, 180), (0.5, 180), (0.1, 540)])
def test_a_wire_that_is_pulled_slowly_slides_with_the_load_of_euler_and_eytelwein(mu, angle):
    """Pulled, released and pulled again: the work in the closed loop is the loss by friction."""
    growth = math.exp(mu * math.radians(angle))
    reach = 2e-4 * (1.0 + 0.25 * growth) * math.radians(angle) / math.pi
    scene, pulled, contacts = wire_around_drum(mu, angle, [0.0, reach, -reach, reach, -reach])
    run = ancf.quasi_static(scene, 4.0, 0.05)
    tension = np.linalg.norm(run.reaction(pulled), axis=1) / TENSION
    assert tension.max() == pytest.approx(growth, rel=1e-3)
    assert tension[21:].min() == pytest.approx(1.0 / growth, rel=1e-3)
    for contact in contacts:
        forces = run.contact_force(contact)
        sizes = np.linalg.norm(forces.friction, axis=2)
        assert np.all(sizes <= mu * forces.pressure * (1.0 + 1e-9) + 1e-9)
    energy, loop = run.energy, [40, 80]
    assert np.diff(energy.work[loop]) == pytest.approx(np.diff(energy.friction[loop]), rel=2e-2)
    assert np.diff(energy.friction[loop]) > 0.0


def bent_rope(stiffness):
    """A straight rope that a load holds bent over a drum, and its contacts."""
    radius = 2e-3
    section, material = ancf.Circle(2.0 * radius), ancf.Material(1e9, 4e3)
    scene, x = ancf.Scene((0.0, -9.81)), DRUM_RADIUS + radius
    arc = scene.add_beam(
        "thin", curve=ancf.Arc((0, 0), (-x, 0), -math.pi), rest="straight", n_elements=40,
        section=section, material=material,
    )  # fmt: skip
    tails = [
        scene.add_beam("thin", (side, 0), (side, -0.3), 12, section, material) for side in (-x, x)
    ]
    scene.weld(arc.start, tails[0].start)
    scene.weld(arc.end, tails[1].start)
    scene.pin(tails[0].end)
    scene.point_force(tails[1].end, (0.0, -10.0))
    drum = ancf.Drum((0, 0), DRUM_RADIUS)
    contacts = [
        scene.contact(part, drum, stiffness=stiffness, friction=0.3) for part in (arc, *tails)
    ]
    return scene, contacts


def test_contacts_become_stiffer_from_equilibrium_to_equilibrium():
    """Each is the start of the next, so that a penalty reaches any penetration."""
    rest = None
    for stiffness in (1e8, 1e9, 1e10, 1e11):
        scene, contacts = bent_rope(stiffness)
        rest = ancf.solve_static(scene, start=rest)
        pressure = max(rest.contact_force(each).pressure.max() for each in contacts)
        assert rest.stats.iterations < 25
    assert pressure / stiffness < 1e-5 * 2e-3


def cable_on_cable(stiffness):
    """A straight cable with a load on another one, their contact, the lower and the upper one."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    rope, rubber = ancf.Circle(0.01), ancf.Material(1e8, 5e3)
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 20, rope, rubber)
    upper = scene.add_beam("thin", (0, -0.5, 0.01), (0, 0.5, 0.01), 20, rope, rubber)
    for end in (lower.start, lower.end):
        scene.clamp(end)
    for end in (upper.start, upper.end):
        scene.pin(end)
    scene.point_force(upper.at(0.5), (0.0, 0.0, -5.0))
    return scene, scene.contact(lower, upper, stiffness=stiffness), lower, upper


def test_stiffer_contacts_of_cables_take_few_corrections():
    """The first one begins at straight cables, which have no lateral stiffness."""
    rest = None
    for stiffness in (1e6, 1e8, 1e11):
        scene, contact, lower, upper = cable_on_cable(stiffness)
        rest = ancf.solve_static(scene, start=rest)
        touch = rest.contact_force(contact)
        force = 4.0 / 3.0 * math.sqrt(0.02) * stiffness * touch.penetration**1.5
        assert touch.size == pytest.approx(force, rel=0.05)
        above = rest.position(upper.at(0.5))[2] - rest.position(lower.at(0.5))[2]
        assert above == pytest.approx(0.01 - touch.penetration, rel=1e-3)
        assert rest.stats.iterations < 16


@pytest.mark.parametrize("stiffness", [1e5, 1e6, 1e8, 1e10, 1e12])
def test_cables_that_cross_take_few_corrections_from_the_straight_shape(stiffness):
    """Before, first corrections let the axes nearly meet, and 1e5 to 1e8 took 32 to 59."""
    rest = ancf.solve_static(cable_on_cable(stiffness)[0])
    assert rest.stable
    assert rest.stats.iterations < 16
    assert rest.stats.factorizations < 12


@pytest.mark.parametrize("turning", [-1.0, 1.0])
def test_a_drum_that_turns_slowly_slides_below_the_wire(turning):
    scene, held, _ = wire_around_drum(0.3, 180, None, angular_velocity=2e-2 * turning)
    run = ancf.quasi_static(scene, 1.0, 0.05)
    tension = np.linalg.norm(run.reaction(held), axis=1) / TENSION
    assert tension[-1] == pytest.approx(math.exp(turning * 0.3 * math.pi), rel=1e-3)


def test_a_load_path_has_friction():
    """A rope that is clamped and pulled along a floor: friction up to mu times its weight."""
    mu = 0.5
    scene, rope, *_ = rope_on_slope(0.0, share=0.0, friction=mu)
    scene.clamp(rope.start)
    scene.point_force(rope.end, (2.0 * mu * WEIGHT, 0.0))
    path = ancf.load_path(scene)
    assert path.complete
    stretch = path.displacement(rope.end)[-1, 0]
    stiffness = 1e8 * SECTION.area
    # The tension falls from 2 mu w to mu w along the rope.
    assert stretch == pytest.approx(1.5 * mu * WEIGHT / stiffness, rel=2e-2)


@pytest.mark.parametrize("dim", [2, 3])
def test_the_tangent_of_equilibria_is_the_derivative(dim, rng):
    """Including the unsymmetric part by the pressures, where points slide and where they stick."""
    scene, _, _, along = rope_on_slope(0.3, dim, friction=0.4)
    system = System(scene)
    n, none = system.n_free, np.zeros(0)
    rest, lam = np.zeros(system.n_all), np.zeros(system.n_multipliers)
    uniform = sum(x * system.uniform(c) for c, x in enumerate(along))
    for way in (1e-6, 1e-3):
        q = system.q0 + way * uniform + 1e-7 * rng.normal(size=system.n_all)
        with system.equilibria(system.q0):

            def force(x, system=system):
                return system.assembly.residual(x, rest, rest, lam, rest, none)[0][:n]

            units = 1e-9 * np.eye(system.n_all)[:n]
            expected = np.array([force(q + e) - force(q - e) for e in units]).T / 2e-9
            found = full(system, system.assembly.matrix(0.0, 1.0, q, lam, none))[:n, :n]
            parts = [term.unsymmetric_stiffness(q) for term in system.contributions]
            missing = sum(part.toarray()[:n, :n] for part in parts if part is not None)
        assert (np.abs(missing).max() > 1e-3 * np.abs(found).max()) == (way > 1e-4)
        assert np.abs(found + missing - expected).max() < 1e-5 * np.abs(expected).max()
