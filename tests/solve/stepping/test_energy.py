"""The energy balance of runs."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from tests.beams import build_beam


@pytest.mark.parametrize(
    ("element", "options"),
    [("l2t2", {}), ("thin", {}), ("thin", {"strain": "biot"}), ("thin", {"dim": 3})],
)
def test_the_pendulum_keeps_its_energy(element, options):
    scene, _ = pendulum(element, **options)
    run = ancf.simulate(scene, 1.0, 2.5e-4, solver=ancf.Newton(), save_every=20)
    energy = run.energy
    assert energy.drift < 3e-5
    assert energy.kinetic[0] == 0.0
    assert energy.kinetic.max() > 5.0  # of 0.8 kg falling a metre
    np.testing.assert_array_equal(energy.work, 0.0)
    # What is lost in height is found elsewhere.
    fall = energy.potential[0] - energy.potential
    np.testing.assert_allclose(energy.kinetic + energy.elastic, fall, atol=1e-3)


def test_the_drift_is_of_second_order():
    drifts = []
    for dt in (5e-4, 2.5e-4, 1.25e-4):
        scene, _ = pendulum("l2t2")
        run = ancf.simulate(scene, 0.5, dt, solver=ancf.Newton(), tolerance=1e-9)
        drifts.append(run.energy.drift)
    assert drifts[0] > 3 * drifts[1] > 9 * drifts[2]


@pytest.mark.parametrize("changing", [False, True])
def test_work_of_a_force_becomes_energy(changing):
    # On a free straight beam along its axis: force times way.
    section, material = ancf.Rectangle(0.02, 0.02), ancf.Material(1e9, 1000.0)
    scene, rod = build_beam("thin", (0, 0), (2, 0), 4, section, material, gravity=(0.0, 0.0))
    force = np.array([3.0, -1.0])
    scene.distributed_force(rod, (lambda t: force / 2) if changing else force / 2)
    run = ancf.simulate(scene, 1.0, 1e-3)
    mass = 0.02**2 * 1000 * 2
    expected = force @ force / mass * run.t**2 / 2
    np.testing.assert_allclose(run.energy.work, expected, atol=1e-8)
    np.testing.assert_allclose(run.energy.kinetic, expected, atol=1e-8)
    assert run.energy.drift < 1e-9


@pytest.mark.parametrize("moment", [False, True])
def test_work_is_accounted_for_on_a_bending_beam(moment):
    scene, rod = pendulum("thin", 6)
    if moment:
        scene.point_moment(rod.end, 0.05)
    else:
        scene.point_force(rod.at(1.3), lambda t: (np.sin(5 * t), 2.0))
    run = ancf.simulate(scene, 0.5, 1.25e-4, solver=ancf.Newton())
    assert np.abs(run.energy.work).max() > 1e-2
    assert run.energy.drift < 1e-4


def test_work_of_a_moment_is_moment_times_angle():
    section, material = ancf.Rectangle(0.02, 0.02), ancf.Material(1e11, 1000.0)
    scene, rod = build_beam("thin", (0, 0), (1, 0), 2, section, material, "pin", gravity=(0.0, 0.0))
    scene.point_moment(rod.start, 2.0)
    run = ancf.simulate(
        scene, 0.3, 1e-4, integrator=ancf.Newmark(0.0), solver=ancf.Newton(), tolerance=1e-6
    )
    slope = run.slope(rod.start)
    angle = np.unwrap(np.arctan2(slope[:, 1], slope[:, 0]))
    assert angle[-1] > 0.1
    np.testing.assert_allclose(run.energy.work, 2.0 * angle, atol=2e-4 * angle.max())


def test_constraints_do_no_work():
    scene, rod = pendulum("l2t2", as_constraint=True)
    scene.rod(rod.end, (2.0, -1.5))
    run = ancf.simulate(scene, 0.3, 1e-4, solver=ancf.Newton(), save_every=10)
    assert run.energy.drift < 1e-3
