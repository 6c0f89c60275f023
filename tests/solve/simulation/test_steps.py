"""A simulation takes the steps of `simulate` one by one; results, conditions and errors."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.motion import simulation as module
from ancfsparse.solve.preparation import choose_factorization
from ancfsparse.solve.preparation.switch_to_direct import SwitchToDirect
from tests.solve.simulation.scenes import (
    INTEGRATORS,
    SCENES,
    cable_on_drum,
    hanging_body,
    pendulum,
    same,
)


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
@pytest.mark.parametrize("name", SCENES)
def test_steps_are_those_of_simulate(name, integrator):
    make, dt = SCENES[name]
    run = ancf.simulate(make(), 120 * dt, dt, integrator=integrator)
    sim = ancf.Simulation(make(), dt, integrator=integrator)
    sim.step(50)
    for _ in range(70):
        sim.step()
    assert same(sim.state, run.last)
    assert sim.t == run.t[-1]
    assert sim.steps == 120


def test_costs_of_seeds_are_compared_at_the_steps_of_simulate(monkeypatch):
    monkeypatch.setattr(choose_factorization, "_may_fill_in", lambda *_: True)
    monkeypatch.setattr(choose_factorization, "_fills_in", lambda *_: True)
    compare, solves = SwitchToDirect.is_cheaper, []

    def is_cheaper(back, counts, inner):
        solves.append(counts["solves"])
        return compare(back, counts, inner)

    monkeypatch.setattr(SwitchToDirect, "is_cheaper", is_cheaper)
    ancf.simulate(pendulum()[0], 0.06, 1e-3)
    expected = solves[:3]  # after 5, 15 and 35 steps
    solves.clear()
    sim = ancf.Simulation(pendulum()[0], 1e-3)
    for n in (1, 2, 7, 1, 20, 20):
        sim.step(n)
    assert solves[:3] == expected


def test_explicit_steps_are_those_of_simulate():
    run = ancf.simulate(pendulum()[0], 0.01, 1e-5, integrator=ancf.CentralDifference())
    sim = ancf.Simulation(pendulum()[0], 1e-5, integrator=ancf.CentralDifference())
    sim.step(999)
    sim.step()
    assert same(sim.state, run.last)


def test_results_are_those_of_the_last_state_of_a_run():
    scene = hanging_body()
    body, rod = scene.bodies
    pin, joint = scene.joints[:2]
    run = ancf.simulate(scene, 0.05, 1e-3)
    sim = ancf.Simulation(scene, 1e-3)
    sim.run_until(0.05)
    for name in ("position", "velocity", "acceleration", "displacement"):
        expected = getattr(run, name)(rod.end)[-1]
        assert np.array_equal(getattr(sim, name)(rod.end), expected), name
    assert np.array_equal(sim.slope(rod.end), run.slope(rod.end)[-1])
    for each in (pin, joint):
        assert np.array_equal(sim.joint_force(each).force, run.joint_force(each).force[-1])
    assert np.array_equal(sim.section_force(rod, 0.5).N, run.section_force(rod, 0.5).N[-1])
    assert np.array_equal(sim.strain(rod, 0.5), run.strain(rod, 0.5)[-1])
    assert np.array_equal(sim.multipliers, run.multipliers[-1])
    assert np.array_equal(sim.body(body).velocity[0], run.body(body).velocity[-1])
    assert repr(sim) == "Simulation: t = 0.05 s after 50 steps of 0.001 s"


def test_contacts_are_those_of_the_last_state_of_a_run():
    sim = ancf.Simulation(cable_on_drum(), 5e-4)
    sim.run_until(lambda sim: len(sim.contacts()) > 0)
    run = ancf.simulate(cable_on_drum(), sim.t, 5e-4)
    assert str(sim.contacts()) == str(run.contacts())


def test_a_simulation_continues_from_a_run_and_a_run_from_it():
    run = ancf.simulate(hanging_body(), 0.04, 1e-3)
    sim = ancf.Simulation(hanging_body(), 1e-3, start=run.last)
    sim.step(20)
    other = ancf.simulate(hanging_body(), 0.1, 1e-3, start=sim.state)
    whole = ancf.simulate(hanging_body(), 0.1, 1e-3)
    assert np.max(np.abs(other.q[-1] - whole.q[-1])) < 1e-6


def test_functions_are_called_after_their_steps():
    sim = ancf.Simulation(pendulum()[0], 1e-3)
    each, third = [], []
    sim.on_step(lambda sim: each.append(sim.steps))
    sim.on_step(lambda sim: third.append(sim.t), every=3)
    sim.step(7)
    assert each == [1, 2, 3, 4, 5, 6, 7]
    assert third == [0.003, 0.006]


def test_a_simulation_runs_until_a_condition_holds():
    scene, rod = pendulum()
    sim = ancf.Simulation(scene, 1e-3)
    sim.run_until(lambda sim: sim.position(rod.end)[0] < 0.0)
    assert sim.position(rod.end)[0] < 0.0
    last = ancf.simulate(scene, sim.t - 1e-3, 1e-3)
    assert last.position(rod.end)[-1, 0] >= 0.0


def test_a_failed_step_keeps_the_state_and_a_snapshot_is_returned_to():
    load = ancf.Input(2)
    scene, _ = pendulum(load)
    sim = ancf.Simulation(scene, 1e-3)
    sim.step(10)
    before, state = sim.snapshot(), sim.state
    sim.set(load, (1e200, 0.0))
    with pytest.raises(ancf.StepError) as failure:
        sim.step(5)
    assert same(sim.state, state)
    assert failure.value.trajectory.t[-1] == sim.t == state.t
    with pytest.raises(ancf.InputError, match=r"ended at t = 0.01 s .* restore a snapshot"):
        sim.step()
    assert repr(sim).endswith("ended by an error")
    sim.restore(before)
    sim.step(5)
    assert sim.steps == 15


@pytest.mark.parametrize("max_halvings", [0, 4])
def test_a_step_that_fails_in_parts_keeps_the_state(max_halvings):
    fails = [True]

    def force(x, v, t):
        # The first half of the step from 100 ms on can be taken.  A part after it has no solution,
        # since the force moves the end to the other side of its place.
        return -1e6 * np.sign(x - state.q[-4:-2]) if fails[0] and t > 0.1051 else 0.0 * x

    scene, rod = pendulum()
    scene.force([rod.end], force)
    damped = ancf.GeneralizedAlpha(0.9)
    sim = ancf.Simulation(scene, 1e-2, integrator=damped, max_halvings=max_halvings)
    sim.step(10)
    state = sim.state
    with pytest.raises(ancf.ConvergenceError):
        sim.step(5)
    assert same(sim.state, state)
    assert sim.t == sim.state.t == state.t
    after = sim.snapshot()
    fails[0] = False
    sim.restore(after)
    sim.step(5)
    run = ancf.simulate(scene, 0.15, 1e-2, integrator=damped)
    assert np.max(np.abs(sim.q - run.q[-1])) < 1e-6


def test_a_function_that_has_failed_is_called_again():
    fails = [True]

    def force(x, v, t):
        if fails[0] and t > 0.0205:
            raise ValueError("no force")
        return 0.0 * x

    scene, rod = pendulum()
    scene.force([rod.end], force)
    sim = ancf.Simulation(scene, 1e-3)
    sim.step(10)
    before = sim.snapshot()
    for _ in range(2):
        with pytest.raises(ancf.LoadError, match="no force"):
            sim.step(20)
        assert sim.steps == 20
    fails[0] = False
    sim.step(10)
    last = sim.state
    sim.restore(before)
    sim.step(20)
    assert np.max(np.abs(sim.q - last.q)) < 1e-6


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda sim: sim.step(0), "n must be"),
        (lambda sim: sim.run_until(0.0), "after the present t = 0 s, got 0 s: try 0.001 s"),
        (lambda sim: sim.run_until(0.0015), "number of steps of 0.001 s"),
        (lambda sim: sim.on_step(3), "on_step needs a function"),
        (lambda sim: sim.set(ancf.Input(2, name="other"), 1.0), "its inputs are: tip"),
        (lambda sim: sim.set(3, 1.0), "3 is not an input of this scene"),
        (lambda sim: sim.restore(3), "needs a snapshot of this simulation"),
        (lambda sim: sim.set(ancf.Input(2, name="tip"), 1.0), "the value of tip"),
        (lambda sim: sim.set(ancf.Input(2, name="tip"), (1, 2), over=0.0), "over must be"),
        (lambda sim: sim.set(ancf.Input(2, name="tip"), (1, 2), over=1e300), "over must lie"),
        (lambda sim: sim.run_real_time(0.01, factor=0.0), "factor must be"),
    ],
)
def test_invalid_calls_are_refused(call, message):
    sim = ancf.Simulation(pendulum(ancf.Input(2, name="tip"))[0], 1e-3)
    with pytest.raises(ancf.InputError, match=message):
        call(sim)
    assert sim.steps == 0


def test_missed_times_are_counted(monkeypatch):
    clock = [0.0]

    def sleep(seconds):
        clock[0] += seconds

    monkeypatch.setattr(module.time, "perf_counter", lambda: clock[0])
    monkeypatch.setattr(module.time, "sleep", sleep)
    sim = ancf.Simulation(pendulum()[0], 1e-3)

    def delay(sim):
        clock[0] += 0.25e-3 if sim.steps != 5 else 3.6e-3

    sim.on_step(delay)
    report = sim.run_real_time(0.01, factor=2.0)
    # The fifth step ends 3.1 ms late, and each later one takes half of its time.
    assert (report.steps, report.missed) == (10, 6)
    assert report.latest == pytest.approx(3.1e-3)
    assert clock[0] == pytest.approx(0.004 / 2 + 3.6e-3 + 5 * 0.25e-3)
