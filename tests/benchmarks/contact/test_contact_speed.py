"""The study of the cost of contact, on a small scene."""

import pytest

from benchmarks.contact import speed as study


@pytest.fixture
def written(run_study, monkeypatch):
    for name, value in {"SIZES": (33,), "N_ELEMENTS": (10,), "ROUNDS": 2, "RUNS": 1}.items():
        monkeypatch.setattr(study, name, value)
    return run_study("contact speed")


def test_every_case_and_state_is_timed(written):
    points = [each for each in written.table if each["case"]]
    steps = [each for each in written.table if each["state"]]
    assert [each["case"] for each in points] == list(study.CASES)
    assert {each["n_points"] for each in points} == {"99"}
    assert [each["state"] for each in steps] == list(study.STATES)
    assert all(float(each["step"]) > 0.0 for each in steps)
    assert [float(each["mujoco"]) for each in steps] == [7.5, 21.0, 21.0]
    assert "| 99 | bristles |" in written.page
    assert "| 10 | falling |" in written.page


def test_targets_are_of_the_largest_scene():
    points = [study.PointCost("air", n, 1.0, 1.0, ratio, 1.0) for n, ratio in ((9, 5.0), (99, 1.0))]
    steps = [
        study.StepCost(state, 10, t, 1.0, 1.0) for state, t in (("air", 50.0), ("falling", 15.0))
    ]
    targets = study.targets(study.ContactSpeed(points, steps))
    assert [each.value for each in targets] == [1.0, 1.5]
    assert [each.is_met for each in targets] == [True, False]
