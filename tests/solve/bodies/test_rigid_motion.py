"""Motions of rigid bodies against formulas and against independent integrations."""

import numpy as np
import pytest
from scipy.special import ellipk

import ancfsparse as ancf
from ancfsparse.problems import heavy_top
from tests.beams import build_beam

TIGHT = 1e-12
# A top by Euler's equations, I = diag(2, 3, 4), omega = (1e-3, 5, 0) at t = 0, in the frame of the
# body at t = 10 s: DOP853 at rtol 1e-12, and natural coordinates; good to 1e-7 rad/s.
TOP = (0.003232663, -4.999998740, -0.002173719)
G = 9.81


def top(omega=1e-3):
    scene = ancf.Scene((0.0, 0.0, 0.0))
    return scene, scene.add_body(
        inertia=(2, 3, 4), mass=6.0, position=(0, 0, 0), angular_velocity=(omega, 5, 0)
    )


def test_an_asymmetric_top_against_eulers_equations():
    """Second order to the reference; momenta and energy kept by energy-momentum to rounding."""
    off = []
    for dt in (0.01, 0.005):
        scene, body = top()
        run = ancf.simulate(scene, 10.0, dt, integrator=ancf.EnergyMomentum(), tolerance=TIGHT)
        motion = run.body(body)
        off.append(np.max(np.abs(motion.angular_velocity_in_body[-1] - TOP)))
        moment = motion.angular_momentum
        assert np.max(np.abs(moment - (0.002, 15.0, 0.0))) < 1e-10
        assert np.max(np.abs(motion.kinetic_energy - 37.500001)) < 1e-9
        rotation = motion.rotation
        unit = np.einsum("kji,kjl->kil", rotation, rotation)
        assert np.max(np.abs(unit - np.eye(3))) < 1e-12
    assert 3.9 < off[0] / off[1] < 4.1
    assert off[1] < 5e-6


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_body_turned_by_a_quarter_of_a_turn_hangs_on_another_one(sign):
    """Its unit vectors are orthogonal to rounding only, where all terms of a product vanish."""
    scene = ancf.Scene((0.0, 0.0, -G))
    plate = scene.add_body(inertia=(2, 3, 4), mass=6.0, position=(0, 0, 0))
    body = scene.add_body(
        inertia=(2, 3, 4), mass=6.0, position=(0, 0, 0),
        orientation=np.sqrt(0.5) * np.array([1.0, 0.0, 0.0, sign]),
    )  # fmt: skip
    scene.revolute(plate.origin, axis=(0, 1, 0))
    scene.revolute(body.origin, plate.origin, axis=(0, 1, 0))
    scene.point_moment(body.origin, (0.0, 0.2, 0.0))
    run = ancf.simulate(scene, 1.0, 1e-3, integrator=ancf.EnergyMomentum())
    np.testing.assert_allclose(run.body(body).angular_velocity[-1], (0, 0.1, 0), atol=1e-9)


@pytest.mark.parametrize(("omega", "n_flips"), [(1e-3, 1), (0.1, 2)])
def test_flips_are_where_elliptic_functions_put_them(omega, n_flips):
    """omega_2 = 0 at K/n and 3 K/n (Landau and Lifshitz, Mechanics, 37), from two steps.

    Between them errors grow with exp(2.04 t): with the smaller omega_1, whose flips are 11 s apart,
    those of rounding grow to 1e-5 s.
    """
    energy, moment = 2 * omega**2 + 3 * 25.0, (2 * omega) ** 2 + 15.0**2  # twice, and squared
    n = np.sqrt((4 * energy - moment) / 24.0)
    quarter = ellipk((moment - 2 * energy) / (4 * energy - moment)) / n
    assert omega > 1e-3 or quarter == pytest.approx(5.520889721, abs=1e-9)
    zeros = []
    for dt in (2e-3, 1e-3):
        scene, body = top(omega)
        end = np.ceil(1.1 * (2 * n_flips - 1) * quarter)
        run = ancf.simulate(scene, end, dt, integrator=ancf.EnergyMomentum(), tolerance=TIGHT)
        spin = run.body(body).angular_velocity_in_body[:, 1]
        k = np.flatnonzero(np.diff(np.sign(spin)))
        zeros.append(run.t[k] - spin[k] * dt / (spin[k + 1] - spin[k]))
    found = zeros[1] + (zeros[1] - zeros[0]) / 3.0
    np.testing.assert_allclose(found, (quarter, 3 * quarter)[:n_flips], rtol=0.0, atol=2e-8)


