"""Steps start from the last acceleration, or the one before where accelerations alternate."""

import numpy as np
import pytest

import ancfsparse as ancf
from benchmarks.stability.scenes import pushed, truss


def stretching(speed):
    """A stiff bar that turns, and stretches at first at a speed [m/s]."""
    scene, rod = truss(1e10).scene, truss(1e10).rod

    def velocity(points):
        return rod.velocity(points) + speed * points / rod.length

    return scene.replaced(scene.beams[0], velocity=velocity)


def test_stiff_vibrations_that_alternate_are_foreseen():
    # The stretching of a stiff bar changes sides in each step of the trapezoidal rule.  Started
    # from the last acceleration alone, steps took 3.2 corrections.
    run = ancf.simulate(
        stretching(1e-3), 2.0, 0.01, integrator=ancf.Newmark(0.0), solver=ancf.Newton()
    )
    last, before = (np.linalg.norm(run.a[k:] - run.a[:-k], axis=1) for k in (1, 2))
    assert np.median(before[1:]) < 0.5 * np.median(last)
    assert run.stats.iterations_per_step < 2.5


def test_a_vibration_that_alternates_is_foreseen_after_two_steps():
    # The first step stores the acceleration before it, the second compares, the third is closer.
    iterations = [
        ancf.simulate(
            stretching(5e-3), n * 0.01, 0.01, integrator=ancf.Newmark(0.0), solver=ancf.Newton()
        ).stats.iterations
        for n in (1, 2, 3, 4)
    ]
    first, second, third = np.diff(iterations)
    assert first > second == third


@pytest.mark.parametrize("solver", ["auto", ancf.QuasiNewton("bfgs", 10)], ids=str)
def test_a_stiff_body_after_a_push_needs_damped_newton_rarely(solver):
    # Started from the last acceleration alone, up to 17 of its 100 steps did.
    run = ancf.simulate(pushed(1e10).scene, 2.0, 0.02, integrator=ancf.Newmark(0.0), solver=solver)
    rungs = [event.rung for event in run.stats.events]
    assert sum(rung != "new seed" for rung in rungs) <= 2
