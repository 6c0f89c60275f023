"""Supports that move as prescribed, and rods whose length is."""

from __future__ import annotations

import math
import tomllib
from functools import partial
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

import ancfsparse as ancf
from ancfsparse.results.hdf5_reader import load
from tests.beams import build_beam
from tests.paths import REFERENCES
from tests.solve.forces.carriers import MOVE, pendulum
from tests.solve.refusals import assert_refused

MOVING_SUPPORTS = REFERENCES / "moving_supports.toml"
NEWTON = ancf.Newton()
INTEGRATORS = [
    ancf.GeneralizedAlpha(0.9),
    ancf.Newmark(0.0),
    ancf.HHT(0.1),
    ancf.EnergyMomentum(),
]


def hanging(as_constraint=False):
    """Return the cable of the references, its right end where it lies straight in `q_ref`."""
    material, section = ancf.Material(1e8, 4000.0), ancf.Rectangle(0.01, 0.01)
    scene, rod = build_beam("thin", (0, 0), (2.2, 0), 16, section, material, "pin", strain="biot")
    ramp = ancf.Ramp((0.15, -0.15), 0.5, smooth=True) + np.array([2.0, 0.0])
    scene.drive(rod.end, ramp, as_constraint=as_constraint)
    return scene, rod


@pytest.mark.parametrize("as_constraint", [False, True])
def test_a_hanging_cable_follows_its_support_as_in_exudyn(as_constraint):
    known = tomllib.loads(MOVING_SUPPORTS.read_text(encoding="utf-8"))
    scene, rod = hanging(as_constraint)
    rest, middle = ancf.solve_static(scene, tolerance=1e-12), rod.node(8)
    at_rest, pull = known["rest"], known["pull"]
    np.testing.assert_allclose(rest.position(middle), at_rest["middle"], atol=at_rest["tolerance"])
    np.testing.assert_allclose(rest.reaction(rod.end), pull["rest"], atol=pull["tolerance"])
    motion, runs = known["motion"], []
    for dt in (2e-4, 1e-4):
        options = {"integrator": ancf.GeneralizedAlpha(0.95), "solver": NEWTON, "start": rest}
        run = ancf.simulate(scene, 1.0, dt, save_every=round(0.25 / dt), **options)
        runs.append(run.position(middle)[1:])
    extrapolated = (4.0 * runs[1] - runs[0]) / 3.0
    expected = [motion[time] for time in ("0.25", "0.5", "0.75", "1.0")]
    np.testing.assert_allclose(extrapolated, expected, atol=motion["tolerance"])


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum()])
def test_a_slack_cable_stays_at_rest(integrator):
    material, section = ancf.Material(1e8, 4000.0), ancf.Rectangle(0.01, 0.01)
    scene, rod = build_beam("thin", (0, 0), (2.2, 0), 16, section, material, "pin")
    scene.drive(rod.end, (2.0, 0.0))
    rest = ancf.solve_static(scene, tolerance=1e-12)
    assert rest.position(rod.at(1.1))[1] < -0.4
    run = ancf.simulate(scene, 10.0, 0.01, start=rest, integrator=integrator)
    assert np.max(np.abs(run.q - rest.q)) < 1e-9


def rigid(motion, length, times):
    """Return the end of a rigid rod that falls from rest beside its support, by SciPy."""

    def rates(t, state):
        ax, ay = motion.rate(t, 2)
        pull = (9.81 + ay) * math.cos(state[0]) - ax * math.sin(state[0])
        return [state[1], -1.5 / length * pull]

    options = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13, "max_step": 0.01}
    angle = solve_ivp(rates, (0.0, times[-1]), [0.0, 0.0], t_eval=times, **options).y[0]
    arm = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.array([motion(t) for t in times]) + length * arm


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum()])
@pytest.mark.parametrize("motion", [MOVE, ancf.Sine((0.05, 0.1), 0.7)])
def test_a_stiff_pendulum_is_a_rigid_one(integrator, motion):
    material, section = ancf.Material(1e14, 4000.0), ancf.Rectangle(0.1, 0.1)
    velocity = tuple(motion.rate(0.0))
    scene, rod = build_beam("thin", (0, 0), (1, 0), 1, section, material, velocity=velocity)
    scene.drive(rod.start, motion)
    run = ancf.simulate(scene, 1.0, 1e-4, integrator=integrator)
    rows = np.arange(0, len(run.t), 1000)
    apart = run.position(rod.end)[rows] - rigid(motion, 1.0, run.t[rows])
    assert np.max(np.abs(apart)) < 1e-6