@pytest.mark.parametrize("integrator", [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9)])
def test_a_planar_rod_swings(integrator):
    """End at t = 0.5, 1 and 2 s of a rod of 1 m, pinned, from horizontal rest.

    Reference: natural coordinates and the pendulum's equation by DOP853 at rtol 1e-12, to 1e-8 m.
    """
    reference = [
        (-0.0902292086, -0.9959210259),
        (-0.9999665881, -0.0081745177),
        (0.9994654895, -0.0326915167),
    ]
    off = []
    for dt in (2e-3, 1e-3):
        scene = ancf.Scene((0.0, -G))
        rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
        scene.pin(rod.origin)
        run = ancf.simulate(scene, 2.0, dt, integrator=integrator, tolerance=TIGHT)
        at = [round(t / dt) for t in (0.5, 1.0, 2.0)]
        off.append(np.max(np.abs(run.position(rod.end)[at] - reference)))
    assert 3.8 < off[0] / off[1] < 4.2
    assert off[1] < 2e-5


def pendulum(at_origin):
    """Box 1 x 0.2 x 0.1 m of 2 kg, pinned at a corner: that is its origin, or a point of it."""
    scene, corner = ancf.Scene((0.0, 0.0, -G)), np.array([0.5, 0.1, 0.05])
    omega = np.array([1.0, 2.0, 3.0])
    if at_origin:
        moments = 2.0 / 12 * np.array([0.2**2 + 0.1**2, 1 + 0.1**2, 1 + 0.2**2])
        body = scene.add_body(
            inertia=moments, mass=2.0, centre=corner, position=(0, 0, 0), angular_velocity=omega
        )
        scene.pin(body.origin)
        return scene, body
    body = scene.add_body(
        ancf.Box(length=1.0, width=0.1, height=0.2),
        mass=2.0,
        position=corner,
        velocity=np.cross(omega, corner),
        angular_velocity=omega,
    )
    scene.pin(body.at(-corner))
    return scene, body


@pytest.mark.parametrize("at_origin", [True, False])
def test_a_spatial_pendulum(at_origin):
    """Centre at 0.5 and 2 s: two formulations by DOP853 at rtol 1e-12, to 1e-8 m."""
    off = []
    for dt in (2e-3, 1e-3):
        scene, body = pendulum(at_origin)
        run = ancf.simulate(scene, 2.0, dt, integrator=ancf.EnergyMomentum(), tolerance=TIGHT)
        motion = run.body(body)
        reference = [
            (-0.3588445982, -0.1132165865, -0.3477248322),
            (-0.4672929732, -0.1624837349, -0.1331777500),
        ]
        off.append(np.max(np.abs(motion.centre[[round(0.5 / dt), -1]] - reference)))
        energy = motion.kinetic_energy + 2.0 * G * motion.centre[:, 2]
        assert np.max(np.abs(energy - 5.0543333333)) < 1e-9
    assert 3.8 < off[0] / off[1] < 4.2
    assert off[1] < 1e-5


def test_momenta_of_what_pushes_each_other():
    """Two bodies and a spring in free space keep momentum, angular momentum and energy.

    The energy after the first step, at whose start velocities are set to what the formulas of the
    integrator give a smooth motion.
    """
    scene = ancf.Scene((0.0, 0.0, 0.0))
    one = scene.add_body(
        ancf.Box(length=0.3, width=0.1, height=0.2),
        mass=2.0,
        position=(0, 0, 0),
        angular_velocity=(1, 2, 3),
    )
    two = scene.add_body(ancf.Rod(0.5), mass=1.0, position=(1, 0, 0), velocity=(0, 1, 0))
    scene.spring(one.at((0.1, 0.1, 0.05)), two.end, stiffness=50.0)
    run = ancf.simulate(scene, 2.0, 5e-3, integrator=ancf.EnergyMomentum(), tolerance=TIGHT)
    motions = [run.body(each) for each in (one, two)]
    for name in ("momentum", "angular_momentum"):
        total = sum(getattr(each, name) for each in motions)
        assert np.max(np.abs(total - total[0])) < 1e-10
    energy = run.energy.total
    assert np.max(np.abs(energy[1:] - energy[1])) < 1e-9 * energy[0]
    assert abs(energy[1] - energy[0]) < 1e-6 * energy[0]


