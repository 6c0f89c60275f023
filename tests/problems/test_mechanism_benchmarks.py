"""Every named mechanism has the number that it is known by, and the command prints it."""

import json

import numpy as np
import pytest

import ancfsparse as ancf
import ancfsparse.cli.problem
from ancfsparse.problems.named import MECHANISMS
from tests.cli.command import run

BELTS = "belt_drive", "belt_drive_pechstein", "serpentine", "timing_belt"
SLOW = dict.fromkeys(("crane", "hair", "knot", *BELTS), pytest.mark.slow)


@pytest.mark.parametrize("name", [pytest.param(x, marks=SLOW.get(x, ())) for x in MECHANISMS])
def test_known_numbers(name, capsys):
    """By the command with its usual setting, to the tolerance that the table states."""
    case = MECHANISMS[name]
    code, out, _ = run(capsys, "problem", name, "--at", f"{case.time:g}", "--json", "-")
    assert code == 0
    found = json.loads(out)
    assert found["time"] == [case.time]
    value = np.ravel(found["quantities"][case.quantity][0])
    np.testing.assert_allclose(value, case.value, rtol=0.0, atol=case.tolerance)


@pytest.mark.parametrize("name", [name for name in MECHANISMS if MECHANISMS[name].make().separate])
def test_quantities_at_some_times_are_those_of_all(name):
    """They are evaluated for the asked states alone, which holds if they need no others."""
    case = MECHANISMS[name]
    made = case.make()
    run = ancf.simulate(made.scene, 8 * case.dt, case.dt, integrator=case.integrator)
    rows = [8, 3]
    for each, values in made.quantities(run).items():
        np.testing.assert_array_equal(made.quantities(run, rows)[each], values[rows], each)


@pytest.mark.parametrize(
    ("name", "times", "words"),
    [
        ("andrews", "0.02", []),
        ("four_bar", "0.3333,0.1,0", []),
        ("four_bar", "0.3333,0.1,0", ["--accuracy", "1e-6"]),
        ("four_bar", "0.052359877", ["--accuracy", "1e-6"]),
    ],
)
def test_any_time_is_reached_by_steps_that_fit(name, times, words, capsys):
    """A time that the default step does not divide, alone and beside others."""
    code, out, _ = run(capsys, "problem", name, "--at", times, "--json", "-", *words)
    assert code == 0
    found = json.loads(out)
    assert found["time"] == [float(each) for each in times.split(",")]
    mechanism = MECHANISMS[name].make()
    for k, end in enumerate(found["time"]):
        if end:
            fine = ancf.simulate(mechanism.scene, end, end / 8000, tolerance=1e-12)
            for each, values in mechanism.quantities(fine).items():
                bound = 1e-4 * np.max(np.abs(values))
                np.testing.assert_allclose(found["quantities"][each][k], values[-1], atol=bound)


def test_the_speed_of_a_run_is_not_extrapolated(capsys, monkeypatch):
    """It is the simulated time over the time of the time loop, here of the finer run.

    It is a matter of threads, so the command has an option for them.
    """
    seconds = iter((0.5, 0.125))
    run_of = ancf.cli.problem.simulate

    def timed(*arguments, **options):
        assert options["threads"] == 2
        result = run_of(*arguments, **options)
        result.stats.march_seconds = next(seconds)
        return result

    monkeypatch.setattr(ancf.cli.problem, "simulate", timed)
    words = "--set", "n_cables=2", "--set", "length=0.08", "--at", "0.02", "--json", "-"
    code, out, _ = run(capsys, "problem", "pile", "--threads", "2", *words)
    assert code == 0
    assert json.loads(out)["quantities"]["real_time_factor"] == [pytest.approx(0.02 / 0.125)]


def test_the_list_names_all(capsys):
    code, out, _ = run(capsys, "problem", "--list")
    assert code == 0
    for name, case in MECHANISMS.items():
        about = out.split(f"\n{name}" if name != "planar_rod" else name)[1].split("\n  ")
        assert set(about[1].split(": ")[1].split(", ")) == set(case.make().watched)
        assert about[2].startswith(f"{case.quantity} at {case.time:g} s: ")
        assert case.source in about[2]
    assert "spin_up [n_elements=16]" in out
    assert "belt_drive [load=10 N m, w1=100 rad/s, mu=0.3, n_elements=160]" in out
    assert "heavy_top [omega=(0, 150, -4.61538) rad/s]" in out


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["four_baz"], "did you mean 'four_bar'"),
        (["four_bar", "--at", "a"], "--at needs numbers"),
        (["four_bar", "--at", "0.5", "--step", "0.3"], "not an integral number of steps"),
        (["four_bar", "--set", "n=3"], "four_bar takes no keys"),
        (["heavy_top", "--set", "omega"], "--set needs key=value"),
        (["four_bar", "--step", "0.1", "--accuracy", "0.1"], "not both"),
    ],
)
def test_bad_words(words, message, capsys):
    code, _, err = run(capsys, "problem", *words)
    assert code == 2
    assert message in err
