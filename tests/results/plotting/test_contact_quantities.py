"""Pressure and friction of contacts along beams, over time, and as colours, against formulas."""

import math

import matplotlib.pyplot as plt
import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.problems import capstan
from ancfsparse.problems.contacts import DRUM_RADIUS, WIRE_RADIUS

pytestmark = pytest.mark.usefixtures("close_figures")

TENSION, MU = 10.0, 0.3  # N, -
REACH = DRUM_RADIUS + WIRE_RADIUS
ROPE, WIRE = ancf.Circle(0.01), ancf.Material(1e8, 5e3)
WEIGHT = 5e3 * math.pi * 0.005**2 * 9.81  # N/m


@pytest.fixture(scope="module")
def sliding():
    """Return a wire that slides around half a drum, which pulls it towards its fixed end."""
    case = capstan(MU, 180.0, TENSION, slip_speed=1e-3)
    run = ancf.simulate(case.scene, 0.2, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
    return run, case.scene.body("arc")


@pytest.fixture(scope="module")
def stack():
    """Return two cables at rest on a floor, one on top of the other."""
    scene = ancf.Scene((0, -9.81))
    lower, upper = (
        scene.add_beam("thin", (0, y), (1, y), 8, ROPE, WIRE, name=name)
        for name, y in (("lower", 0.005), ("upper", 0.015))
    )
    scene.contact(lower, ancf.HalfSpace((0, 0), (0, 1)), stiffness=1e6, friction=MU)
    scene.contact(lower, upper, stiffness=1e6, friction=MU)
    return ancf.solve_static(scene), lower, upper


@pytest.fixture(scope="module")
def crossing():
    """Return the run of a wire that slides across another one, both wires and their contact."""
    scene = ancf.Scene((0, 0, -9.81))
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 9, ROPE, WIRE, name="lower")
    scene.clamp(lower.start)
    scene.clamp(lower.end)
    upper = scene.add_beam(
        "thin", (0, -0.5, 0.01), (0, 0.5, 0.01), 9, ROPE, WIRE, velocity=(0.1, 0, 0), name="upper"
    )
    contact = scene.contact(lower, upper, stiffness=1e7, friction=MU, slip_speed=1e-3)
    run = ancf.simulate(scene, 0.05, 5e-4, integrator=ancf.EnergyMomentum())
    return run, lower, upper, contact


def test_pressure_and_friction_of_a_wire_that_slides_around_a_drum(sliding):
    run, arc = sliding
    line = run.plot("pressure", arc, times=0.2).lines[0]
    s = np.asarray(line.get_xdata())
    np.testing.assert_allclose(s, (np.arange(arc.n_elements) + 0.5) * arc.length / arc.n_elements)
    exact = TENSION / REACH * np.exp(MU * (arc.length - s) / REACH)
    inside = slice(8, -8)  # the wire, which bends, leaves the drum next to both ends
    np.testing.assert_allclose(line.get_ydata()[inside], exact[inside], rtol=1e-3)
    friction = run.plot("friction", arc, times=0.2).lines[0].get_ydata()
    np.testing.assert_allclose(friction[inside], MU * exact[inside], rtol=1e-3)
    np.testing.assert_allclose(friction, MU * line.get_ydata(), rtol=5e-4)
    ax = run.plot("pressure", arc.at(s[24]))
    assert ax.get_ylabel() == "pressure of contacts [N/m]"
    assert ax.lines[0].get_ydata()[-1] == line.get_ydata()[24]


def test_a_range_graph_has_least_mean_and_greatest_values(sliding):
    run, arc = sliding
    pressure = run.contact_force(arc).pressure
    ax = run.plot("pressure", arc, times="range")
    drawn = {line.get_label(): line.get_ydata() for line in ax.lines}
    np.testing.assert_array_equal(drawn["minimum"], pressure.min(axis=0))
    np.testing.assert_allclose(drawn["mean"], pressure.mean(axis=0))
    np.testing.assert_array_equal(drawn["maximum"], pressure.max(axis=0))
    assert [text.get_text() for text in ax.get_legend().get_texts()] == list(drawn)
    moments = run.plot("M", arc, times="range").lines
    inside = run.section_force(arc).M
    np.testing.assert_allclose(moments[2].get_ydata()[1:-1], inside.max(axis=0))


def test_cables_at_rest_press_with_their_weight(stack):
    """The floor carries both; the lower cable also has the pressure of the upper one."""
    rest, lower, upper = stack
    np.testing.assert_allclose(rest.plot("pressure", upper).lines[0].get_ydata(), WEIGHT, rtol=1e-6)
    force = rest.contact_force(lower)
    np.testing.assert_allclose(force.pressure, 3.0 * WEIGHT, rtol=1e-6)
    np.testing.assert_allclose(force.force, [0.0, WEIGHT], atol=1e-6 * WEIGHT)
    np.testing.assert_allclose(force.s, (np.arange(8) + 0.5) / 8)


