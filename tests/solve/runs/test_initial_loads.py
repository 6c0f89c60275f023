"""Loads that are there from the start on bodies stiffer than a step can follow; their events."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.error_control.best_solution import add_counts
from ancfsparse.solve.error_control.implicit_integration import ImplicitIntegration
from ancfsparse.system import System


def clamped(stiffness, force, side=0.02, density=7850.0, damping=0.0):
    """A clamped beam of 1 m with a force on its end."""
    scene = ancf.Scene((0.0, 0.0))
    material = ancf.Material(stiffness, density, bending_damping=damping, axial_damping=damping)
    rod = scene.add_beam("thin", (0, 0), (1, 0), 10, ancf.Rectangle(side, side), material)
    scene.clamp(rod.start)
    scene.point_force(rod.end, force)
    return scene, rod


@pytest.mark.parametrize("solver", ["auto", ancf.Newton()], ids=str)
@pytest.mark.parametrize("dt", [2e-3, 1e-2, 5e-2, 0.1])
def test_a_sudden_dead_load_on_a_stiff_beam_ends_at_rest(dt, solver):
    # F L^3 / (3 EI), within what large turns make of it; omega dt is up to 10 in the first mode.
    scene, rod = clamped(2e11, (0.0, -10.0))
    run = ancf.simulate(scene, 10.0, dt, solver=solver, integrator=ancf.GeneralizedAlpha(0.5))
    still = -10.0 / (3.0 * 2e11 * 0.02**4 / 12.0)
    reached = run.position(rod.end)[run.t > 8.0, 1].mean()
    assert reached == pytest.approx(still, rel=0.1 if dt < 5e-3 else 0.02)
    assert run.position(rod.end)[:, 1].min() > 2.2 * still  # never thrown away


def test_the_state_saved_at_the_start_is_in_balance():
    scene, _ = clamped(2e11, (0.0, -10.0))
    system = System(scene)
    run = ancf.simulate(scene, 0.1, 0.05, integrator=ancf.GeneralizedAlpha(0.5))
    zero = np.zeros(0)
    r, _ = system.assembly.residual(run.q[0], run.v[0], run.a[0], zero, system.dead_load, zero)
    assert np.abs(r[: system.n_free]).max() < 1e-9


@pytest.mark.parametrize("integrator", [ancf.Newmark(), ancf.GeneralizedAlpha(0.9)], ids=repr)
def test_a_start_under_damping_and_load_is_of_second_order(integrator):
    scene, rod = clamped(1e8, (0.0, -0.5), density=4000.0, damping=5e-3)
    exact = ancf.simulate(scene, 0.2, 1e-5, save_every=400).position(rod.end)
    errors = []
    for dt in (1e-3, 5e-4, 2.5e-4):
        run = ancf.simulate(scene, 0.2, dt, integrator=integrator, save_every=round(4e-3 / dt))
        errors.append(np.abs(run.position(rod.end) - exact).max())
    assert np.diff(np.log2(errors)) == pytest.approx([-2.0, -2.0], abs=0.2)


def test_a_step_that_would_gain_energy_can_be_crossed_in_shorter_ones():
    # A load that strikes within one long step of the trapezoidal rule.
    scene, _ = clamped(1e8, lambda t: (0.0, -150.0 * (t > 0.05)), density=4000.0)
    with pytest.raises(ancf.StepError, match="max_halvings"):
        ancf.simulate(scene, 0.4, 2e-2, integrator=ancf.Newmark())
    run = ancf.simulate(scene, 0.4, 2e-2, integrator=ancf.Newmark(), max_halvings=8)
    crossed = [event for event in run.stats.events if "steps of" in event.rung]
    assert crossed
    assert {event.cause for event in crossed} <= {
        "gained energy", "too many", "diverged", "not finite", "indefinite",
    }  # fmt: skip


@pytest.mark.parametrize("load", [140.0, 145.0, 175.0, 180.0, 200.0])
def test_shorter_steps_are_tried_before_descent(load):
    # Descent finds a solution of the long steps that follow the jump; these runs then failed.
    scene, _ = clamped(1e8, lambda t: (0.0, -load * (t > 0.05)), density=4000.0)
    run = ancf.simulate(scene, 0.4, 2e-2, integrator=ancf.Newmark(), max_halvings=8)
    rungs = {event.rung for event in run.stats.events}
    assert any("steps of" in rung for rung in rungs)
    assert "descent" not in rungs


def test_runs_to_an_accuracy_name_their_events(monkeypatch):
    # Too few corrections for many steps; each is listed under its number among those accepted.
    scene, _ = clamped(1e8, lambda t: (0.0, -50.0 * math.sin(20.0 * t)), density=4000.0)
    runs = []
    plain = ImplicitIntegration.run

    def watched(stepper):
        runs.append(stepper.stats)
        return plain(stepper)

    monkeypatch.setattr(ImplicitIntegration, "run", watched)
    run = ancf.simulate(scene, 0.2, accuracy=1e-4, solver=ancf.ModifiedNewton(max_iterations=2))
    events = run.stats.events
    assert run.stats.recoveries > 0
    assert len({event.step for event in events}) > 0
    assert len(runs) == run.stats.runs > 1
    assert events == [
        event._replace(step=event.step + sum(stats.steps for stats in runs[:k]))
        for k, stats in enumerate(runs) for event in stats.events
    ][:1000]  # fmt: skip
    for stats in runs:
        assert all(0 < event.step <= stats.steps + 1 for event in stats.events)
        steps = [event.step for event in stats.events]
        assert steps == sorted(steps)
        times = [event.time for event in stats.events]
        assert times[-1] > times[0]


def test_no_more_than_a_thousand_events_are_kept():
    total, stats = ancf.results.RunStats(), ancf.results.RunStats(steps=700)
    stats.events = [ancf.results.Event(k, 0.1 * k, "new seed", "too many", 0.5) for k in range(700)]
    add_counts(total, stats)
    add_counts(total, stats)
    assert len(total.events) == 1000
    assert total.events[700].step == 700


def test_an_abandoned_run_to_an_accuracy_is_an_event(monkeypatch):
    # Here the first run has gained energy; the next ones have shorter steps.
    scene, _ = clamped(1e8, (0.0, -0.5), density=4000.0)
    plain, done = ImplicitIntegration.run, []

    def fails_once(stepper):
        if not done:
            done.append(stepper)
            raise ancf.errors.EnergyIncreaseError(1.0, 2.0, 0.01, 0.1, 7, 1e-3)
        return plain(stepper)

    monkeypatch.setattr(ImplicitIntegration, "run", fails_once)
    run = ancf.simulate(scene, 0.1, accuracy=1e-4, integrator=ancf.GeneralizedAlpha(0.9))
    first = run.stats.events[0]
    assert (first.step, first.time, first.rung, first.cause) == (
        7, 0.1, "shorter steps", "gained energy",
    )  # fmt: skip
