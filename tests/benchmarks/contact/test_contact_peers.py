"""The study of falls next to other codes, with this package alone and with given times."""

from functools import partial

import numpy as np
import pytest

from ancfsparse.errors import InputError
from benchmarks.contact import falls, peers as study


def absent(dt):
    raise InputError("Nowhere cannot be imported")


@pytest.fixture
def written(run_study, monkeypatch):
    steps = (4e-3, 1e-3)
    chosen = [
        study.Candidate("drum", "ancfsparse", partial(falls.run_fall, "drum"), steps),
        study.Candidate("drum", "Nowhere", absent, steps),
    ]
    monkeypatch.setattr(study, "candidates", lambda: chosen)
    monkeypatch.setattr(study, "ROUNDS", 1)
    return run_study("contact peers")


def test_errors_decrease_with_the_step_and_absent_codes_are_named(written):
    errors = [float(each["error"]) for each in written.table]
    assert [float(each["dt"]) for each in written.table] == [4e-3, 1e-3]
    assert 0.0 < errors[1] < errors[0] < 5e-3
    assert "Nowhere cannot be imported" in written.page


def cost(code, error, seconds):
    return study.FallCost("ball", code, 1e-3, error, seconds)


def test_times_are_of_the_fastest_run_with_the_error():
    runs = [cost("A", 2e-3, 1.0), cost("A", 9e-4, 3.0), cost("A", 5e-5, 2.0), cost("B", 2e-4, 1.5)]
    result = study.ContactPeers(runs, [("ball", "B", 2e-3)], [], {})
    assert study.seconds_for(result, "ball", "A", 1e-3) == 2.0
    assert study.seconds_for(result, "ball", "B", 1e-4) == np.inf
    found = study.findings(result)
    assert "1 mm: B is the fastest with 1.5e+03 ms; A 1.33 times as long" in found[0]
    assert "0.1 mm: A is the fastest with 2e+03 ms; B never" in found[1]
    assert "no run reaches it" in found[2]
    assert "B ends 2 mm from ancfsparse on a ball" in found[3]


def test_the_cable_lies_on_the_obstacle_at_the_end():
    reach = falls.OBSTACLE_RADIUS + falls.RADIUS
    middle = falls.run_fall("drum", 1e-3).positions[1]
    assert np.linalg.norm(middle) > 0.99 * reach
    assert middle[1] < falls.start_height(False) - 0.5 * falls.GAP
