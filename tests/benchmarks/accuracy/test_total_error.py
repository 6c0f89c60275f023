"""The study of the whole error on short runs, and what it says about hand-made data."""

import math
import re
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.accuracy import total_error as module
from benchmarks.accuracy.references import Reference
from benchmarks.accuracy.timed_runs import Point, Task
from benchmarks.accuracy.total_error import TotalError, element_forces, total_error
from benchmarks.accuracy.total_error_report import chart, findings
from benchmarks.common.timing import OURS


def point(model, elements, dt, error, seconds, program=OURS, note=""):
    task = Task(program, "Newmark(0)", "auto", model, elements, "dt", dt, lambda: None)
    return Point(task, seconds, error, {"residuals": round(2.0 / dt)}, note)


def study(*points, apart=1e-3):
    tips = {"Thin": np.zeros((4, 2)), "Thick": np.full((4, 2), apart / math.sqrt(2.0))}
    references = {name: Reference(tip, 1e-5, "by hand") for name, tip in tips.items()}
    settings = {"t_end_s": 2.0, "instruction_set": "x86_64", "seconds": "", "error": ""}
    return TotalError(list(points), references, [], settings)


def said(*points):
    return "\n".join(findings(study(*points)))


LOCKING = [
    point("Thin", 10, 5e-4, 1e-2, 0.02),
    point("Thin", 10, 4e-3, 1.05e-2, 0.004),
    point("Thin", 20, 5e-4, 1e-3, 0.05),
    point("Thick", 10, 5e-4, 1e-1, 0.08),
    point("Thick", 40, 5e-4, 9e-3, 0.4),
    point("Thick", 10, 2e-2, math.nan, math.nan, note="no convergence at t = 1 s"),
]


def test_hand_made_front_and_choices():
    result = study(*LOCKING)
    assert [(p.task.elements, p.task.value) for p in result.front()] == [
        (10, 4e-3), (10, 5e-4), (20, 5e-4)
    ]  # fmt: skip
    assert [p.task.model for p in result.paper_choices()] == ["Thin", "Thick"]
    assert result.elements_for("Thick", 1e-2) == 40
    assert result.elements_for("Thick", 1e-4) is None
    assert result.largest_step("Thin", 10).task.value == 4e-3
    assert result.model_spread() == pytest.approx((1e-3, 1e-3))
    assert all(map(math.isnan, study(*LOCKING, apart=1e-6).model_spread()))
    assert element_forces(LOCKING[0]) == 10 * 4000


def test_findings_follow_the_numbers():
    text = said(*LOCKING)
    for sentence in (
        "Thin, the paper's choice.*on the front",
        "Thick on 10 elements locks.*10 times that",
        "of the meshes that were run 40 do what 10 Thin ones do",
        "dt = 0.004 s, 8 times the paper's, leaves it at 1.1e-02 m",
    ):
        assert re.search(sentence, text), sentence
    free = [point("Thin", 10, 5e-4, 1e-2, 0.02), point("Thin", 10, 4e-3, 5e-2, 0.004),
            point("Thick", 10, 5e-4, 1.1e-2, 0.08)]  # fmt: skip
    assert "does not lock" in said(*free)
    assert "no step larger than dt = 0.0005 s" in said(*free)
    assert " locks" not in said(*free)


def test_better_choices_and_peers_are_named():
    for better, sentence in (
        (point("Thin", 14, 4e-3, 2e-3, 0.005), "14 elements.*4 times faster"),
        (point("Thin, Biot", 10, 5e-4, 1e-6, 0.5, "Exudyn"), "which no run of ours reaches"),
        (point("Thin, Biot", 10, 5e-4, 2e-3, 0.5, "Exudyn"), "10 times faster"),
    ):
        assert re.search(sentence, said(*LOCKING, better)), sentence


@pytest.fixture(scope="module")
def short():
    models = ("L2T2", "Thin", "Thick")
    return total_error(models, (4, 10, 20), 0.4, rounds=1, fine=40)


def test_meshes_and_steps_that_were_run(short):
    assert len(short.points) == 3 * 3 * (len(module.DTS) + 1)  # and one explicit step
    for model in ("L2T2", "Thin"):
        errors = [short.at(model, n, 1.25e-4).error for n in (4, 10, 20)]
        assert errors == sorted(errors, reverse=True)
        assert errors[1] / errors[2] > 6.0  # of order 4 in space, but the time error is in it
        assert short.references[model].uncertainty < 1e-5
    assert short.at("Thick", 10, 5e-4).error > 2.0 * short.at("Thin", 10, 5e-4).error
    low, high = short.model_spread()
    assert 0.0 < low <= high


def test_the_chart_can_be_read(short, readable):
    failed = point("Thick", 10, 2e-2, math.nan, math.nan, note="no convergence at t = 1 s")
    readable(chart(replace(short, points=[*short.points, failed])))


def test_files(run_result, short):
    written = run_result("accuracy total-error", short)
    assert len(written.table) == len(written.data["points"]) == len(short.points)
    assert written.data["findings"] == findings(short)
    assert "The paper's choice" in written.out
    assert "written:" in written.out
    assert "| error [m] |" in written.page
