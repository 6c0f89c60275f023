"""Runs to an accuracy that are refused, or that end without it: a sentence each."""

import math
import pickle
import re

import pytest

import ancfsparse as ancf
from ancfsparse.cli import main
from ancfsparse.errors import AccuracyError
from ancfsparse.problems import pendulum
from tests.beams import build_beam
from tests.solve.error_control.accuracy_problems import MATERIAL, SECTION, swing, swinging_pendulum
from tests.solve.refusals import assert_refused


@pytest.mark.parametrize(
    ("options", "part"),
    [
        ({}, "needs a time step or an accuracy"),
        ({"accuracy": -1e-3}, "accuracy must be positive"),
        ({"accuracy": math.nan}, "accuracy must be finite"),
        ({"accuracy": 1e-14}, "below the rounding of double precision"),
        ({"accuracy": 1e-4, "tolerance": 1e-3}, "sets the tolerance of the iteration: leave out"),
        ({"accuracy": 1e-4, "integrator": ancf.Newmark(0.1)}, "is of first order"),
        (
            {"accuracy": 1e-4, "integrator": ancf.CentralDifference(), "solver": ancf.Newton()},
            "solves no equations",
        ),
        ({"accuracy": 1e-4, "solver": ancf.QuasiNewton("bfgs")}, "a factor that is renewed"),
    ],
)
def test_what_cannot_be_meant_is_refused(options, part):
    assert_refused(part, ancf.simulate, swinging_pendulum(), 1.0, **options)


def test_the_rounding_limit_of_accuracy_follows_from_positions():
    """Slopes are about 1 at any size: a beam of a micrometre was taken for one of a metre."""
    material = ancf.Material(10.0, 1000.0)
    scene, rod = build_beam("thin", (0, 0), (1e-6, 0), 3, ancf.Circle(2e-8), material, "clamp")
    runs = [ancf.simulate(scene, 1e-3, accuracy=accuracy) for accuracy in (1e-14, 1e-11)]
    apart = runs[1].position(rod.end) - runs[0].position(rod.end)
    assert runs[0].stats.error <= 1e-14
    assert abs(apart).max() < 1e-11
    with pytest.raises(ancf.InputError, match="in a scene of 1e-06 m, about 1e-19 m"):
        ancf.simulate(scene, 1e-3, accuracy=1e-20)


def test_the_trapezoidal_rule_is_refused_where_steps_change_and_constraints_have_multipliers():
    with pytest.raises(ancf.InputError, match=r"rod at .*GeneralizedAlpha\(0.9\)"):
        ancf.simulate(swing(), 1.0, accuracy=1e-4, integrator=ancf.Newmark(0.0))


@pytest.fixture
def runs_apart(monkeypatch):
    """Let all runs seem to be a metre apart."""
    monkeypatch.setattr(
        "ancfsparse.solve.error_control.implicit_candidate.distance", lambda *_: 1.0
    )


@pytest.mark.usefixtures("runs_apart")
def test_an_error_that_stays_whatever_the_steps_is_told():
    with pytest.raises(AccuracyError, match="no longer follows the steps") as caught:
        ancf.simulate(
            swinging_pendulum(), 0.05, accuracy=1e-4, integrator=ancf.GeneralizedAlpha(0.9)
        )
    assert caught.value.accuracy == 1e-4
    assert 0.01 < caught.value.error <= 1.0
    assert caught.value.runs <= 8
    assert caught.value.trajectory.t[-1] == 0.05
    assert not caught.value.trajectory.finished


@pytest.mark.usefixtures("runs_apart")
def test_the_command_ends_with_a_sentence_where_an_accuracy_is_out_of_reach(capsys):
    with pytest.raises(SystemExit) as left:
        main(["pendulum", "--time", "0.05", "--accuracy", "1e-4", "--step", "0.01",
              "--integrator", "newmark"])  # fmt: skip
    assert left.value.code == 1
    assert "no longer follows the steps" in capsys.readouterr().err


def test_an_accuracy_near_rounding_ends_with_what_is_in_reach(monkeypatch):
    monkeypatch.setattr(
        "ancfsparse.solve.error_control.select_solution.EPSILON", 1e-10
    )  # as if by fewer digits
    scene, _ = pendulum("l2t2", 2)
    with pytest.raises(AccuracyError, match="the rounding error of this many steps") as caught:
        ancf.simulate(scene, 0.02, accuracy=1e-10, integrator=ancf.GeneralizedAlpha(0.9))
    failure = caught.value
    assert failure.trajectory.t[-1] == 0.02
    reach = float(re.search(r"Request (\S+) m", str(failure))[1])
    again = ancf.simulate(scene, 0.02, accuracy=reach, integrator=ancf.GeneralizedAlpha(0.9))
    assert again.stats.error <= reach


def test_an_accuracy_failure_can_be_sent():
    failure = AccuracyError(1e-6, 1e-5, 3, 5e-5)
    assert str(pickle.loads(pickle.dumps(failure))) == str(failure)


@pytest.mark.parametrize("integrator", ["auto", ancf.HHT(), ancf.RungeKuttaNystrom(4)])
def test_times_that_steps_cannot_cross_are_refused(integrator):
    def run(t_end):
        ancf.simulate(swinging_pendulum(), t_end, accuracy=1e-4, integrator=integrator)

    run(1e-30)
    assert_refused("would take more than 9e\\+15", run, 1e30)
    for t_end in (1e-300, 1e308):
        assert_refused("in the range of floating-point numbers", run, t_end)


def test_a_motion_that_forgets_its_start_ends_early():
    # A soft cable that falls and whips: exact waves, too, are apart by a third of its length.
    scene, _ = build_beam("thin", (0, 0), (1, 0), 3, SECTION, MATERIAL, "clamp")
    with pytest.raises(AccuracyError, match="chaotic motions cannot be predicted") as caught:
        ancf.simulate(scene, 7.0, accuracy=1e-3)
    assert caught.value.error > 0.05
    assert caught.value.trajectory.stats.residual_evaluations < 800_000  # a second or two
    assert caught.value.runs <= 15


def test_a_motion_that_amplifies_rounding_is_recognised_by_repeating_it():
    # Two cables in a chaotic double pendulum: runs in ever shorter steps took eight million forces.
    scene = ancf.Scene((0.0, -9.81))
    stiff = ancf.Material(1e8, 4000)
    cables = [
        scene.add_beam("thin", *ends, 1, ancf.Circle(0.02), stiff)
        for ends in (((0, 0), (1, 0)), ((1, 0), (2, 0.3)))
    ]
    scene.pin(cables[0].start)
    scene.connect(cables[0].end, cables[1].start)
    with pytest.raises(AccuracyError, match="chaotic motions cannot be predicted") as caught:
        ancf.simulate(scene, 6.0, 0.2, accuracy=1e-7)
    assert caught.value.error > 0.05
    assert caught.value.trajectory.stats.residual_evaluations < 2_000_000


def test_a_way_that_failed_is_named(monkeypatch):
    monkeypatch.setattr(
        "ancfsparse.solve.error_control.explicit_integration.STABILITY_RATIO", 3.0
    )  # steps too long by far
    monkeypatch.setattr("ancfsparse.solve.error_control.explicit_integration.MAX_UNSTABLE_RUNS", 1)
    scene, _ = pendulum("l2t2", 2)
    run = ancf.simulate(scene, 0.2, accuracy=1e-4)
    assert run.stats.solver.startswith("GeneralizedAlpha")
    assert run.stats.solver.endswith("as RungeKuttaNystrom(order=4) failed")
