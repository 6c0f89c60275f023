"""Loads and lengths that a simulation sets in each step."""

import threading

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear import Outcome
from ancfsparse.solve.motion import fixed_step_run
from ancfsparse.solve.recovery import checkpoints
from tests.solve.simulation.scenes import STEEL, pendulum, same


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum()])
def test_a_load_that_is_set_in_each_step_is_that_of_a_table(integrator, rng):
    dt, values = 1e-3, rng.uniform(-1.0, 1.0, (101, 2))
    values[:2] = 0.0
    table = ancf.Table(dt * np.arange(101), values, outside="hold")
    scene, rod = pendulum(table)
    run = ancf.simulate(scene, 0.1, dt, integrator=integrator)
    load = ancf.Input(2)
    scene, other = pendulum(load)
    sim = ancf.Simulation(scene, dt, integrator=integrator)
    for value in values[1:]:
        sim.set(load, value)
        sim.step()
        assert np.array_equal(sim.value(load), value)
    moved = np.max(np.abs(run.displacement(rod.end)))
    assert np.max(np.abs(sim.position(other.end) - run.position(rod.end)[-1])) < 1e-13 * moved


def weight_on_a_winch():
    length = ancf.Input(default=1.0, name="length")
    scene = ancf.Scene((0, 0, -9.81))
    load = scene.add_body(mass=2.0, inertia=0.01 * np.eye(3), position=(0, 0, -1.0))
    winch = scene.winch([(0, 0, 0), load.origin], length=length)
    return scene, load, winch, length


def test_a_length_moves_with_the_rates_that_are_set():
    scene, load, winch, length = weight_on_a_winch()
    sim = ancf.Simulation(scene, 1e-3)
    sim.set(length, 0.95, rate=-0.5, over=0.2)  # then it continues
    sim.run_until(0.3)
    assert sim.position(load.origin)[2] == pytest.approx(-0.9, abs=1e-9)
    assert sim.velocity(load.origin)[2] == pytest.approx(0.5, abs=1e-6)
    assert sim.tension(winch) == pytest.approx(2.0 * 9.81, rel=1e-6)
    sim.set(length, 0.8, over=0.2)
    sim.run_until(0.4)
    x = np.linspace(0.0, 1.0, 1001)
    cubic, quartic, quintic = np.linalg.solve(
        [[1, 1, 1], [3, 4, 5], [6, 12, 20]], [0.8 - 0.9 + 0.1, 0.1, 0.0]
    )
    course = 0.9 - 0.1 * x + cubic * x**3 + quartic * x**4 + quintic * x**5
    second = (6 * cubic * x + 12 * quartic * x**2 + 20 * quintic * x**3) / 0.2**2
    assert sim.position(load.origin)[2] == pytest.approx(-course[500], abs=1e-9)
    assert sim.tension(winch) == pytest.approx(2.0 * (9.81 - second[500]), rel=1e-4)


def test_a_rate_alone_determines_the_value():
    scene, load, _, length = weight_on_a_winch()
    sim = ancf.Simulation(scene, 1e-3)
    sim.set(length, rate=-0.5, over=0.2)
    assert sim.value(length) == 1.0
    sim.run_until(0.3)
    assert sim.value(length) == pytest.approx(1.0 - 0.5 * 0.3, abs=1e-12)
    assert sim.position(load.origin)[2] == pytest.approx(-0.85, abs=1e-9)
    for rate in (0.25, -0.5, 0.0):
        before = sim.value(length)
        sim.set(length, rate=rate)
        sim.step()
        assert sim.value(length) == pytest.approx(before + 1e-3 * rate, abs=1e-12)
    with pytest.raises(ancf.InputError, match="set needs a value, a rate, or both"):
        sim.set(length)


def test_forces_of_joints_follow_from_the_inputs():
    push = ancf.Input(2)
    scene, rod = pendulum()
    (pin,) = scene.joints
    scene.point_force(rod.start, push)
    sim = ancf.Simulation(scene, 1e-3)
    free = ancf.simulate(scene, 0.02, 1e-3)
    sim.set(push, (3.0, -2.0))  # at the pin, which takes it
    sim.run_until(0.02)
    expected = free.joint_force(pin).force[-1] - (3.0, -2.0)
    assert sim.joint_force(pin).force == pytest.approx(expected, rel=1e-12)
    assert sim.reaction(rod.start) == pytest.approx(expected, rel=1e-12)


