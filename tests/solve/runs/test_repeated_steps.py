"""Steps before one that fails are repeated by Newton's method, from an exact copy of a state."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear import Outcome
from ancfsparse.solve.motion import fixed_step_run
from ancfsparse.solve.recovery import checkpoints

STEPS, DT = 60, 2e-3


@pytest.fixture(autouse=True)
def short_chunks(monkeypatch):
    monkeypatch.setattr(fixed_step_run, "MAX_CHUNK", 10)
    monkeypatch.setattr(checkpoints, "MIN_REPEATED_CHUNK", 10)


class Failure:
    """Lets the step after a number of them fail, once; `step` counts those before it."""

    def __init__(self, after):
        self.after, self.step, self.advance = after, None, fixed_step_run.FixedStepRun._advance

    def __call__(self, run, end):
        outcome = self.advance(run, end)
        if run.stats.steps < self.after or self.step is not None:
            return outcome
        self.step = run.stats.steps
        return Outcome.TOO_MANY


@pytest.fixture
def failure(monkeypatch):
    failure = Failure(after=50)
    monkeypatch.setattr(fixed_step_run.FixedStepRun, "_advance", lambda *args: failure(*args))
    return failure


def dragged_over_drum(stop=lambda t: None):
    """Return a cable that is dragged over a turning drum, with friction of bristles.

    The function is called with the times of the force at its end.
    """
    scene = ancf.Scene(gravity=(0.0, -9.81))
    cable = scene.add_beam(
        "thin", (-0.5, 0.105), (0.5, 0.105), 10,
        section=ancf.Circle(0.01), material=ancf.Material(1e8, 1000.0),
    )  # fmt: skip
    scene.contact(
        cable, ancf.Drum((0.0, 0.0), 0.1, angular_velocity=2.0), stiffness=1e6, friction=0.3
    )
    scene.drive(
        cable.start, lambda t: (-0.5 + 2.0 * t * t, 0.105),
        rate=lambda t: (4.0 * t, 0.0), second_rate=lambda t: (4.0, 0.0),
    )  # fmt: skip
    scene.point_force(cable.end, lambda t: stop(t) or (0.1 * np.sin(40.0 * t), 0.0))
    return scene


def simulate(scene, solver="auto", t_end=STEPS * DT, **options):
    return ancf.simulate(
        scene, t_end, DT, integrator=ancf.GeneralizedAlpha(0.8), solver=solver,
        max_halvings=0, **options,
    )  # fmt: skip


@pytest.mark.parametrize("every", [1, 7])
def test_a_repetition_continues_by_newtons_method(failure, tmp_path, every):
    again = simulate(dragged_over_drum(), save_every=every, output=tmp_path / "run.h5")
    (event,) = [each for each in again.stats.events if "Newton from" in each.rung]
    # Checkpoints are 5 steps or more apart, where a chunk ends; two are kept.
    back = int(event.rung.split()[3]) - 1
    assert (event.step, event.cause) == (failure.step + 1, "too many")
    assert 5 <= failure.step - back <= 20
    assert again.stats.steps == STEPS
    first = simulate(dragged_over_drum(), t_end=back * DT)
    last = simulate(dragged_over_drum(), ancf.Newton(), start=first.last)
    rows = [*range(0, STEPS, every), STEPS] if every > 1 else range(STEPS + 1)
    np.testing.assert_allclose(again.t, DT * np.array(rows), atol=1e-15)
    for name in ("q", "v", "a", "lam", "internal"):
        states = np.concatenate([getattr(first, name)[:], getattr(last, name)[1:]])
        np.testing.assert_array_equal(getattr(again, name)[:], states[rows])


def test_a_repetition_is_the_run_by_newton(failure, monkeypatch):
    monkeypatch.setattr(fixed_step_run, "MAX_CHUNK", 30)
    failure.after = 30
    again = simulate(dragged_over_drum())
    assert failure.step == 30
    newton = simulate(dragged_over_drum(), ancf.Newton())
    for name in ("t", "q", "v", "a", "lam", "internal"):
        np.testing.assert_array_equal(getattr(again, name)[:], getattr(newton, name)[:])


def test_the_method_returns_after_the_failed_step(failure):
    failure.after = 21
    again = simulate(dragged_over_drum())
    newton = simulate(dragged_over_drum(), ancf.Newton())
    assert "modified Newton" in again.stats.solver
    assert again.stats.factorizations < 0.8 * newton.stats.factorizations
    assert len([each for each in again.stats.events if "Newton from" in each.rung]) == 1


def test_newtons_own_failure_ends_the_run(failure):
    with pytest.raises(ancf.ConvergenceError) as stopped:
        simulate(dragged_over_drum(), ancf.Newton())
    assert len(stopped.value.trajectory.t) == failure.step + 1


def test_large_systems_have_no_checkpoints(failure, monkeypatch):
    monkeypatch.setattr(checkpoints, "MIN_REPEATED_CHUNK", 11)
    with pytest.raises(ancf.ConvergenceError):
        simulate(dragged_over_drum())


def test_nor_have_they_after_a_return_to_a_snapshot(failure, monkeypatch):
    monkeypatch.setattr(checkpoints, "MIN_REPEATED_CHUNK", 11)
    sim = ancf.Simulation(
        dragged_over_drum(), DT, integrator=ancf.GeneralizedAlpha(0.8), max_halvings=0
    )
    sim.restore(sim.snapshot())
    with pytest.raises(ancf.ConvergenceError):
        sim.step(STEPS)


def test_an_interruption_before_the_failed_step_returns_to_the_first_states(failure):
    def stop(t):
        if failure.step and t > 45 * DT:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as stopped:
        simulate(dragged_over_drum(stop))
    path = stopped.value.trajectory
    assert len(path.t) == failure.step + 1 == 51
    assert path.stats.steps == 50
    assert not any("Newton from" in each.rung for each in path.stats.events)
    np.testing.assert_array_equal(path.q[:], simulate(dragged_over_drum(), t_end=50 * DT).q[:])
    np.testing.assert_array_equal(path.last.q, path.q[-1])


@pytest.mark.parametrize("every", [1, 4])
def test_a_load_that_fails_after_the_failed_step_ends_the_repeated_states(failure, every):
    def stop(t):
        if failure.step and t > 55.5 * DT:
            raise ValueError("no load")

    with pytest.raises(ancf.LoadError) as stopped:
        simulate(dragged_over_drum(stop), save_every=every)
    path = stopped.value.trajectory
    (event,) = [each for each in path.stats.events if "Newton from" in each.rung]
    back = int(event.rung.split()[3]) - 1
    assert path.stats.steps == 55
    first = simulate(dragged_over_drum(), t_end=back * DT)
    last = simulate(dragged_over_drum(), ancf.Newton(), start=first.last)
    states = np.concatenate([first.q[:], last.q[1 : 56 - back]])
    rows = [*range(0, 56, every), 55] if every > 1 else range(56)
    np.testing.assert_array_equal(path.q[:], states[rows])


def test_a_load_that_fails_in_the_repeated_steps_returns_to_the_first_states(failure):
    def stop(t):
        if failure.step and 35.5 * DT < t < 36.5 * DT:
            raise ValueError("no load")

    with pytest.raises(ancf.LoadError) as stopped:
        simulate(dragged_over_drum(stop))
    assert len(stopped.value.trajectory.t) == failure.step + 1
