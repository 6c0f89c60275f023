"""The benchmark of sweeps: equal numbers, and little more work than a loop."""

import pytest

pytest.importorskip("pandas")

from ancfsparse.studies.bench.sweep import bench_sweep


def test_a_sweep_has_equal_numbers_and_little_overhead():
    found = bench_sweep(points=12, workers=2, dt=2e-3, rounds=2)
    assert found.equal
    # Times of processors on a machine that others use too; 5 % is the aim of the command.
    assert found.sweep_processor < 2.0 * found.loop_processor
    assert "12 pendulums of 10 elements, 2 processes; numbers equal bit for bit" in str(found)
    assert {each["what"] for each in found.record()["targets"]} == {
        "gain on the clock",
        "gain by time of processors",
        "overhead in time of processors",
    }
