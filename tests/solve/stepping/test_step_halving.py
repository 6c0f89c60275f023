"""Steps that cannot be solved are crossed in shorter ones, if that is allowed, and listed."""

import itertools
import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import double_pendulum_bob, pendulum
from ancfsparse.solve.recovery.step_halving import StepHalving

FEW = ancf.Newton(max_iterations=2)  # not enough for a step of 8 ms, enough for one of 1 ms
ONE = ancf.Newton(max_iterations=1)  # nor are the four of the last attempt enough for 40 ms


def run(dt, most, solver=FEW, **options):
    scene, rod = pendulum("thin")
    scene.point_force(rod.end, lambda t: (0.0, math.sin(5.0 * t)))
    found = ancf.simulate(
        scene, 0.8, dt, solver=solver, tolerance=1e-4, max_halvings=most, **options
    )
    return found.position(rod.end), found


def test_without_leave_the_run_ends():
    with pytest.raises(ancf.StepError, match="also with a new seed and with damped Newton"):
        run(4e-2, 0, ONE)


def test_crossed_steps_follow_the_motion_and_are_listed():
    tip, found = run(8e-3, 5)
    exact, _ = run(2.5e-4, 0)
    assert len(found.t) == 101
    assert found.stats.steps == 100
    assert f"100 steps, {found.stats.short_steps} shorter ones, " in repr(found)
    assert found.stats.iterations_per_step < 2.0 + FEW.max_iterations
    crossed = [event for event in found.stats.events if "steps of" in event.rung]
    assert 1 <= len(crossed) <= 100
    parts = sum(int(event.rung.split()[0]) for event in crossed)  # at most, if all are as short
    assert 2 * len(crossed) <= found.stats.short_steps <= parts
    assert {event.cause for event in crossed} == {"too many"}
    assert all(event.time == pytest.approx(event.step * 8e-3) for event in crossed)
    assert max(event.step for event in found.stats.events) <= 100
    # As exact as steps of that length are: 8 ms make 1e-2 m of error.
    assert np.abs(tip - exact[::32]).max() < 2e-2


def test_a_step_is_divided_into_half_as_many_parts_as_the_last_one_at_first(monkeypatch):
    change, tried = StepHalving._change, [[]]

    def record(halving, dt):
        parts = round(4e-2 / dt)
        tried.append([]) if parts == 1 else tried[-1].append(parts)
        change(halving, dt)

    monkeypatch.setattr(StepHalving, "_change", record)
    run(4e-2, 6)
    assert any(parts[-1] == 8 for parts in tried[:-2])
    for last, parts in itertools.pairwise(tried[:-1]):
        assert parts[0] == max(last[-1] // 2, 2)


def test_states_are_saved_at_the_same_times():
    _, every = run(8e-3, 5)
    _, some = run(8e-3, 5, save_every=7)
    rows = [*range(0, 101, 7), 100]
    np.testing.assert_allclose(some.t, every.t[rows], atol=1e-15)
    np.testing.assert_array_equal(some.q, every.q[rows])


def test_too_few_halvings_end_the_run_too():
    with pytest.raises(ancf.StepError) as caught:
        run(8e-2, 1, ONE)
    path = caught.value.trajectory
    assert len(path.t) == caught.value.step
    # A state from inside a step is none of the run.
    with pytest.raises(ancf.StepError) as caught:
        run(8e-2, 1, ONE, save_every=1000)
    np.testing.assert_array_equal(caught.value.trajectory.t, [0.0])
    with pytest.raises(ancf.InputError, match="max_halvings"):
        run(8e-3, -1)


def test_parts_of_a_step_are_solved_by_newton_too():
    # With constraints on a rigid body, a failed step is tried with compliant ones before Newton,
    # but its parts are not.
    scene = double_pendulum_bob(4).scene
    solver = ancf.QuasiNewton("broyden", max_iterations=3)
    found = ancf.simulate(
        scene, 0.5, 0.05, integrator=ancf.GeneralizedAlpha(0.8), solver=solver, tolerance=1e-4,
        max_halvings=3,
    )  # fmt: skip
    assert found.stats.steps == 10
    assert found.stats.short_steps > 0
