"""Runs are resumed to the last bit, from copies of their files and after kills."""

import pytest

from ancfsparse.solve.motion.fixed_step_run import FixedStepRun
from tests.soak.checkpoints import kills, trials


@pytest.mark.parametrize("index", range(12))
def test_random_runs_are_resumed_to_the_last_bit(index):
    assert trials.run(4, index).finds == []


def test_a_run_that_does_not_return_to_its_checkpoints_is_a_find(monkeypatch):
    monkeypatch.setattr(FixedStepRun, "save_checkpoint", lambda run: run._save())
    assert any(trials.run(4, index).finds for index in range(12))


@pytest.mark.slow
@pytest.mark.parametrize("index", range(2))
def test_killed_runs_end_as_if_they_were_not(index):
    report = kills.run(5, index)
    assert report.finds == []