def both_ways(integrator, dt, t_end, save_every=1):
    """Return runs and rods of a support moved by numbering and by equations."""
    pairs = []
    for as_constraint in (False, True):
        scene, rod = pendulum(as_constraint=as_constraint)
        options = {"integrator": integrator, "solver": NEWTON, "save_every": save_every}
        run = ancf.simulate(scene, t_end, dt, **options)
        np.testing.assert_allclose(run.position(rod.start), MOVE(run.t), atol=1e-9)
        pairs.append((run, rod))
    return pairs


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_equations_move_a_support_as_numbering_does(integrator):
    (free, rod), (led, other) = both_ways(integrator, 5e-4, 0.6, save_every=5)
    apart = np.linalg.norm(free.position(rod.end) - led.position(other.end), axis=1)
    assert np.max(apart) < 2e-6
    # The trapezoidal rule keeps what iterations leave of multipliers for ever.
    forces = free.reaction(rod.start), led.reaction(other.start)
    assert np.max(np.abs(forces[0] - forces[1])) < 0.02 * np.max(np.abs(forces[1]))


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.HHT(0.1)], ids=repr)
def test_reactions_equal_multipliers_to_second_order(integrator):
    apart = []
    for dt in (1e-3, 5e-4):
        (free, rod), (led, other) = both_ways(integrator, dt, 0.39)
        forces = free.reaction(rod.start), led.reaction(other.start)
        apart.append(np.max(np.abs(forces[0] - forces[1])) / np.max(np.abs(forces[1])))
    assert apart[1] < 1e-4
    assert math.log2(apart[0] / apart[1]) > 1.7


@pytest.mark.parametrize("as_constraint", [False, True])
@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
def test_the_energy_balances_with_the_work_of_a_drive_to_second_order(integrator, as_constraint):
    left = []
    for dt in (2e-3, 1e-3, 5e-4):
        scene, _ = pendulum(as_constraint=as_constraint)
        run = ancf.simulate(scene, 0.6, dt, integrator=integrator, solver=NEWTON)
        energy, watch = run.energy, run.last.memory["watch"]
        assert watch["work"] > 0.5
        gain = energy.total[-1] - energy.total[0] - watch["work"]
        left.append(abs(gain) / float(energy.kinetic.max()))
        if not isinstance(integrator, ancf.EnergyMomentum):
            np.testing.assert_allclose(energy.work[-1], watch["work"], rtol=0.02 * left[-1])
    if isinstance(integrator, ancf.EnergyMomentum) and as_constraint:
        assert max(left) < 1e-9  # it keeps the balance at any step
        return
    orders = [math.log2(coarse / fine) for coarse, fine in pairwise(left)]
    assert min(orders) > 1.8
    assert left[0] < 2e-2


def test_differences_stand_for_rates_to_fourth_order():
    swing = ancf.Sine((0.1, 0.05), 1.0, -0.5 * math.pi) + np.array([0.1, 0.05])
    apart = []
    for dt in (2e-2, 1e-2):
        runs = []
        for motion in (swing, lambda t: tuple(swing(t))):
            scene, rod = pendulum(motion, youngs_modulus=1e5)
            run = ancf.simulate(scene, 0.8, dt)
            runs.append((run.velocity(rod.start), run.acceleration(rod.start)))
        apart.append([np.max(np.abs(one - other)) for one, other in zip(*runs, strict=True)])
    (coarse_v, coarse_a), (fine_v, fine_a) = apart
    assert math.log2(coarse_v / fine_v) > 4.5
    assert math.log2(coarse_a / fine_a) > 3.5
    assert fine_a < 1e-2