def test_forces_on_elements_of_wires_that_cross_are_those_of_the_contact(crossing):
    run, lower, upper, contact = crossing
    total = run.contact_force(contact)
    row = int(total.size.argmax())
    for body, sign in ((lower, 1.0), (upper, -1.0)):
        force = run.contact_force(body)
        size = (force.pressure * body.lengths).sum(axis=1)
        np.testing.assert_allclose(size, total.size, atol=1e-12)
        friction = np.linalg.norm(force.friction, axis=2) * body.lengths
        np.testing.assert_allclose(friction.sum(axis=1), total.friction, rtol=1e-3)
        np.testing.assert_allclose(force.force, sign * total.force, atol=1e-12)
        # Only the middle one of nine elements is at the crossing.
        assert np.flatnonzero(force.pressure[row]).tolist() == [4]
    # The upper wire slides along x and is decelerated; the lower one is pulled along.
    assert run.contact_force(upper).friction[row, 4, 0] < 0.0
    assert run.contact_force(lower).friction[row, 4, 0] > 0.0


def test_the_pressures_of_several_contacts_are_added(stack):
    rest, lower, _ = stack
    floor, beams = rest.system.scene.attachments
    force = rest.contact_force(floor).pressure * floor.weights
    of_floor = np.bincount(floor.elements, force) * 8 / lower.length
    of_beams = rest.contact_force(beams).size / lower.length
    np.testing.assert_allclose(rest.contact_force(lower).pressure, of_floor + of_beams, rtol=1e-6)


def test_a_body_without_contact_has_no_pressure(sliding):
    run, _ = sliding
    scene = ancf.Scene((0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, ROPE, WIRE)
    scene.clamp(rod.start)
    assert not ancf.solve_static(scene).contact_force(rod).pressure.any()
    with pytest.raises(InputError, match="is not part of this scene"):
        run.contact_force(rod)


def test_shapes_have_the_colours_of_a_quantity(sliding):
    run, arc = sliding
    ax = run.plot(colour="pressure", times=[0.1, 0.2])
    bodies = run.system.bodies
    drawn = [each for each in ax.collections if each.get_array() is not None]
    assert len(drawn) == 2 * len(bodies)
    pressure = run.contact_force(arc).pressure
    np.testing.assert_array_equal(drawn[1].get_array(), pressure[100])
    np.testing.assert_array_equal(drawn[4].get_array(), pressure[200])
    assert {each.norm for each in drawn} == {drawn[0].norm}
    assert drawn[0].norm.vmax == pressure[[100, 200]].max()
    ax.figure.canvas.draw()
    assert len(np.unique(drawn[4].get_edgecolors(), axis=0)) > 20
    assert ax.figure.axes[-1].get_ylabel() == "pressure of contacts [N/m]"
    last = run.plot(colour="N", ax=plt.figure().add_subplot()).collections[1].get_array()
    np.testing.assert_array_equal(last, run.section_force(arc).N[-1])


def test_a_spatial_equilibrium_has_a_bar_next_to_its_box(crossing):
    run = crossing[0]
    ax = run.plot(colour="pressure", view=(20, -60))
    bar = ax.figure.axes[-1].get_position()
    assert bar.x1 < ax.get_position().x0 + 0.2
    assert 0.0 < bar.y0 < bar.y1 < 1.0
    scene = ancf.Scene((0, 0, -9.81))
    rod = scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 4, ROPE, WIRE)
    scene.clamp(rod.start)
    rest = ancf.solve_static(scene)
    (beam, *_) = rest.plot(colour="strain").collections
    np.testing.assert_array_equal(beam.get_array(), rest.strain(rod))


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ((), {"colour": "M"}, "unknown colour 'M'"),
        (("energy",), {"colour": "N"}, "colour is for shapes and does not apply to 'energy'"),
        (("pressure",), {}, "pressure is evaluated along a beam"),
        ((), {"times": "range"}, "times must be a list of times in s"),
    ],
)
def test_wrong_requests_are_refused(sliding, arguments, options, message):
    with pytest.raises(InputError, match=message):
        sliding[0].plot(*arguments, **options)


def test_rigid_bodies_have_no_colours():
    scene = ancf.Scene((0, -9.81))
    body = scene.add_body(mass=1.0, inertia=1.0, position=(0, 0))
    run = ancf.simulate(scene, 0.01, 1e-3)
    with pytest.raises(InputError, match="colour='N' is for beams and meshes"):
        run.plot(of=body, colour="N")


def impulses(dt, integrator, **options):
    """Return the impulse of a level fall by the momentum, and by the forces in all states [N s]."""
    scene, mass = ancf.Scene((0, -9.81)), 1e3 * 0.25 * np.pi * 0.01**2
    section, material = ancf.Circle(0.01), ancf.Material(1e7, 1e3)
    rope = scene.add_beam("thin", (0, 0.025), (1, 0.025), 4, section, material)  # falls by 2 cm
    contact = scene.contact(rope, ancf.HalfSpace((0, 0), (0, 1)), **options)
    run = ancf.simulate(scene, 0.1, dt, integrator=integrator)
    change = mass * (run.velocity(rope.at(0.5))[-1, 1] + 9.81 * run.t[-1])
    return change, np.trapezoid(run.contact_force(contact).force[:, 1], run.t)


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum()])
def test_forces_of_resolved_impacts_have_the_impulse(integrator):
    change, integral = impulses(1e-5, integrator, stiffness=1e5)
    assert integral == pytest.approx(change, rel=5e-3)


def test_forces_in_states_do_not_have_the_impulse_of_unresolved_impacts():
    change, integral = impulses(1e-3, ancf.GeneralizedAlpha(0.9), stiffness=1e9)
    assert integral < 0.1 * change
