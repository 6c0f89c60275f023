"""The timing against Exudyn, and the message without it."""

import json

import numpy as np
import pytest

from benchmarks.table1.speed import STUDY, pendulum_speed


def test_same_discretisation_gives_the_same_motion():
    pytest.importorskip("exudyn")
    result = pendulum_speed(t_end=0.5, repeats=1)
    assert result.tip_difference < 1e-6
    ours, theirs = result.candidates[1], result.candidates[2]
    assert ours.name == "Thin biot, Davidon"
    assert theirs.tip.shape == (1, 2)
    np.testing.assert_allclose(ours.tip, theirs.tip, rtol=0, atol=1e-6)
    assert len(result.speed_ups) == 12
    assert "Exudyn's best / L2T2" in STUDY.text(result)
    assert len(json.loads(json.dumps(STUDY.as_record(result)))["targets"]) == 5