@pytest.mark.parametrize("dt", [1e-2, 1e-3, 1e-4])
@pytest.mark.parametrize("path", [lambda t: t * t, lambda t: 0.1 * (1 - math.cos(5 * t))])
def test_differences_at_the_start_are_believed_as_far_as_they_are_exact(path, dt):
    # Both set out from rest, and differences of them have a rate: of rounding, and of their order.
    scene, rod = pendulum(lambda t: (path(t), 2.15 + path(t)), as_constraint=True, start=(0, 2.15))
    run = ancf.simulate(scene, 0.05, dt)
    expected = [[path(t), 2.15 + path(t)] for t in run.t]
    np.testing.assert_allclose(run.position(rod.start), expected, atol=1e-10)
    scene, _ = pendulum(lambda t: (1e-5 * t, 0.0), as_constraint=True)
    assert_refused(r"velocities violate the drive .* by 1e-05 m/s", ancf.simulate, scene, 0.05, dt)


def test_given_rates_are_those_of_a_signal():
    scene, rod = pendulum(
        lambda t: MOVE(t), rate=lambda t: MOVE.rate(t), second_rate=lambda t: MOVE.rate(t, 2)
    )
    known, other = pendulum()
    run, same = (ancf.simulate(each, 0.5, 1e-3, solver=NEWTON) for each in (scene, known))
    np.testing.assert_array_equal(run.position(rod.end), same.position(other.end))


def test_a_spline_moves_a_support():
    times = np.linspace(0.0, 0.5, 11)
    spline = CubicSpline(times, np.array([MOVE(t) for t in times]), bc_type="clamped")
    scene, rod = pendulum(spline, rate=spline.derivative(1), second_rate=spline.derivative(2))
    run = ancf.simulate(scene, 0.5, 1e-3)
    np.testing.assert_allclose(run.position(rod.start), spline(run.t), atol=1e-14)
    np.testing.assert_allclose(run.velocity(rod.start), spline(run.t, 1), atol=1e-14)
    np.testing.assert_allclose(run.acceleration(rod.start), spline(run.t, 2), atol=1e-14)
    assert run.energy.drift < 5e-3


def test_a_stiff_damped_body_starts_along_with_its_support():
    speed = np.array([0.0, 3.0])
    scene = ancf.Scene(gravity=(0.0, 0.0))
    material = ancf.Material(1e10, 4000.0, axial_damping=1e-3, bending_damping=1e-3)
    rod = scene.add_beam(
        "thin", (0, 0), (0, 2), 8, ancf.Rectangle(0.01, 0.01), material, velocity=speed
    )
    scene.drive(rod.start, lambda t: t * speed)
    run = ancf.simulate(scene, 0.5, 0.01)
    moved = run.position(rod.end) - np.array([0.0, 2.0]) - run.t[:, None] * speed
    assert np.max(np.abs(moved)) < 1e-9
    pulled = ancf.Scene(gravity=(0.0, 0.0))
    rod = pulled.add_beam("thin", (0, 0), (0, 2), 8, ancf.Rectangle(0.01, 0.01), material)
    pulled.drive(rod.start, lambda t: (0.0, -5.0 * t**2))
    run = ancf.simulate(pulled, 0.5, 0.01)
    # rho a L^2 / (2 E) is the stretch of the rod at rest beside its support, 8e-6 m.
    stretch = np.linalg.norm(run.position(rod.end) - run.position(rod.start), axis=1) - 2.0
    np.testing.assert_allclose(stretch[5:], 4000.0 * 10.0 * 4.0 / 2e10, rtol=0.1)
    assert np.max(stretch) < 2.0 * stretch[-1]
    force = 4000.0 * 1e-4 * 2.0 * 10.0
    np.testing.assert_allclose(run.reaction(rod.start)[5:, 1], -force, rtol=0.1)