def test_a_moment_turns_a_body():
    """The rate of the angular momentum is the moment; an angle grows with its square in time."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    body = scene.add_body(
        inertia=(2, 3, 4), mass=6.0, position=(0, 0, 0), angular_velocity=(0.3, -0.2, 0.5)
    )
    scene.point_moment(body.origin, (1.0, -2.0, 3.0))
    run = ancf.simulate(scene, 1.0, 2e-3, integrator=ancf.GeneralizedAlpha(0.9), tolerance=TIGHT)
    moment = run.body(body).angular_momentum
    grown = moment - moment[0] - run.t[:, None] * (1.0, -2.0, 3.0)
    assert np.max(np.abs(grown)) < 2e-5
    flat = ancf.Scene((0.0, 0.0))
    disc = flat.add_body(ancf.Cylinder(1.0, 0.1), mass=4.0, position=(0, 0))
    flat.point_moment(disc.origin, 3.0)
    run = ancf.simulate(flat, 1.0, 1e-3, integrator=ancf.GeneralizedAlpha(0.9), tolerance=TIGHT)
    np.testing.assert_allclose(run.body(disc).angles, 0.5 * 3.0 / 2.0 * run.t**2, atol=2e-6)


def test_a_cable_hangs_on_a_body():
    """A heavy disc on a pinned cable: at rest, the cable carries both weights."""
    scene, cable = build_beam(
        "thin", (0, 0), (0, -1), 4, ancf.Circle(0.01), ancf.Material(1e8, 1000.0), gravity=(0.0, -G)
    )
    disc = scene.add_body(ancf.Cylinder(0.1, 0.02), mass=3.0, position=(0, -1.1))
    scene.pin(cable.start)
    scene.connect(cable.end, disc.at((0, 0.1)))
    run = ancf.simulate(scene, 0.5, 1e-3, integrator=ancf.GeneralizedAlpha(0.5), tolerance=1e-10)
    weight = G * (3.0 + 1000.0 * np.pi * 0.01**2)
    assert abs(run.reaction(cable.start)[-100:, 1].mean() / weight - 1.0) < 0.05


def test_a_flat_body_to_an_accuracy():
    """The heavy top is a disc, whose mass matrix is singular; its centre after 0.2 s, to 1e-8 m.

    Data of Exudyn's test heavyTop after Terze (2016); two formulations by DOP853 at rtol 1e-12.
    """
    top = heavy_top()
    body, accuracy = top.bodies["disc"], 1e-2
    run = ancf.simulate(top.scene, 0.2, 0.05, accuracy=accuracy)
    apart = run.body(body).centre[-1] - (0.605550561, 0.598957682, -0.523983027)
    assert np.linalg.norm(apart) < 2.0 * accuracy


# Bodies that joints hold still move by rounding alone, and no watch may take that for a gain.
INTEGRATORS = [ancf.GeneralizedAlpha(0.9), ancf.Newmark(alpha=0.0), ancf.EnergyMomentum()]


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_hanging_body_stays_and_its_pin_bears_its_weight(integrator, size):
    """Pinned above its centre at rest, in three units of length; 3 kg at 9.81 m/s2."""
    scene = ancf.Scene((0.0, 0.0, -9.81 * size))
    body = scene.add_body(
        ancf.Box(length=0.2 * size, width=size, height=0.2 * size), mass=3.0, position=(0, 0, size)
    )
    scene.pin(body.at((0.0, 0.0, 0.5 * size)))
    run = ancf.simulate(scene, 0.05, 1e-3, integrator=integrator)
    motion = run.body(body)
    assert np.max(np.abs(motion.centre - (0.0, 0.0, size))) < 1e-13 * size
    np.testing.assert_allclose(
        run.reaction(body.origin)[-1], (0, 0, 29.43 * size), atol=1e-9 * size
    )


def welded():
    """Welded beside its origin and turned, without gravity: all that moves is rounding."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    body = scene.add_body(
        ancf.Box(length=0.2, width=1.0, height=0.2),
        mass=3.0,
        position=(0.3, 0.1, 0.7),
        orientation=(0.5, 0.5, 0.5, 0.5),
    )
    scene.weld(body.at((0.0, 0.1, 0.5)))
    return scene, body


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_force_that_changes_works_on_no_body_that_is_held(integrator):
    scene, body = welded()
    scene.point_force(body.origin, ancf.Ramp((1.0, 0.0, 3.0), 0.02, smooth=True))
    run = ancf.simulate(scene, 0.05, 1e-3, integrator=integrator)
    assert np.ptp(run.body(body).centre, axis=0).max() < 1e-13


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_a_run_of_a_held_body_can_be_continued(integrator):
    """Its velocities are the rounding of places over the step, and nothing to compare them with."""
    scene, body = welded()
    scene.point_force(body.origin, ancf.Sine((1.0, 0.0, 3.0), 20.0))
    start = None
    for end in (0.1, 0.2, 0.3):
        start = ancf.simulate(scene, end, 1e-3, integrator=integrator, start=start).last
    assert np.max(np.abs(start.q - start.layout.q_ref)) < 1e-13
