"""Runs to a given accuracy, against the same mesh solved with steps too short to count."""

import math
import pickle
import re

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.cli import main
from ancfsparse.errors import AccuracyFailure
from ancfsparse.problems import pendulum
from ancfsparse.solve.steps import RATIO, States, Stepper
from ancfsparse.system import System

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
T_END, TIMES = 1.0, 200


def swinging_pendulum():
    return pendulum("thin")[0]


def double_pendulum():
    scene = ancf.Scene((0.0, -9.81))
    upper = scene.add_beam("thin", (0, 0), (1, 0), 5, SECTION, MATERIAL)
    lower = scene.add_beam("thin", (1, 0), (2, 0), 5, SECTION, MATERIAL)
    scene.pin(upper.start)
    scene.connect(upper.end, lower.start)
    return scene


def spin_up():
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (2, 0), 8, SECTION, MATERIAL)
    scene.pin(rod.start)
    scene.point_moment(rod.start, lambda t: 2.0 * math.sin(math.pi * min(t, 1.0)) ** 2)
    return scene


def swinging_cable():
    def across(x):
        return np.stack([0 * x[:, 0], 0.5 * np.sin(np.pi * x[:, 0] / 3), 0 * x[:, 0]], axis=1)

    scene = ancf.Scene((0.0, 0.0, -9.81))
    cable = scene.add_beam("thin", (0, 0, 0), (3, 0, 0), 12, SECTION, MATERIAL, velocity=across)
    scene.pin(cable.start)
    scene.pin(cable.end)
    return scene


def swing():
    scene = ancf.Scene((0.0, -9.81))
    board = ancf.Rectangle(0.03, 0.03)
    seat = scene.add_beam("thin", (0, 0), (1, 0), 4, board, MATERIAL, velocity=(1.0, 0.0))
    scene.rod(seat.start, (0.0, 1.0))
    scene.rod(seat.end, (1.0, 1.0))
    return scene


SCENES = [swinging_pendulum, double_pendulum, spin_up, swinging_cable, swing]


def positions(run):
    """All nodes at all saved times, (k, n, dim)."""
    dim = run.system.dim
    return np.concatenate([run.q[:, p[:, :dim]] for p in run.system.places], axis=1)


def fixed(scene, dt, tolerance=1e-4, **options):
    run = ancf.simulate(
        scene,
        T_END,
        dt,
        save_every=round(T_END / TIMES / dt),
        tolerance=tolerance,
        **options,
    )
    return positions(run), run.stats


@pytest.fixture(scope="module", params=SCENES, ids=lambda make: make.__name__)
def case(request):
    coarse, fine = (fixed(request.param(), dt)[0] for dt in (2.5e-5, 1.25e-5))
    exact = (4 * fine - coarse) / 3
    assert np.abs(fine - exact).max() < 1.5e-7  # and what is extrapolated is far closer
    return request.param, exact


def distance(found, exact):
    return np.linalg.norm(found - exact, axis=2).max()


@pytest.mark.parametrize("accuracy", [1e-3, 1e-4, 1e-5, 1e-6, 1e-7])
def test_the_accuracy_is_met(case, accuracy):
    make, exact = case
    run = ancf.simulate(make(), T_END, accuracy=accuracy)
    error = distance(positions(run), exact)
    assert len(run.t) == TIMES + 1
    assert run.stats.error <= accuracy
    assert error <= 2.0 * accuracy
    assert error >= 0.05 * accuracy  # not by waste
    assert 0.4 < error / run.stats.error < 2.5  # what it says is right
    assert 2 <= run.stats.runs <= 5


def cost(stats):
    """Residuals, and factors at ten of them."""
    return stats.residual_evaluations + 10 * stats.factorizations


