"""The study of the whole error on short runs, and what it says about hand-made data."""

import csv
import json
import math
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.accuracy import total_error as module
from benchmarks.accuracy.references import Reference
from benchmarks.accuracy.timed_runs import Point, Task
from benchmarks.accuracy.total_error import TotalError, element_forces, total_error
from benchmarks.accuracy.total_error_report import STUDY, chart, findings
from benchmarks.commands import STUDIES, main
from benchmarks.common.timing import OURS


def point(model, elements, dt, error, seconds, program=OURS, note=""):
    task = Task(program, "Newmark(0)", "auto", model, elements, "dt", dt, lambda: None)
    return Point(task, seconds, error, {"residuals": round(2.0 / dt)}, note)


def study(*points, apart=1e-3):
    tips = {"Thin": np.zeros((4, 2)), "Thick": np.full((4, 2), apart / math.sqrt(2.0))}
    references = {name: Reference(tip, 1e-5, "by hand") for name, tip in tips.items()}
    settings = {"t_end_s": 2.0, "instruction_set": "x86_64", "seconds": "", "error": ""}
    return TotalError(list(points), references, [], settings)


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
    sentences = findings(study(*LOCKING))
    assert any("Thin, the paper's choice" in each and "on the front" in each for each in sentences)
    assert any(
        "Thick on 10 elements locks" in each and "10 times that" in each for each in sentences
    )
    assert any(
        "of the meshes that were run 40 do what 10 Thin ones do" in each for each in sentences
    )
    assert any(
        "dt = 0.004 s, 8 times the paper's, leaves it at 1.1e-02 m" in each for each in sentences
    )

    free = [point("Thin", 10, 5e-4, 1e-2, 0.02), point("Thin", 10, 4e-3, 5e-2, 0.004),
            point("Thick", 10, 5e-4, 1.1e-2, 0.08)]  # fmt: skip
    sentences = findings(study(*free))
    assert any("does not lock" in each for each in sentences)
    assert any("no step larger than dt = 0.0005 s" in each for each in sentences)
    assert not any(" locks" in each for each in sentences)


def test_peers_may_win():
    exudyn = point("Thin, Biot", 10, 5e-4, 1e-6, 0.5, program="Exudyn")
    assert any("which no run of ours reaches" in s for s in findings(study(*LOCKING, exudyn)))
    slower = point("Thin, Biot", 10, 5e-4, 2e-3, 0.5, program="Exudyn")
    assert any("10 times faster" in s for s in findings(study(*LOCKING, slower)))


def test_a_better_choice_is_named():
    better = point("Thin", 14, 4e-3, 2e-3, 0.005)
    sentences = findings(study(*LOCKING, better))
    assert any("14 elements" in each and "4 times faster" in each for each in sentences)


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


def test_files(short, tmp_path):
    paths = STUDY.write(short, tmp_path)
    with paths[0].open(encoding="utf-8") as file:
        assert len(list(csv.DictReader(file))) == len(short.points)
    data = json.loads(paths[1].read_text(encoding="utf-8"))
    assert len(data["points"]) == len(short.points)
    assert data["findings"] == findings(short)
    assert paths[2].stat().st_size > 10_000
    assert "The paper's choice" in STUDY.text(short)
    assert STUDY.region("total-error", short).startswith("| error [m] |")


def test_command_fills_a_page(tmp_path, capsys, monkeypatch, short):
    done = replace(STUDY, run=lambda progress: short)
    monkeypatch.setitem(STUDIES, "accuracy total-error", done)
    page = tmp_path / "page.md"
    page.write_text("<!-- total-error:begin -->\n<!-- total-error:end -->\n", encoding="utf-8")
    words = ["--output", str(tmp_path / "results"), "--page", str(page)]
    with pytest.raises(SystemExit) as left:
        main(["accuracy", "total-error", *words])
    assert left.value.code == 0
    assert "| error [m] |" in page.read_text(encoding="utf-8")
    assert (tmp_path / "gallery" / "total-error.png").stat().st_size > 10_000
    assert "written:" in capsys.readouterr().out
