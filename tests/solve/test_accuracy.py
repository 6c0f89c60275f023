"""Runs to a given accuracy, against the same mesh solved with steps too short to count."""

import itertools
import math
import pickle
import re

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.cli import main
from ancfsparse.errors import AccuracyFailure
from ancfsparse.problems import pendulum
from ancfsparse.results import load
from ancfsparse.solve.states import States
from ancfsparse.solve.steps import RATIO, Stepper
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
    assert error <= 1.5 * accuracy
    assert error < max(2.5 * run.stats.error, 3e-8)  # what it says is right, as far as is known
    assert 2 <= run.stats.runs <= 8


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6])
def test_an_integrator_that_is_named_is_taken(case, accuracy):
    make, exact = case
    named = [ancf.GeneralizedAlpha(0.8), ancf.HHT(0.1)]
    if make is not swing:
        named += [ancf.CentralDifference(), ancf.RungeKuttaNystrom(4), ancf.RungeKuttaNystrom(8)]
    for integrator in named:
        run = ancf.simulate(make(), T_END, accuracy=accuracy, integrator=integrator)
        assert run.stats.solver.startswith(repr(integrator))
        assert distance(positions(run), exact) <= 1.5 * accuracy


def cost(stats):
    """Residuals, and factors at four of them with their solution, as `Costs` weighs them here."""
    return stats.residual_evaluations + 4 * stats.factorizations


def fixed_runs(make):
    """Motions by fixed steps of methods of the package, and their counts."""
    explicit = [ancf.CentralDifference(), ancf.RungeKuttaNystrom(4), ancf.RungeKuttaNystrom(8)]
    for integrator in explicit if make is not swing else []:
        limit = ancf.stable_step(make(), integrator)
        for finer in (1.05, 1.5, 2.1):
            dt = T_END / TIMES / math.ceil(T_END / TIMES * finer / limit)
            yield fixed(make(), dt, "default", integrator=integrator, max_energy_gain=math.inf)
    # Steps at the default tolerance; with multipliers they would cost 3.01 times less at 1e-3.
    tolerance = 1e-4 if make is swing else "default"
    for dt in (5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5, 2.5e-5):
        yield fixed(make(), dt, tolerance, max_energy_gain=math.inf)


def test_its_cost_is_a_small_multiple_of_the_cheapest_way_in_the_package(case):
    make, exact = case
    swept = [(distance(found, exact), cost(stats)) for found, stats in fixed_runs(make)]
    ratios = []
    for accuracy in (1e-3, 1e-4, 1e-5, 1e-6, 1e-7):
        run = ancf.simulate(make(), T_END, accuracy=accuracy)
        least = min((spent for error, spent in swept if error <= accuracy), default=math.inf)
        ratios.append(cost(run.stats) / least)
    assert np.median(ratios) < 3.6
    assert max(ratios) < 6.0


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
    # All but the last, with which steps come to the end.
    levels = np.log(np.array(lengths[:-1]) / 1e-5) / math.log(RATIO)
    np.testing.assert_allclose(levels, np.round(levels), atol=1e-9)
    assert max(lengths) > 8.0 * min(lengths)
    assert stepper.stats.rejected_steps > 0
    # Few changes for many steps: the factor of one serves the next.
    assert len(lengths) < 0.1 * stepper.stats.steps
    assert sum(n * dt for dt, n in stepper.pattern[0]) == pytest.approx(2.0, abs=1e-12)


def between(power, resolved, t):
    """States at tenths of a second, from steps between them, of a motion t^power - t."""
    times = np.linspace(0.0, 1.0, 11)
    states = States.empty(times, 1, 1)
    rates = [lambda t, k=k: polynomial(power, k, t) for k in range(3)]
    states.begin(*(rate(0.0) for rate in rates), 0.0)
    states.fill(t, *(rate(t)[:, None] for rate in rates), t[:, None], resolved=resolved)
    assert states.rows == 11
    return states, rates


def polynomial(power, derivatives, t):
    p = np.polynomial.Polynomial([0.0, -1.0] + [0.0] * (power - 2) + [1.0])
    return (p.deriv(derivatives) if derivatives else p)(t)


def test_states_between_steps_are_those_of_a_cubic():
    states, rates = between(3, False, np.array([0.0, 0.33, 0.61, 1.02]))
    for table, rate in zip((states.q, states.v, states.a), rates, strict=True):
        np.testing.assert_allclose(table[:, 0], rate(states.t), atol=1e-13)
    np.testing.assert_allclose(states.lam[:, 0], states.t, atol=1e-14)