def test_section_forces_and_tensions_follow_from_the_inputs():
    strain, length = ancf.Input(), ancf.Input(default=1.0)
    scene = ancf.Scene((0, 0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, ancf.Circle(0.01), STEEL, eigenstrain=strain)
    scene.clamp(rod.start)
    scene.pin(rod.end)
    rope = scene.rope([(1, 1), rod.end], stiffness=100.0, length=length)
    sim = ancf.Simulation(scene, 1e-3)
    sim.set(strain, 1e-3)
    sim.set(length, 0.8)
    sim.step()
    assert sim.section_force(rod, 0.5).N == pytest.approx(-1e-3 * 1e7 * rod.section.area, rel=1e-3)
    assert sim.tension(rope) == pytest.approx(100.0 * (1.0 / 0.8 - 1.0), rel=1e-9)


def test_inputs_of_one_name_are_one_input():
    scene, _ = pendulum(ancf.Input(2, default=(0.0, 1.0), name="tip"))
    sim = ancf.Simulation(scene, 1e-3)
    assert np.array_equal(sim.value(ancf.Input(name="tip")), (0.0, 1.0))
    with pytest.raises(ancf.InputError, match="value of tip"):
        sim.set(ancf.Input(name="tip"), 2.0)
    scene.point_force(scene.bodies[0].at(0.5), ancf.Input(2, name="tip"))
    with pytest.raises(ancf.InputError, match="inputs of one name are one input"):
        ancf.Simulation(scene, 1e-3)


def test_an_input_that_is_not_set_has_its_default():
    scene, load, winch, _ = weight_on_a_winch()
    run = ancf.simulate(scene, 0.05, 1e-3)
    assert run.position(load.origin)[-1, 2] == pytest.approx(-1.0, abs=1e-12)
    assert run.tension(winch)[-1] == pytest.approx(2.0 * 9.81, rel=1e-9)


def test_inputs_return_with_a_snapshot():
    scene, _, _, length = weight_on_a_winch()
    sim = ancf.Simulation(scene, 1e-3)
    sim.set(length, 0.9, over=0.1)
    sim.step(50)
    before = sim.snapshot()
    sim.step(20)
    first = sim.state
    sim.set(length, 1.1)
    sim.step(5)
    sim.restore(before)
    sim.step(20)
    assert same(sim.state, first)


def test_a_scene_with_inputs_is_read_as_it_was_written(tmp_path):
    scene, *_, length = weight_on_a_winch()
    scene.save(tmp_path / "winch.json")
    loaded = ancf.Scene.load(tmp_path / "winch.json")
    sim = ancf.Simulation(loaded, 1e-3)
    sim.set(length, 0.9, over=0.1)
    sim.step(100)
    assert sim.position(loaded.bodies[0].origin)[2] == pytest.approx(-0.9, abs=1e-9)


def test_simulations_of_one_scene_have_their_own_inputs():
    load = ancf.Input(2)
    scene, rod = pendulum(load)
    sims = [ancf.Simulation(scene, 1e-3) for _ in range(2)]
    barrier = threading.Barrier(2)

    def move(sim, value):
        for _ in range(50):
            barrier.wait()
            sim.set(load, value)
            sim.step()

    values = (0.0, 1.0), (0.0, -1.0)
    threads = [threading.Thread(target=move, args=each) for each in zip(sims, values, strict=True)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    alone = ancf.Simulation(scene, 1e-3)
    for _ in range(50):
        alone.set(load, values[1])
        alone.step()
    assert np.array_equal(sims[1].q, alone.q)
    assert sims[0].position(rod.end)[1] > sims[1].position(rod.end)[1] + 1e-4


@pytest.mark.parametrize("last_change", [48, 0])
def test_steps_with_earlier_inputs_are_not_repeated(monkeypatch, last_change):
    monkeypatch.setattr(fixed_step_run, "MAX_CHUNK", 10)
    monkeypatch.setattr(checkpoints, "MIN_REPEATED_CHUNK", 10)
    load, advance, failed = ancf.Input(2), fixed_step_run.FixedStepRun._advance, []

    def fail_once(run, end):
        outcome = advance(run, end)
        if run.steps < 50 or failed:
            return outcome
        failed.append(run.steps)
        return Outcome.TOO_MANY

    monkeypatch.setattr(fixed_step_run.FixedStepRun, "_advance", fail_once)
    sim = ancf.Simulation(pendulum(load)[0], 1e-3, max_halvings=0)
    for k in range(49):
        if k <= last_change:
            sim.set(load, (0.0, np.sin(0.3 * (k + 1))))
        sim.step()
    if last_change:
        with pytest.raises(ancf.ConvergenceError):
            sim.step()
        assert sim.stats.events == []
        return
    for _ in range(2):  # repeats the last steps, whose input is known
        sim.step()
    assert [each.cause for each in sim.stats.events] == ["too many"]
    table = ancf.Table((0.0, 1e-3, 1.0), [(0, 0), (0, np.sin(0.3)), (0, np.sin(0.3))])
    run = ancf.simulate(pendulum(table)[0], sim.t, 1e-3, solver=ancf.Newton())
    assert np.max(np.abs(sim.q - run.q[-1])) < 1e-4


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"size": 4}, "size of an input must be 1, 2 or 3"),
        ({"size": 2, "default": (1.0,)}, "default of input"),
        ({"default": np.nan}, "default of input"),
        ({"default": [None, []]}, "default of input"),
        ({"name": 3}, "name of an input must be a text"),
    ],
)
def test_invalid_inputs_are_refused(arguments, message):
    with pytest.raises(ancf.InputError, match=message):
        ancf.Input(**arguments)


def test_an_input_without_a_name_is_none_of_those_in_a_file(tmp_path):
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, ancf.Circle(0.01), ancf.Material(1e7, 1e3))
    last = int(ancf.Input(2).name.removeprefix("input "))
    scene.point_force(rod.end, ancf.Input(2, name=f"input {last + 5}"))
    scene.save(tmp_path / "scene.json")
    again = ancf.Scene.load(tmp_path / "scene.json")
    other = ancf.Input(2)
    assert other.name == f"input {last + 6}"
    again.point_force(again.beams[0].start, other)
    assert len(ancf.Simulation(again, 1e-3)._inputs) == 2
