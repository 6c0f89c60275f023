"""The study of the blocks that couple touching cables, in one case."""

import math

import pytest

from benchmarks.common import methods
from benchmarks.contact import coupling_blocks as study


@pytest.fixture
def written(run_study, monkeypatch):
    for name, value in {
        "STIFFNESSES": (1e6,),
        "STEPS": (2e-3,),
        "SOLVERS": methods.chosen(methods.SOLVERS, "Newton"),
    }.items():
        monkeypatch.setattr(study, name, value)
    return run_study("contact blocks")


def test_blocks_save_iterations_and_recoveries(written):
    coupled, other = written.table
    assert (coupled["has_blocks"], other["has_blocks"]) == ("True", "False")
    assert 5.0 * float(coupled["iterations"]) < float(other["iterations"])
    assert int(coupled["recoveries"]) == 0 < int(other["recoveries"])
    assert "| 1e6 | 2 | yes |" in written.page


def test_failed_runs_stay_visible(readable):
    runs = [
        study.HeapRun(stiffness, 1e-3, "Newton", has_blocks, iterations, 0, 1.0)
        for stiffness in (1e5, 1e6)
        for has_blocks, iterations in ((True, 3.0), (False, math.inf))
    ]
    assert [row[-1] for row in study.run_table(runs).rows] == ["3, 1 s", "fails"] * 2
    assert "without blocks no run comes to its end" in study.findings(runs)[0]
    readable(study.blocks_chart(runs))