@pytest.mark.parametrize(("steps", "power"), [(1, 5), (2, 8), (3, 11), (7, 11)])
def test_where_all_is_resolved_states_between_steps_are_of_high_degree(steps, power):
    states, rates = between(power, True, np.linspace(0.0, 1.02, steps + 1))
    for table, rate in zip((states.q, states.v), rates, strict=False):
        np.testing.assert_allclose(table[:, 0], rate(states.t), atol=1e-11)


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ({}, "needs a time step or an accuracy"),
        ({"accuracy": -1e-3}, "accuracy must be positive"),
        ({"accuracy": math.nan}, "accuracy must be finite"),
        ({"accuracy": 1e-14}, "below what double precision can hold"),
        ({"accuracy": 1e-4, "tolerance": 1e-3}, "sets the tolerance of the iteration by itself"),
        ({"accuracy": 1e-4, "integrator": ancf.Newmark(0.1)}, "is of first order"),
        ({"accuracy": 1e-4, "integrator": ancf.EnergyMomentum()}, "changes steps"),
        (
            {"accuracy": 1e-4, "integrator": ancf.CentralDifference(), "solver": ancf.Newton()},
            "solves no equations",
        ),
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
    monkeypatch.setattr("ancfsparse.solve.implicit_runs.distance", lambda *_: 1.0)
    with pytest.raises(AccuracyFailure, match="no longer follows the steps") as caught:
        ancf.simulate(
            swinging_pendulum(), 0.05, accuracy=1e-4, integrator=ancf.GeneralizedAlpha(0.9)
        )
    assert caught.value.accuracy == 1e-4
    assert 0.01 < caught.value.error <= 1.0
    assert caught.value.runs <= 8
    assert caught.value.trajectory.t[-1] == 0.05
    assert not caught.value.trajectory.finished


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
    monkeypatch.setattr("ancfsparse.solve.implicit_runs.distance", lambda *_: 1.0)
    with pytest.raises(SystemExit) as left:
        main(["pendulum", "--time", "0.05", "--accuracy", "1e-4", "--step", "0.01"])
    assert left.value.code == 1
    assert "no longer follows the steps" in capsys.readouterr().err


def test_an_accuracy_near_rounding_ends_with_what_is_in_reach(monkeypatch):
    monkeypatch.setattr("ancfsparse.solve.accuracy.EPSILON", 1e-10)  # as if by fewer digits
    scene, _ = pendulum("l2t2", 2)
    with pytest.raises(AccuracyFailure, match="the rounding of so many steps") as caught:
        ancf.simulate(scene, 0.02, accuracy=1e-10, integrator=ancf.GeneralizedAlpha(0.9))
    failure = caught.value
    assert failure.trajectory.t[-1] == 0.02
    reach = float(re.search(r"Ask for (\S+) m", str(failure))[1])
    again = ancf.simulate(scene, 0.02, accuracy=reach, integrator=ancf.GeneralizedAlpha(0.9))
    assert again.stats.error <= reach


def test_an_accuracy_failure_can_be_sent():
    failure = AccuracyFailure(1e-6, 1e-5, 3, 5e-5)
    assert str(pickle.loads(pickle.dumps(failure))) == str(failure)


def thin_cable():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    material = ancf.Material(4e7, 1500.0)
    cable = scene.add_beam("thin", (0, 0, 0), (1.3, 0, 0), 9, ancf.Circle(0.008), material)
    scene.pin(cable.start)
    scene.point_force(cable.end, lambda t: (0.3 * math.sin(9 * t), 0.2 * math.cos(5 * t), 0.1))
    return scene


def test_a_thin_cable_takes_an_explicit_method_of_high_order():
    exact = ancf.simulate(
        thin_cable(), 1.0, 1.0 / 6000, save_every=30, integrator=ancf.RungeKuttaNystrom(8)
    )
    for accuracy, forces in ((1e-4, 24_000), (1e-6, 24_000), (1e-8, 110_000)):
        run = ancf.simulate(thin_cable(), 1.0, accuracy=accuracy)
        assert run.stats.solver.startswith(("RungeKuttaNystrom", "CentralDifference"))
        assert distance(positions(run), positions(exact)) <= accuracy
        assert cost(run.stats) < forces


def jumping(damped):
    wet = {"axial_damping": 1e-3, "bending_damping": 1e-2} if damped else {}
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, SECTION, ancf.Material(1e8, 4000.0, **wet))
    scene.pin(rod.start)
    scene.point_force(rod.end, lambda t: (0.0, 3.0 if 0.0731 <= t < 0.1519 else 0.0))
    return scene


@pytest.mark.parametrize("damped", [False, True])
def test_loads_that_jump_cost_no_accuracy(damped):
    # The reference is begun anew at each jump, by SciPy.
    system, times = System(jumping(damped)), np.linspace(0.0, 0.2, 41)
    exact = positions_by_scipy(system, times, (0.0731, 0.1519))
    for accuracy in (1e-4, 1e-6, 1e-8):
        run = ancf.simulate(jumping(damped), 0.2, 0.005, accuracy=accuracy)
        assert distance(positions(run), exact) <= 1.5 * accuracy
        assert run.stats.steps < 15_000