def test_it_costs_at_most_three_times_the_cheapest_fixed_step(case):
    make, exact = case
    # Steps at the default tolerance; with multipliers they would cost 3.01 times less at 1e-3.
    tolerance = 1e-4 if make is swing else "default"
    swept = []
    for dt in (5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5, 2.5e-5, 1.25e-5):
        found, stats = fixed(make(), dt, tolerance, max_energy_gain=math.inf)
        swept.append((distance(found, exact), cost(stats)))
    errors, costs = np.log(np.array(swept)[::-1].T)
    for accuracy in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
        run = ancf.simulate(make(), T_END, accuracy=accuracy)
        cheapest = math.exp(np.interp(math.log(accuracy), errors, costs))
        assert cost(run.stats) < 3.0 * cheapest


def test_steps_follow_the_motion_and_are_powers_of_a_root():
    # The moment sets in smoothly and turns off: short steps while it acts, longer ones before.
    system = System(spin_up())
    t = np.linspace(0.0, 2.0, 11)
    stepper = Stepper(system, ancf.GeneralizedAlpha(0.8), "auto", 1e-8, 1e-5, t, 0.01)
    lengths = [stepper.dt]
    change = stepper._change

    def watch(dt, now):
        lengths.append(dt)
        change(dt, now)

    stepper._change = watch
    stepper.run()
    levels = np.log(np.array(lengths) / 1e-5) / math.log(RATIO)
    np.testing.assert_allclose(levels, np.round(levels), atol=1e-9)
    assert max(lengths) > 8.0 * min(lengths)
    assert stepper.stats.rejected_steps > 0
    # Few changes for many steps: the factor of one serves the next.
    assert len(lengths) < 0.1 * stepper.stats.steps


def test_states_between_steps_are_those_of_a_cubic():
    times = np.linspace(0.0, 1.0, 11)
    states = States(times, *(np.zeros((11, 1)) for _ in range(4)))
    t = np.array([0.0, 0.33, 0.61, 1.02])
    cubic, rate, second = 2 * t**3 - t, 6 * t**2 - 1, 12 * t
    states.fill(t, *(x[:, None] for x in (cubic, rate, second, t)))
    np.testing.assert_allclose(states.q[1:, 0], 2 * times[1:] ** 3 - times[1:], atol=1e-14)
    np.testing.assert_allclose(states.v[1:, 0], 6 * times[1:] ** 2 - 1, atol=1e-13)
    np.testing.assert_allclose(states.a[1:, 0], 12 * times[1:], atol=1e-13)
    np.testing.assert_allclose(states.lam[1:, 0], times[1:], atol=1e-14)


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ({}, "needs a time step or an accuracy"),
        ({"accuracy": -1e-3}, "accuracy must be positive"),
        ({"accuracy": math.nan}, "accuracy must be finite"),
        ({"accuracy": 1e-14}, "below what double precision can hold"),
        ({"accuracy": 1e-4, "tolerance": 1e-3}, "sets the tolerance of the iteration by itself"),
        ({"accuracy": 1e-4, "integrator": ancf.Newmark(0.1)}, "is of first order"),
        ({"accuracy": 1e-4, "integrator": ancf.CentralDifference()}, "changes steps"),
        ({"accuracy": 1e-4, "solver": ancf.QuasiNewton("bfgs")}, "a factor that is renewed"),
    ],
)
def test_what_cannot_be_meant_is_refused(options, part):
    with pytest.raises(ancf.InputError, match=part):
        ancf.simulate(swinging_pendulum(), 1.0, **options)


def test_the_trapezoidal_rule_is_refused_where_steps_change_and_constraints_have_multipliers():
    with pytest.raises(ancf.InputError, match=r"rod at .*GeneralizedAlpha\(0.9\)"):
        ancf.simulate(swing(), 1.0, accuracy=1e-4, integrator=ancf.Newmark(0.0))


def test_an_error_below_rounding_ends_with_a_sentence():
    system, t = System(swinging_pendulum()), np.array([0.0, 0.1])
    stepper = Stepper(system, ancf.Newmark(), ancf.Newton(), 1e-40, 1e-4, t, 0.01)
    with pytest.raises(ancf.StepFailure, match="however short it is"):
        stepper.run()


