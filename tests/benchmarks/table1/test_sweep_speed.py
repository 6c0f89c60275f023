"""The benchmark of sweeps: equal numbers, and little more work than a loop."""

import pytest

pytest.importorskip("pandas")

from benchmarks.table1.sweeps import STUDY, sweep_speed


def test_a_sweep_has_equal_numbers_and_counts_the_time_of_all_processes():
    found = sweep_speed(points=12, workers=2, dt=2e-3, rounds=2)
    assert found.equal
    assert found.sweep_processor > found.own_processor > 0.0
    assert found.loop_processor > 0.0
    assert "12 pendulums of 10 elements, 2 processes; numbers equal bit for bit" in STUDY.text(
        found
    )
    assert {each.what for each in STUDY.targets(found)} == {
        "gain on the clock",
        "gain by time of processors",
        "overhead in time of processors",
    }
