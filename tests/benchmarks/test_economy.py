"""The economy of plans: a small search, and how failures and misses are shown."""

import math
from dataclasses import replace

import matplotlib.pyplot as plt
import pytest

from benchmarks.economy.report import STUDY
from benchmarks.economy.run import REQUESTS, Economy, Outcome, economy
from benchmarks.economy.scenes import CASES, Discretization


@pytest.fixture(scope="module")
def small():
    return economy(["deflection", "short beam"], requests=(0.03,))


def test_plans_and_the_best_choice_reach_the_error(small):
    rest, moving = small.outcomes
    for each in small.outcomes:
        assert not each.reason
        assert each.uncertain < 0.003
        assert each.error_ratio < 1.0
        assert each.best_seconds > 0.0
        assert each.cost > each.run_cost
    assert "statics" in rest.choice
    assert rest.best.split()[1] in ("thin", "l2t2")  # which mesh is decided by times
    assert moving.choice.startswith("beam 0 ")
    assert "steps of" in moving.best


def test_files_and_tables(small, tmp_path):
    paths = STUDY.write(small, tmp_path)
    assert [path.suffix for path in paths] == [".csv", ".json", ".png"]
    assert len(paths[0].read_text().splitlines()) == 3
    assert "short beam" in STUDY.text(small)


def outcome(**changes):
    times, work = (0.01, 0.002, 0.004), (10.0, 2.0, 4.0)
    plain = Outcome("a", 3e-3, 2e-3, 1e-3, 1e-5, "thin", "8 thin", *times, *work, False, "")
    return replace(plain, **changes)


def test_what_is_missed_or_fails_stays():
    nan = math.nan
    result = Economy(
        [
            outcome(),
            outcome(scene="b", reached=0.012),
            outcome(scene="c", reached=nan, predicted=nan, choice="", reason="StepError: no"),
            outcome(scene="d", uncertain=0.002),
            outcome(scene="e", best="", best_seconds=nan),
            outcome(scene="f", best_seconds=0.5, plan_seconds=0.5, run_seconds=1.0),
        ],
        {},
    )
    within, worst, cost, work, alone, cheap, longest = STUDY.targets(result)
    assert within.value == pytest.approx(60.0)
    assert worst.value == math.inf
    assert (cost.value, alone.value) == (3.0, 0.5)
    assert longest.value == 3.0
    assert (work.value, cheap.value) == (3.0, 80.0)
    assert outcome(is_made=True).cost == pytest.approx(2.5)
    assert longest.is_met
    assert not within.is_met
    text = "\n".join(STUDY.findings(result))
    assert "Of 5 requests with a reference certain to a fifth of them, 3 are met." in text
    assert "b to 0.3 %: 4 times the tolerance." in text
    assert "c to 0.3 %: no plan, StepError: no." in text
    assert "Not judged, since the reference is not certain enough: d to 0.3 %." in text
    assert "The search reaches no such error: e to 0.3 %." in text
    plt.close(STUDY.charts["economy"](result))
    record = STUDY.as_record(replace(result, outcomes=result.outcomes[:2]))
    assert len(record["outcomes"]) == 2


@pytest.mark.parametrize("name", CASES)
def test_every_scene_can_be_planned_and_built(name):
    case = CASES[name]
    scene, quantity = case.build(Discretization("auto", "auto"))
    assert scene.bodies
    for element, options in case.elements:
        scene, quantity = case.build(Discretization(element, case.meshes[0], options))
        assert quantity.name
    assert len(CASES) >= 20
    assert REQUESTS == (0.03, 0.003, 0.0003)
