"""Runs to an accuracy where two motions agree: waves that implicit steps lose, and loads alone."""

import numpy as np
import pytest

import ancfsparse as ancf

SAVED = 50


def arm_and_beam(stiffness):
    """An arm on a hinge and a beam hinged to it, which fall; the beam vibrates along itself."""
    angle, length, arm = -0.351, 0.925, 0.3
    scene = ancf.Scene(gravity=(0, -9.81))
    knee = arm * np.array([np.cos(angle), np.sin(angle)])
    body = scene.add_body(ancf.Rod(arm), position=(0, 0), mass=0.544, orientation=angle)
    scene.pin(body.origin)
    material = ancf.Material(stiffness, 1500.0, 0.3)
    beam = scene.add_beam(
        "thin", knee, knee + np.array([length, 0.0]), 8, ancf.Circle(0.0188), material
    )
    scene.connect(beam.start, body.at((arm, 0)))
    return scene, beam


@pytest.mark.parametrize("stiffness", [1.657e8, 4e8])
@pytest.mark.parametrize("accuracy", [3e-5, 1e-5])
def test_waves_that_a_coarse_run_has_lost_remain_in_the_error(stiffness, accuracy):
    """Axial waves of 3e-5 m, hidden in a difference of 8e-5 m of slow motion."""
    t_end = 0.732
    dt = t_end / SAVED

    def motion(**options):
        scene, beam = arm_and_beam(stiffness)
        run = ancf.simulate(scene, t_end, options.pop("dt", dt), **options)
        return run, np.stack([run.position(beam.node(i)) for i in range(9)])

    limit = ancf.stable_step(arm_and_beam(stiffness)[0], ancf.DormandPrince())
    every = int(np.ceil(4.0 * dt / limit))
    exact = motion(dt=dt / every, integrator=ancf.DormandPrince(), save_every=every)[1]
    run, path = motion(accuracy=accuracy, integrator=ancf.GeneralizedAlpha(0.9))
    assert run.stats.error <= accuracy
    assert np.max(np.linalg.norm(path - exact, axis=2)) <= accuracy


def sine(t):
    return (np.pi * t - np.sin(np.pi * t)) / np.pi**2


def chirp(t):
    return t**4 / 12.0 + t**6 / 30.0


@pytest.mark.parametrize("accuracy", [1e-5, 1e-7, 1e-9, 1e-11])
@pytest.mark.parametrize(
    ("load", "exact"),
    [
        (lambda t: np.stack([np.sin(np.pi * t), 0 * t], axis=-1), sine),
        (lambda t: np.stack([t**2 + t**4, 0 * t], axis=-1), chirp),
    ],
)
@pytest.mark.parametrize("held", [True, False])
def test_what_loads_alone_move_without_stiffness(load, exact, accuracy, held):
    """Accelerations of two runs are equal, and the stable step is infinite: orders still differ."""
    scene = ancf.Scene(gravity=(0, 0))
    body = scene.add_body(position=(0, 0), mass=1.0, inertia=0.1)
    if held:
        scene.prismatic(body.origin, axis=(1, 0))
    scene.point_force(body.origin, load)
    run = ancf.simulate(scene, 1.0, accuracy=accuracy)
    assert run.stats.error <= accuracy
    assert np.max(np.abs(run.position(body.origin)[:, 0] - exact(run.t))) <= accuracy
