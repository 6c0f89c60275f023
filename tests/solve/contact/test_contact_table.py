"""The table of contacts, against forces, speeds and places that are known."""

import numpy as np
import pytest

import ancfsparse as ancf

SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(1e8, 1e3)


def test_a_sliding_cable_lies_on_the_ground_with_its_weight():
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (0, 0.005), (1, 0.005), 8, SECTION, MATERIAL, velocity=(0.5, 0))
    contact = scene.contact(
        cable, ancf.HalfSpace((0, 0), (0, 1)), stiffness=1e5, friction=0.2, slip_speed=1e-3
    )
    run = ancf.simulate(scene, 0.2, 1e-3)
    (touch,) = run.contacts()
    weight = np.pi * 0.005**2 * 1e3 * 9.81
    assert touch.normal_force == pytest.approx(weight, rel=1e-2)
    assert touch.friction == pytest.approx(0.2 * weight, rel=1e-2)
    # Decelerated by mu g.
    assert touch.sliding_speed == pytest.approx(0.5 - 0.2 * 9.81 * 0.2, rel=1e-2)
    # The layer, a thousandth of the radius, shifts the position of rest by half of itself.
    assert touch.penetration == pytest.approx(weight / 1e5 + 0.5e-3 * 0.005, rel=1e-2)
    assert [point.beam.arc(point) for point in touch.points] == pytest.approx([0.0, 1.0], abs=0.02)
    (then,) = run.contacts(0.1)
    forces = run.contact_force(contact)
    assert then.friction == pytest.approx(
        np.linalg.norm(forces.friction[100], axis=1) @ contact.weights, rel=1e-12
    )
    assert str(run.contacts()).splitlines()[1].startswith("half-space, from beam 0 at s = ")
    assert not run.contacts(0.0)
    with pytest.raises(ancf.InputError, match="no state was saved at t = 1 s"):
        run.contacts(1.0)


def test_a_cable_on_two_drums_has_a_stretch_on_each_at_their_speeds():
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (-0.5, 0), (0.5, 0), 80, SECTION, ancf.Material(1e10, 1e3))
    contacts = [
        scene.contact(
            cable, ancf.Drum((x, -0.105), radius=0.1, angular_velocity=speed),
            stiffness=1e6, friction=0.1, slip_speed=1e-3,
        )
        for x, speed in ((-0.3, 4.0), (0.3, 0.0))
    ]  # fmt: skip
    scene.pin(cable.start)
    rest = ancf.solve_static(scene)
    touches = rest.contacts()
    for touch, contact, x, speed in zip(touches, contacts, (-0.3, 0.3), (4.0, 0.0), strict=True):
        assert touch.contact is contact
        forces = rest.contact_force(contact)
        assert touch.normal_force == pytest.approx(forces.pressure @ contact.weights, rel=1e-12)
        assert touch.friction == pytest.approx(0.1 * touch.normal_force * (speed > 0), rel=1e-3)
        # Of the drum where the axis of the cable lies.
        assert touch.sliding_speed == pytest.approx(speed * 0.105, rel=1e-2)
        arcs = [point.beam.arc(point) - 0.5 for point in touch.points]
        assert x - 0.03 < arcs[0] <= arcs[1] < x + 0.03


def test_cables_that_cross_touch_at_a_point_of_each():
    scene = ancf.Scene((0, 0, 0))
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 9, SECTION, MATERIAL)
    upper = scene.add_beam(
        "thin", (0.1, -0.5, 0.0101), (0.1, 0.5, 0.0101), 9, SECTION, MATERIAL,
        velocity=(0.1, 0.2, -0.2),
    )  # fmt: skip
    contact = scene.contact(lower, upper, stiffness=1e6)
    run = ancf.simulate(scene, 1e-3, 1e-4, integrator=ancf.EnergyMomentum())
    (touch,) = run.contacts()
    forces = run.contact_force(contact)
    assert touch.contact is contact
    assert touch.normal_force == pytest.approx(forces.size[-1], rel=1e-12)
    assert touch.penetration == forces.penetration[-1] > 0.0
    assert touch.sliding_speed == pytest.approx(np.hypot(0.1, 0.2), rel=1e-2)
    one, other = touch.points
    assert (one.beam.arc(one), other.beam.arc(other)) == pytest.approx((0.6, 0.5), abs=1e-3)
    assert "beam 0 at s = 0.6" in repr(run.contacts())
