"""Forces of driven joints at saved times: as exact as the motion, through jumps of its jerk."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

import ancfsparse as ancf

G, MASS, LENGTH, TURN = 9.81, 2.0, 1.0, 2.0
IMPLICIT = [
    ancf.GeneralizedAlpha(0.9),
    ancf.GeneralizedAlpha(0.5),
    ancf.HHT(0.1),
    ancf.Newmark(0.0),
    ancf.EnergyMomentum(),
]


def driven_rod(by_numbering, start=0.0):
    """A hinged rod whose third derivative jumps at 0 and 1 s; its drive."""
    scene = ancf.Scene((0.0, -G))
    if by_numbering:  # with the inertia of the rod, and a coordinate that remains free
        body = scene.add_body(
            position=(0, 0), centre=(LENGTH / 2, 0), mass=MASS, inertia=MASS * LENGTH**2 / 12
        )
    else:
        body = scene.add_body(ancf.Rod(LENGTH), position=(0, 0), mass=MASS)
    return scene, scene.drive_joint(scene.pin(body.origin), ancf.Ramp(TURN, 1.0, smooth=True))


def moment(t):
    x = np.minimum(t, 1.0)
    angle = TURN * x**3 * (10 - 15 * x + 6 * x * x)
    acceleration = TURN * 60 * x * (1 - x) * (1 - 2 * x)
    return MASS * LENGTH**2 / 3 * acceleration + MASS * G * LENGTH / 2 * np.cos(angle)


@pytest.mark.parametrize("integrator", IMPLICIT, ids=repr)
@pytest.mark.parametrize("by_numbering", [False, True])
def test_the_moment_of_a_drive_is_of_second_order_through_jumps_of_the_jerk(
    integrator, by_numbering
):
    errors = []
    for dt in (4e-3, 2e-3):
        scene, drive = driven_rod(by_numbering)
        run = ancf.simulate(
            scene, 1.4, dt, integrator=integrator, solver=ancf.Newton(), tolerance=1e-12
        )
        errors.append(np.max(np.abs(run.joint_force(drive).moment - moment(run.t))))
    assert errors[1] < 3e-4  # it was .43 N m with rho_inf = .9, and 9 N m with the trapezoidal rule
    assert errors[1] < max(errors[0] / 3.0, 1e-9)


def four_bar_in_the_plane():
    """A linkage of three rods, driven at its crank."""
    scene = ancf.Scene((0.0, -G))
    bars = [((0, 0), 0.5, np.pi / 2), ((0, 0.5), 1.0, 0.0), ((1, 0.5), 0.7, -np.pi / 2)]
    crank, coupler, rocker = (
        scene.add_body(ancf.Rod(length), mass=1.0, position=place, orientation=angle)
        for place, length, angle in bars
    )
    hinge = scene.pin(crank.origin)
    scene.connect(crank.end, coupler.origin)
    scene.connect(coupler.end, rocker.origin)
    scene.pin(rocker.end)
    return scene, scene.drive_joint(hinge, ancf.Ramp(-0.6, 1.0, smooth=True))


@cache
def exact_moment(make):
    scene, drive = make()
    run = ancf.simulate(scene, 1.2, 2e-3, integrator=ancf.DormandPrince())
    return run.joint_force(drive).moment


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(1.0), *IMPLICIT], ids=repr)
@pytest.mark.parametrize("make", [lambda: driven_rod(False), four_bar_in_the_plane])
@pytest.mark.parametrize("dt", [2e-3, 2.5e-4])
def test_the_moment_of_a_drive_is_exact_to_the_motion_at_the_default_tolerance(
    integrator, make, dt
):
    scene, drive = make()
    run = ancf.simulate(scene, 1.2, dt, integrator=integrator, save_every=round(2e-3 / dt))
    off = run.joint_force(drive).moment - exact_moment(make)
    # Of 10 N m; with the trapezoidal rule it was 1e-4 with 2 ms and 9e-4 with 0.25 ms.
    assert np.max(np.abs(off)) < 1e-8


def four_bar_in_space():
    """A square of boxes on four parallel hinges, three equations of which repeat others."""
    scene = ancf.Scene((0.0, 0.0, -G))
    bars = [
        ((0.5, 0, 0), (1.0, 0.05)),
        ((1.0, 0, 0.5), (0.05, 1.0)),
        ((0.5, 0, 1.0), (1.0, 0.05)),
    ]
    crank, coupler, rocker = (
        scene.add_body(ancf.Box(length=x, width=0.05, height=z), mass=1.0, position=centre)
        for centre, (x, z) in bars
    )
    hinge = scene.revolute(crank.at((-0.5, 0, 0)), axis=(0, 1, 0))
    scene.revolute(crank.at((0.5, 0, 0)), coupler.at((0, 0, -0.5)), axis=(0, 1, 0))
    scene.revolute(coupler.at((0, 0, 0.5)), rocker.at((0.5, 0, 0)), axis=(0, 1, 0))
    scene.revolute(rocker.at((-0.5, 0, 0)), axis=(0, 1, 0))
    return scene, scene.drive_joint(hinge, ancf.Ramp(-0.8, 1.0, smooth=True))


@pytest.mark.filterwarnings("ignore::ancfsparse.errors.RedundantConstraintsWarning")
@pytest.mark.parametrize("integrator", [ancf.Newmark(0.0), ancf.EnergyMomentum()], ids=repr)
def test_redundant_equations_leave_the_moment_of_a_drive_right(integrator):
    scene, drive = four_bar_in_space()
    run = ancf.simulate(scene, 1.2, 4e-3, integrator=integrator)
    scene, drive_then = four_bar_in_space()
    exact = ancf.simulate(scene, 1.2, 4e-3, integrator=ancf.DormandPrince())
    difference = run.joint_force(drive).moment - exact.joint_force(drive_then).moment
    assert np.max(np.abs(difference[:, 1])) < 2e-3  # of 27 N m; it was 10 with Newmark(0)


@pytest.mark.parametrize(
    "integrator", [ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum()], ids=repr
)
def test_a_file_gives_the_moments_of_a_drive_without_rates(tmp_path, integrator):
    def build():
        scene = ancf.Scene((0.0, -G))
        body = scene.add_body(ancf.Rod(LENGTH), position=(0, 0), mass=MASS)
        return scene, scene.drive_joint(scene.pin(body.origin), lambda t: 2.0 * t**3)

    scene, drive = build()
    run = ancf.simulate(scene, 0.5, 1e-2, integrator=integrator, output=tmp_path / "run.h5")
    scene, drive_then = build()
    read = ancf.load(tmp_path / "run.h5", scene)
    expected = run.joint_force(drive).moment
    np.testing.assert_allclose(read.joint_force(drive_then).moment, expected, rtol=1e-12)
    np.testing.assert_allclose(read.energy.work, run.energy.work, rtol=1e-12)
