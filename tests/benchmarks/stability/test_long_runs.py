"""The study of long runs, on short ones."""

import re

import numpy as np
import pytest

from benchmarks.stability.long_runs import (
    CANDIDATES,
    MIN_GROWTH,
    SOFT_MODULUS,
    LongRun,
    LongRuns,
    chart,
    findings,
    long_runs,
)


def test_damped_runs_never_gain_and_memory_does_not_grow():
    (run,) = long_runs(40_000, CANDIDATES[:1]).runs
    assert run.reason == ""
    assert run.t[-1] == pytest.approx(20.0)
    assert run.rise < 1e-3
    assert run.rate < 0.0
    assert run.is_conservative
    assert run.growth < MIN_GROWTH


def test_energy_momentum_keeps_what_damping_takes():
    wanted = [
        each for each in CANDIDATES if each.name == "EnergyMomentum" and each.step_ratio <= 4.0
    ]
    runs = long_runs(8000, wanted).runs
    assert [run.steel for run in runs] == [False] * 3 + [True] * 2
    for run in runs:
        assert run.reason == ""
        assert np.abs(run.energy).max() < 2e-5
        assert run.iterations > 1.9


def test_the_trapezoidal_rule_dies_sooner_with_longer_steps():
    wanted = [each for each in CANDIDATES if each.name == "Newmark(0)" and each.step_ratio >= 4.0]
    wanted = [each for each in wanted if each.youngs_modulus == SOFT_MODULUS]
    runs = long_runs(20_000, wanted).runs
    ends = [run.stopped for run in runs]
    assert len(ends) == 3
    assert ends[0] > ends[1] > ends[2]
    assert {run.reason for run in runs} <= {"EnergyIncreaseError", "StepError"}
    assert not any(run.is_conservative for run in runs)


def test_what_is_said_follows_the_numbers():
    t = np.array([0.0, 1.0, 2.0])

    def run(label, end, reason="", growth=0.0):
        energy = np.array([0.0, 0.5 * end, end])
        return LongRun(label, 1e-3, t, energy, 2.0, reason, 1.0, growth)

    result = LongRuns(
        [run("a", -0.5), run("b", -0.01), run("c", 0.02, "EnergyIncreaseError", 9e6)], {}
    )
    sentences = findings(result)
    assert "a; b. The one that keeps most is b: -1 % in 2 s." in sentences[0]
    assert sentences[1] == "c was stopped at 2 s: gained energy."
    assert sentences[2].startswith("Memory grew in c by more than 4 MB")


def test_the_chart_can_be_read(readable):
    t = np.geomspace(0.1, 500.0, 50)
    ended = ["" if k <= 5 else "EnergyIncreaseError" for k in range(len(CANDIDATES))]
    runs = [LongRun(each.label, 1e-3, t, 1e-3 * np.sin(t), 500.0, reason, 1.0, 0.0)
            for each, reason in zip(CANDIDATES, ended, strict=True)]  # fmt: skip
    readable(chart(LongRuns(runs, {})))


def test_command(run_study):
    out, _, data, page = run_study("stability long-runs", "--steps", "400")
    assert re.search(r"^  GeneralizedAlpha\(0\.8\), dt = 0\.0005 s +0\.2 s ", out, re.M)
    assert "| GeneralizedAlpha(0.8), dt = 0.0005 s | 0.2 s |" in page
    assert "Memory grew in no run" in page
    assert len(data["runs"]) == len(CANDIDATES)