def positions_by_scipy(system, times, jumps):
    n, none = system.n_free, np.zeros(system.n_all)
    mass = np.array([system.assembly.inertia(unit)[:n] for unit in np.eye(system.n_all)[:n]])
    inverse = np.linalg.inv(mass)

    def rate(t, y, load):
        q, v = system.q0.copy(), none.copy()
        q[:n], v[:n] = y[:n], y[n:]
        r, _ = system.assembly.residual(q, v, none, np.zeros(0), system.dead_load, load)
        return np.concatenate([y[n:], -inverse @ r[:n]])

    y, rows = np.concatenate([system.q0[:n], system.v0[:n]]), []
    ends = [0.0, *jumps, times[-1]]
    for begin, end in itertools.pairwise(ends):
        load = system.loads.amplitudes(np.array([0.5 * (begin + end)]))[0]
        mine = times[(times >= begin) & (times < end)]
        solved = solve_ivp(
            rate, (begin, end), y, "DOP853", [*mine, end], args=(load,), rtol=1e-9, atol=1e-11
        )
        rows.append(solved.y[:n, :-1])
        y = solved.y[:, -1]
    q = np.tile(system.q0, (len(times), 1))
    q[:, :n] = np.hstack([*rows, y[:n, None]]).T
    return np.concatenate([q[:, p[:, : system.dim]] for p in system.places], axis=1)


def interrupted_in_run(number, scene, rod):
    """Let a load interrupt the run in which time begins anew for the given time."""
    seen = {"runs": -1, "last": 0.0}  # the first time is that of the look for breaks

    def force(t):
        if t < seen["last"] - 0.1:
            seen["runs"] += 1
        seen["last"] = t
        if seen["runs"] == number and t > 0.15:
            raise KeyboardInterrupt
        return (0.0, 1e-3)

    scene.point_force(rod.end, force)
    return scene


@pytest.mark.parametrize("to_file", [False, True])
def test_an_interrupted_run_carries_the_best_motion_so_far(tmp_path, to_file):
    output = {"output": tmp_path / "run.h5"} if to_file else {}
    scene, rod = pendulum("thin", 4)
    interrupted_in_run(2, scene, rod)
    with pytest.raises(KeyboardInterrupt) as caught:
        ancf.simulate(scene, 0.2, accuracy=1e-7, integrator=ancf.GeneralizedAlpha(0.9), **output)
    path = caught.value.trajectory
    assert path.t[-1] == pytest.approx(0.2)
    assert not path.finished
    assert 1e-7 < path.stats.error < 1e-2
    assert path.stats.runs == 3
    assert "accuracy is 1e-07 m, the error is about" in repr(path)
    assert "attribute `trajectory`" in caught.value.__notes__[0]
    exact = ancf.simulate(pendulum("thin", 4)[0], 0.2, 1e-4).q[-1]
    assert np.abs(path.q[-1] - exact).max() < 3e-3
    if to_file:
        stored = load(tmp_path / "run.h5", scene)
        np.testing.assert_array_equal(stored.q[:], path.q[:])
        assert not stored.finished


def test_what_there_is_of_the_first_motion_is_in_the_file_while_it_runs(tmp_path):
    path = tmp_path / "run.h5"
    scene, rod = pendulum("thin", 4)
    interrupted_in_run(0, scene, rod)
    with pytest.raises(KeyboardInterrupt) as caught:
        ancf.simulate(scene, 0.2, accuracy=1e-7, output=path, integrator=ancf.GeneralizedAlpha(0.9))
    stored = load(path, scene)
    assert 0.0 < stored.t[-1] <= 0.2
    assert not stored.finished
    assert stored.t[-1] == caught.value.trajectory.t[-1]


def test_a_run_that_fails_carries_the_best_motion_so_far(monkeypatch):
    scene, _ = pendulum("thin", 4)
    monkeypatch.setattr("ancfsparse.solve.accuracy.MOST_RUNS", 2)
    with pytest.raises(AccuracyFailure, match="attribute `trajectory`") as caught:
        ancf.simulate(scene, 0.2, accuracy=1e-8, integrator=ancf.GeneralizedAlpha(0.9))
    assert caught.value.trajectory.t[-1] == pytest.approx(0.2)
    assert caught.value.trajectory.stats.error == caught.value.error


@pytest.mark.parametrize("integrator", ["auto", ancf.GeneralizedAlpha(0.9)])
def test_slopes_may_move_where_no_node_can(integrator):
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 1, SECTION, MATERIAL)
    scene.pin(rod.start)
    scene.pin(rod.end)
    run = ancf.simulate(scene, 0.1, accuracy=1e-5, integrator=integrator)
    exact = ancf.simulate(scene, 0.1, 1e-5, save_every=50, integrator=ancf.CentralDifference())
    assert np.abs(exact.q - exact.q[0]).max() > 0.01
    assert np.abs(run.q - exact.q).max() < 1e-3


@pytest.mark.parametrize("integrator", ["auto", ancf.HHT(), ancf.RungeKuttaNystrom(4)])
def test_times_that_steps_cannot_cross_are_refused(integrator):
    def run(t_end):
        ancf.simulate(swinging_pendulum(), t_end, accuracy=1e-4, integrator=integrator)

    run(1e-30)
    with pytest.raises(ancf.InputError, match="would take more than 9e\\+15"):
        run(1e30)
    for t_end in (1e-300, 1e308):
        with pytest.raises(ancf.InputError, match="in the range of floating-point numbers"):
            run(t_end)
