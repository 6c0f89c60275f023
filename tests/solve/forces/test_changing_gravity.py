"""Gravity that changes with time, frames that accelerate, and statics at a time."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import LoadError
from tests.beams import build_beam
from tests.solve.refusals import assert_refused

SOFT = ancf.Material(1e7, 1000.0)


def hung(gravity, *, dim=2, element="thin"):
    """A cable with a rigid body and a point mass, between two points."""
    scene = ancf.Scene(gravity)
    z = (0.0,) * (dim - 2)
    rod = scene.add_beam(element, (0, 0, *z), (1, 0, *z), 6, ancf.Circle(0.01), SOFT)
    inertia = 0.01 if dim == 2 else (0.01, 0.02, 0.015)
    body = scene.add_body(mass=0.3, inertia=inertia, position=(0.5, -0.1, *z))
    centre = (0.0, 0.1, *z)
    scene.connect(rod.node(3), body.at(centre))
    scene.add_mass(rod.node(2), 0.05)
    return scene, rod, body


@pytest.mark.parametrize(("dim", "element"), [(2, "thin"), (3, "thick"), (2, "string")])
def test_constant_values_are_those_of_gravity(dim, element):
    pull = (1.5, -9.81, 2.0)[:dim]
    places = []
    for given in (False, True):
        scene, rod, body = hung(np.zeros(dim) if given else pull, dim=dim, element=element)
        scene.pin(rod.start)
        scene.pin(rod.end)
        if given:
            scene.changing_gravity(pull)
        run = ancf.simulate(scene, 0.2, 2e-3, tolerance=1e-10)
        places.append(np.stack([run.position(rod.node(3)), run.position(body.origin)]))
        work = run.energy.work if given else -run.energy.potential
        assert np.ptp(work) > 0.01
    np.testing.assert_allclose(*places, atol=1e-8)


def shake(t):
    """Smooth motion of supports from rest: 5 cm in 0.3 s."""
    x = np.clip(t / 0.3, 0.0, 1.0)
    return 0.05 * x**4 * (35.0 - 84.0 * x + 70.0 * x**2 - 20.0 * x**3)


def pull(t):
    """Acceleration of `shake`."""
    x = np.clip(t / 0.3, 0.0, 1.0)
    return 0.05 / 0.09 * (420.0 * x**2 - 1680.0 * x**3 + 2100.0 * x**4 - 840.0 * x**5)


def test_in_a_frame_that_accelerates_the_motion_is_that_beside_moving_supports():
    direction = np.array([0.6, 0.8])
    fixed, rod, body = hung((0.0, -9.81))
    for node in (rod.start, rod.end):
        place = node.position.copy()
        fixed.drive(node, lambda t, place=place: tuple(place + shake(t) * direction))
    moving = ancf.simulate(fixed, 0.4, 1e-3, tolerance=1e-10)
    scene, cable, lump = hung((0.0, -9.81))
    scene.pin(cable.start)
    scene.pin(cable.end)
    scene.changing_gravity(lambda t: tuple(-pull(t) * direction))
    run = ancf.simulate(scene, 0.4, 1e-3, tolerance=1e-10)
    for one, other in ((rod.node(3), cable.node(3)), (body.centre, lump.centre)):
        relative = moving.position(one) - np.multiply.outer(shake(moving.t), direction)
        assert np.abs(relative - moving.position(one)).max() > 0.04
        np.testing.assert_allclose(run.position(other), relative, atol=1e-5)


def test_the_work_of_changing_gravity_is_counted():
    scene, rod, _ = hung((0.0, 0.0))
    scene.pin(rod.start)
    scene.pin(rod.end)
    scene.changing_gravity(lambda t: (0.0, -30.0 * t))
    offs = []
    for dt in (2e-3, 1e-3):
        run = ancf.simulate(scene, 0.2, dt, integrator=ancf.Newmark(0.0), tolerance=1e-11)
        energy = run.energy
        offs.append(np.abs(energy.kinetic + energy.elastic - energy.work).max())
    assert offs[1] < 1e-3 * np.max(energy.kinetic)
    assert offs[1] < 0.3 * offs[0]


def test_statics_at_a_time_take_loads_gravity_and_drives_there():
    def scene_at(t):
        scene, rod = build_beam("thin", (0, 0), (1, 0), 8, ancf.Circle(0.01), SOFT, "pin")

        def given(function):
            return function if t is None else function(t)

        scene.drive(rod.end, lambda s: (1.0 - 0.1 * (s if t is None else t), 0.05))
        scene.point_force(rod.node(4), given(lambda s: (0.1 * s, -0.3)))
        scene.changing_gravity(given(lambda s: (0.0, -2.0 * s)))
        return scene, rod

    scene, rod = scene_at(None)
    rest = ancf.solve_static(scene, t=1.5)
    fixed, other = scene_at(1.5)
    expected = ancf.solve_static(fixed)
    np.testing.assert_allclose(rest.q, expected.q, atol=1e-9)
    np.testing.assert_allclose(rest.position(rod.end), (0.85, 0.05), atol=1e-12)
    np.testing.assert_allclose(rest.reaction(rod.start), expected.reaction(other.start), rtol=1e-7)
    assert rest.state.t == 1.5
    modes, there = ancf.modes(rest, 3), ancf.modes(expected, 3)
    np.testing.assert_allclose(modes.frequencies, there.frequencies, rtol=1e-7)
    path = ancf.load_path(scene, t=1.5)
    np.testing.assert_allclose(path.q[-1], expected.q, atol=1e-8)
    assert path.state(-1).t == 1.5


def test_functions_of_the_motion_have_the_time_of_statics():
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.01), SOFT)
    scene.clamp(rod.start)
    times = []

    def force(q, v, t):
        times.append(t)
        return np.array([[0.0, -1e-5 * t]])

    scene.force(rod.end, force)  # which tries it out at t = 0
    times.clear()
    tip = [ancf.solve_static(scene, t=t).displacement(rod.end)[1] for t in (1.0, 2.0)]
    assert set(times) == {1.0, 2.0}
    assert tip[1] / tip[0] == pytest.approx(2.0, rel=1e-3)


def test_changing_gravity_is_printed_and_checked():
    scene, rod, _ = hung((0.0, -9.81))
    scene.pin(rod.start)
    scene.pin(rod.end)
    scene.changing_gravity((1.0, 2.0))
    scene.changing_gravity(ancf.Sine(amplitude=(0.0, 3.0), frequency=2.0))
    assert "changing gravity: value (1, 2) m/s2" in str(scene)
    assert_refused("changing gravity has 3 components", scene.changing_gravity, (1.0, 2.0, 3.0))
    assert_refused("t ", ancf.solve_static, scene, t=math.nan)
    scene, rod = build_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.01), SOFT, "clamp")
    scene.changing_gravity(lambda t: (0.0, 1.0) if t < 1.0 else (0.0, math.inf))
    assert_refused("changing gravity", ancf.solve_static, scene, error=LoadError, t=2.0)
