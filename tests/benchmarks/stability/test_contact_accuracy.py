"""The study of runs to an accuracy with contact, on two scenes."""

import math

import pytest

from benchmarks.stability import contact_accuracy as study


@pytest.fixture
def written(run_study, monkeypatch):
    scenes = [("net on a ball", "no friction"), ("tilted throw", "no friction")]
    for name, value in {
        "CASES": scenes,
        "ACCURACIES": (1e-3,),
        "REFERENCE_STEPS": (1e-5, 2e-5),
    }.items():
        monkeypatch.setattr(study, name, value)
    return run_study("contact accuracy")


def test_errors_of_reached_accuracies_keep_them_and_failures_stay_visible(written):
    net, throw = written.table
    assert (net["is_reached"], throw["is_reached"]) == ("True", "False")
    assert 10.0 * float(net["reference_error"]) < float(net["error"]) < 1e-3
    assert float(throw["estimate"]) > 1e-3
    assert "| tilted throw | no friction | 0.001 | no |" in written.page
    (target,) = written.data["targets"]
    assert target["value"] == pytest.approx(float(net["error"]) / 1e-3)
    assert target["met"]


def test_the_target_counts_runs_that_reach_their_accuracy_only():
    def run(is_reached, error):
        return study.AccurateRun("scene", "none", 1e-3, is_reached, 0.0, error, 0.0, 1, 1.0)

    assert not study.targets([run(True, 2e-3), run(False, 1.0)])[0].is_met
    assert study.targets([run(True, 5e-4), run(False, 1.0)])[0].value == 0.5
    assert math.isnan(study.targets([run(False, 1.0)])[0].value)