def test_an_error_that_stays_whatever_the_steps_is_told(monkeypatch):
    monkeypatch.setattr("ancfsparse.solve.accuracy._error", lambda *_: 1.0)
    with pytest.raises(AccuracyFailure, match="no longer follows the steps") as caught:
        ancf.simulate(swinging_pendulum(), 0.05, accuracy=1e-4)
    assert (caught.value.accuracy, caught.value.error) == (1e-4, 1.0)
    assert caught.value.runs <= 5


def test_dt_is_the_time_between_saved_states_and_what_was_asked_is_kept():
    run = ancf.simulate(swinging_pendulum(), 0.2, 0.01, accuracy=1e-4, save_every=3)
    np.testing.assert_allclose(run.t, [0.0, 0.03, 0.06, 0.09, 0.12, 0.15, 0.18, 0.2], atol=1e-15)
    assert run.settings["accuracy"] == 1e-4
    again = ancf.simulate(swinging_pendulum(), 0.2, 0.01, accuracy=1e-4, save_every=3)
    np.testing.assert_array_equal(run.q, again.q)
    assert math.isnan(ancf.simulate(swinging_pendulum(), 0.01, 1e-3).stats.error)


def test_the_other_options_go_together_with_an_accuracy(tmp_path):
    def scene():
        wet = ancf.Material(1e8, 4000.0, axial_damping=1e-4, bending_damping=1e-3)
        scene = ancf.Scene((0.0, -9.81))
        rod = scene.add_beam("thin", (0, 0), (2, 0), 6, SECTION, wet)
        scene.pin(rod.start)
        return scene, rod

    first, rod = scene()
    exact = ancf.simulate(first, 0.4, 2e-5, save_every=100).position(rod.end)
    for solver in ("auto", ancf.ModifiedNewton(), ancf.QuasiNewton("broyden", memory=5)):
        body, rod = scene()
        run = ancf.simulate(
            body, 0.4, accuracy=1e-5, solver=solver, save_nodes=[rod.end],
            output=tmp_path / "run.h5",
        )  # fmt: skip
        assert np.abs(run.position(rod.end) - exact).max() < 2e-5
        assert run.stats.error <= 1e-5


def test_a_rotating_seed_is_refused():
    solver = ancf.ModifiedNewton(seed_frame="rotating")
    with pytest.raises(ancf.InputError, match="a factor of the body as it lies"):
        ancf.simulate(swinging_pendulum(), 1.0, accuracy=1e-4, solver=solver)


def test_loads_are_not_asked_for_past_the_end():
    def until_the_end(t):
        assert t <= 0.2
        return (0.0, 1.0)

    scene, rod = pendulum("thin", 3)
    scene.point_force(rod.end, until_the_end)
    ancf.simulate(scene, 0.2, accuracy=1e-4)


def test_the_command_ends_with_a_sentence_where_an_accuracy_is_out_of_reach(monkeypatch, capsys):
    monkeypatch.setattr("ancfsparse.solve.accuracy._error", lambda *_: 1.0)
    with pytest.raises(SystemExit) as left:
        main(["pendulum", "--time", "0.05", "--accuracy", "1e-4", "--step", "0.01"])
    assert left.value.code == 1
    assert "no longer follows the steps" in capsys.readouterr().err


def test_an_accuracy_near_rounding_ends_with_what_is_in_reach():
    scene, _ = pendulum("l2t2", 2)
    with pytest.raises(AccuracyFailure, match="the rounding of so many steps") as caught:
        ancf.simulate(scene, 0.02, accuracy=3e-13)
    failure = caught.value
    assert failure.runs <= 4
    assert str(pickle.loads(pickle.dumps(failure))) == str(failure)
    reach = float(re.search(r"Ask for (\S+) m", str(failure))[1])
    assert ancf.simulate(scene, 0.02, accuracy=reach).stats.error <= reach
