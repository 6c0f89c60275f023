"""A cable around a turning drum: Euler and Eytelwein's T2 = T1 exp(mu phi)."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems.contacts import DRUM_RADIUS, WIRE_RADIUS, capstan

TENSION, REACH = 10.0, DRUM_RADIUS + WIRE_RADIUS  # N, m


@pytest.mark.parametrize("slip_speed", [0.0, 1e-3], ids=["sticks", "slips"])
@pytest.mark.parametrize("turning", [2.0, -2.0])
@pytest.mark.parametrize("angle", [90.0, 180.0, 540.0])
@pytest.mark.parametrize("mu", [0.1, 0.3, 0.5])
def test_the_tension_grows_exponentially_along_the_arc(mu, angle, turning, slip_speed):
    case = capstan(
        mu,
        angle,
        TENSION,
        turning=turning,
        n_elements=int(0.28 * angle),
        slip_speed=slip_speed,
    )
    solver = ancf.QuasiNewton("broyden", memory=20, max_iterations=60)  # 38 at the tightest
    run = ancf.simulate(case.scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.5), solver=solver)
    exponent, phi = math.copysign(mu, turning), math.radians(angle)
    held = case.quantities(run)["t2"][-100:].mean()
    assert held == pytest.approx(TENSION * math.exp(exponent * phi), rel=1e-3)
    force = run.contact_force(case.scene.attachments[1]).at(-1)
    friction = np.linalg.norm(force.friction, axis=1)
    ratio = friction[force.pressure > 0.0] / (mu * force.pressure[force.pressure > 0.0])
    assert ratio.max() <= 1.0 + 1e-12
    if slip_speed:
        assert np.allclose(friction, mu * force.pressure, rtol=2e-4)
    else:
        assert np.quantile(ratio, 0.1) > 1.0 - 2e-4  # single points may stick for a moment
    # The pressure is the tension over the radius of the axis; the wire is stretched by up to 1.1 %.
    reach = DRUM_RADIUS + WIRE_RADIUS
    middle = int(np.argmin(np.abs(force.s - 0.5 * force.s[-1])))
    tension = TENSION * math.exp(exponent * (phi - force.s[middle] / reach))
    assert force.pressure[middle] == pytest.approx(tension / reach, rel=0.02)


@pytest.mark.parametrize("turning", [2.0, -2.0])
@pytest.mark.parametrize(("mu", "angle"), [(0.1, 1080.0), (0.3, 720.0)])
def test_the_axial_tension_of_a_helix_on_a_turning_drum_is_constant(mu, angle, turning):
    """Friction acts around the drum, so only that component of the tension grows, by exp(mu phi).

    A wire that slid along itself, over a drum that moves like a screw, would have
    exp(mu cos(a) phi): 1 to 3 % less where the tension grows.
    """
    growth = math.copysign(mu * math.radians(angle), turning)
    # The pitch is 0.1 m at the end with the smaller tension.
    slope = 0.1 / (2.0 * math.pi * REACH) * math.exp(min(growth, 0.0))
    case = capstan(
        mu,
        angle,
        TENSION,
        turning=turning,
        n_elements=round(angle / 3.6),
        pitch=2.0 * math.pi * REACH * slope,
    )
    solver = ancf.QuasiNewton("broyden", memory=20, max_iterations=60)
    run = ancf.simulate(case.scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.5), solver=solver)
    around, along = TENSION * np.array([1.0, slope]) / math.hypot(1.0, slope)
    held = case.quantities(run)["t2"][-100:].mean()
    assert held == pytest.approx(math.hypot(around * math.exp(growth), along), rel=5e-4)
    pull = -run.reaction(case.scene.body("fixed end").start)[-100:].mean(axis=0)
    assert pull[2] == pytest.approx(along, rel=5e-3)
    # The slope along and around decreases as the tension around the drum grows.
    arc = case.scene.body("arc")
    middle = run.slope(arc.at(0.5 * arc.length))[-100:].mean(axis=0)
    x, y = run.position(arc.at(0.5 * arc.length))[-1, :2]
    assert math.hypot(x, y) == pytest.approx(REACH, rel=1e-3)
    turned = turned_angle(run, arc)[arc.n_elements // 2]
    local = slope * math.exp(-growth * (1.0 - turned / math.radians(angle)))
    assert middle[2] / np.linalg.norm(middle[:2]) == pytest.approx(local, rel=6e-3)


@pytest.mark.parametrize(("mu", "bending"), [(0.1, 1e-3), (0.3, 1e-3), (0.3, 4e-3), (0.5, 1e-3)])
def test_a_stiff_wire_lifts_off_and_presses_there_with_a_force(mu, bending):
    """The first integral of the free ends, T (1 - cos a) = E I / (2 R^2), and forces T sin a.

    The force at either end carries friction too, so that to first order in a the ratio of the
    tensions does not change; the wire and the drum with R = 0.1 m have 2.558141 for 1e-3 N m2.
    """

    def ratio(angle, radius):
        grown, first = math.exp(mu * angle), math.acos(1.0 - bending / (2.0 * TENSION * radius**2))
        for _ in range(30):
            last = math.acos(1.0 - bending / (2.0 * TENSION * grown * radius**2))
            grown = (math.cos(first) + mu * math.sin(first)) * math.exp(mu * (angle - first - last))
            grown /= math.cos(last) - mu * math.sin(last)
        return grown, first, last

    if (mu, bending) == (0.3, 1e-3):
        assert ratio(math.pi, 0.1)[0] == pytest.approx(2.558141, abs=1e-6)
    case = capstan(mu, t1=TENSION, ei=bending, n_elements=96)
    run = ancf.simulate(case.scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
    found = case.quantities(run)
    angle = math.radians(found["wrapped_angle"][-1])
    assert angle == pytest.approx(math.pi, abs=0.01)
    expected, first, last = ratio(angle, REACH)
    assert found["ratio"][-1] == pytest.approx(expected, rel=2e-4)
    assert found["t2"][-1] == pytest.approx(TENSION * found["ratio"][-1])
    # Forces on a fifth of the arc at either end: at the place of lift-off, and along the rest.
    contact = case.scene.attachments[1]
    force = run.contact_force(contact).at(-1)
    for tension, lift, growth, part in (
        (TENSION * expected, last, -mu, force.s < 0.2 * force.s[-1]),
        (TENSION, first, mu, force.s > 0.8 * force.s[-1]),
    ):
        edge = tension * math.sin(lift)
        inside = tension * math.cos(lift) + growth * edge
        rest = inside * math.expm1(growth * (math.radians(36.0) - lift)) / growth
        assert np.sum((force.pressure * contact.weights)[part]) == pytest.approx(
            edge + rest, rel=0.02
        )


def turned_angle(run, arc):
    """Return the angles of the nodes around the drum from the first one on [rad]."""
    x, y = run.position(arc.node(0))[-1, :2]
    nodes = np.array([run.position(arc.node(k))[-1, :2] for k in range(arc.n_elements + 1)])
    return np.unwrap(np.arctan2(nodes[:, 1], -nodes[:, 0])) - math.atan2(y, -x)


def test_a_helix_that_slides_along_itself_has_the_tension_of_its_curvature():
    """Over a drum at rest dT/ds = mu T cos(a)^2 / R, so T2 = T1 exp(mu cos(a) phi)."""
    mu, turns, pitch = 0.3, 2.0, 0.3
    slope = pitch / (2.0 * math.pi * REACH)
    scene = ancf.Scene((0.0, 0.0, 0.0))
    section = ancf.Section(4e-6, 4e-16, 4e-16, 4e-16)
    wire = scene.add_beam(
        "thin", curve=ancf.Helix(REACH, pitch, turns), rest="straight", n_elements=200,
        section=section, material=ancf.Material(2.5e10, 2.5e4),
    )  # fmt: skip
    back, ahead = (np.array([0.0, sign, sign * slope]) / math.hypot(1, slope) for sign in (-1, 1))
    scene.contact(
        wire, ancf.Drum((0, 0, 0), DRUM_RADIUS, (0, 0, 1)), stiffness=3e7, radius=WIRE_RADIUS,
        friction=mu,
    )  # fmt: skip
    scene.point_force(wire.start, ancf.Ramp(tuple(TENSION * back), 0.05, smooth=True))
    scene.drive(wire.end, ancf.Ramp(tuple(4e-3 * ahead), 0.3, smooth=True) + wire.end.position)
    solver = ancf.QuasiNewton("broyden", memory=20, max_iterations=60)
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.5), solver=solver)
    pull = np.linalg.norm(run.reaction(wire.end), axis=1)[200:260].mean()
    exact = math.exp(mu * 2.0 * math.pi * turns / math.hypot(1.0, slope))
    assert pull / TENSION == pytest.approx(exact, rel=5e-3)
