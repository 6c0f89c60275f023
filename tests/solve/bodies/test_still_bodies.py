"""Bodies that joints hold still move by rounding alone, and no watch may take that for a gain."""

import numpy as np
import pytest

import ancfsparse as ancf

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