def test_a_winch_lifts_a_bar():
    # The bar hangs along the rope, so it moves as a point: force m (g - l'').
    length = ancf.Ramp(-0.4, 0.5, smooth=True) + 1.0
    material, section = ancf.Material(1e9, 4000.0, axial_damping=1e-3), ancf.Rectangle(0.02, 0.02)
    scene, bar = build_beam("thin", (0, -1), (0, -2), 4, section, material)
    scene.rod(bar.start, (0.0, 0.0), length=length)
    run = ancf.simulate(scene, 0.6, 1e-3)
    np.testing.assert_allclose(run.position(bar.start)[:, 1], -length(run.t), atol=1e-9)
    mass = 4000.0 * 4e-4
    force = mass * (9.81 - length.rate(run.t, 2))
    later = slice(50, None)
    np.testing.assert_allclose(run.reaction(bar.start)[later, 1], force[later], rtol=0.02)
    assert run.energy.work[-1] == pytest.approx(mass * 9.81 * 0.4, rel=1e-3)
    assert run.energy.drift < 1e-3


def test_a_rod_of_a_length_that_stays_is_a_rod():
    ends = []
    for options in ({}, {"length": lambda t: math.sqrt(2.0)}):
        material, section = ancf.Material(1e7, 4000.0), ancf.Rectangle(0.01, 0.01)
        scene, bar = build_beam("thin", (1, 1), (2, 1), 4, section, material)
        scene.rod(bar.start, (0.0, 0.0), **options)
        run = ancf.simulate(scene, 0.5, 1e-3, solver=NEWTON)
        ends.append(run.position(bar.end))
    np.testing.assert_allclose(*ends, atol=1e-10)


def test_an_accuracy_holds_with_a_drive():
    scene, rod = pendulum()
    run = ancf.simulate(scene, 0.6, accuracy=1e-4)
    fine = ancf.simulate(scene, 0.6, 1e-4, solver=NEWTON)
    apart = run.position(rod.end)[-1] - fine.position(rod.end)[-1]
    assert np.linalg.norm(apart) < 1.2e-4


def test_an_accuracy_needs_rates():
    scene, _ = pendulum(lambda t: tuple(MOVE(t)))
    with pytest.raises(ancf.InputError, match=r"needs the rates .* the position of the drive at"):
        ancf.simulate(scene, 0.6, accuracy=1e-4)


@pytest.mark.parametrize("save", [{}, {"save_nodes": 1}])
def test_a_driven_run_is_read_back_from_its_file(tmp_path, save):
    swing = ancf.Sine((0.1, 0.05), 1.0, -0.5 * math.pi) + np.array([0.1, 0.05])
    scene, rod = pendulum(lambda t: tuple(swing(t)))
    options = {"save_nodes": [rod.start, rod.end]} if save else {}
    run = ancf.simulate(scene, 0.1, 1e-3, output=tmp_path / "run.h5", **options)
    same, other = pendulum(lambda t: tuple(swing(t)))
    again = load(tmp_path / "run.h5", same)
    np.testing.assert_array_equal(again.position(other.start), run.position(rod.start))
    np.testing.assert_array_equal(again.position(other.end), run.position(rod.end))


def refused(match, motion=MOVE, **options):
    """Assert that a sentence refuses a drive, or a run with it."""
    assert_refused(match, lambda: ancf.simulate(pendulum(motion, **options)[0], 0.1, 1e-3))


def test_bad_drives_are_refused():
    refused("whose acceleration is not continuous", ancf.Ramp((0.5, 0.3), 0.4))
    refused("whose acceleration is not continuous", ancf.Table([0, 1], [[0, 0], [1, 1]]))
    refused("whose acceleration", ancf.Pulse((0.5, 0.3), 0.1, 0.4) + MOVE)
    refused("begins at 2 m, and the motion starts at 0 m", MOVE + np.array([2.0, 0.0]))
    refused(r"begins with 0.7.* that is an impact", ancf.Sine((0.1, 0.1), 1.2))
    refused("give second_rate too", lambda t: (t, t), rate=lambda t: (1.0, 1.0))
    refused(r"rate of the position .* must be a function", lambda t: (t, t), rate=1, second_rate=2)
    refused(r"has shape \(\), but the scene is planar", lambda t: 1.0)
    scene, rod = pendulum()
    assert_refused("a drive needs a point on a beam", scene.drive, rod, (0.0, 0.0))


@pytest.mark.parametrize("held", ["end", "angle", "length"])
def test_the_advice_on_a_drive_that_begins_elsewhere_helps(held):
    """Also where a body that nothing holds falls beside it, so that there is no equilibrium."""
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), 4, ancf.Circle(0.01), ancf.Material(1e8, 1000.0), "pin"
    )
    ball = scene.add_body(position=(0.5, 1), mass=1.0, inertia=1.0)
    if held == "end":
        scene.drive(rod.end, (1.05, 0))
    elif held == "length":
        scene.rod(rod.end, (2, 0), length=lambda t: 0.95)
    else:
        arm = scene.add_body(position=(2, 0), mass=1.0, inertia=1.0)
        scene.drive_joint(scene.pin(arm.at((-0.5, 0))), lambda t: 0.3)
    with pytest.raises(ancf.InputError, match=r"take start=assemble\(scene\)"):
        ancf.simulate(scene, 0.1, 1e-3)
    run = ancf.simulate(scene, 0.1, 1e-3, start=ancf.assemble(scene))
    np.testing.assert_allclose(
        run.position(ball.origin)[-1], (0.5, 1 - 0.5 * 9.81 * 0.01), rtol=1e-3
    )


@pytest.mark.parametrize("steps", [100, 200, 400])
def test_errors_of_differences_are_no_impact(steps):
    """Over 1.2 s a rate of exactly 0 came out as 6 mm/s, and the smooth drive was refused."""
    far = 120.0
    for begins, motion in (
        (0.0, lambda t: (10.0 * math.sin(0.15 * t) * (t / (5.0 + t)) ** 3, 0.0)),
        (0.15, lambda t: (math.sin(0.15 * t), 0.0)),
        (0.3, lambda t: (0.3 * t, 0.0)),
    ):
        scene, line = build_beam(
            "thin", (0, 0), (0, -1000), 4, ancf.Circle(0.03), ancf.Material(1e11, 7000.0)
        )
        scene.drive(line.start, motion)
        marched = partial(ancf.simulate, scene, far, far / steps, start="equilibrium")
        if begins:
            assert_refused("is an impact", marched)
        else:
            run = marched()
            assert np.linalg.norm(run.velocity(line.start)[0]) < 0.05
            assert run.t[-1] == far


def test_a_node_is_not_held_twice_by_a_drive():
    scene, rod = pendulum()
    assert_refused("already fixes its position", scene.pin, rod.start)


@pytest.mark.parametrize("integrator", ["auto", ancf.RungeKuttaNystrom(4)])
def test_a_drive_that_fails_keeps_the_motion_so_far(integrator):
    def motion(t):
        if t > 0.2:
            raise ValueError("the motor is off")
        return (0.0, 0.0)

    rest = {"rate": lambda t: (0.0, 0.0), "second_rate": lambda t: (0.0, 0.0)}
    scene, _ = pendulum(motion, youngs_modulus=1e5, **rest)
    with pytest.raises(ancf.LoadError, match=r"the drive at beam 0 .*the motor is off") as stop:
        ancf.simulate(scene, 0.4, 1e-3, integrator=integrator)
    assert stop.value.trajectory.t[-1] == pytest.approx(0.2)


def test_a_drive_that_is_not_finite_is_named():
    scene, _ = pendulum(lambda t: (math.nan, 0.0) if t > 0.3 else (0.0, 0.0))
    assert_refused("the drive at beam 0", ancf.simulate, scene, 0.5, 1e-3, error=ancf.LoadError)
