"""The table of kernels."""

import json

from ancfsparse.dispatch import available_instruction_sets
from ancfsparse.kernels.catalog import module_names
from benchmarks.common.kernel_timing import Timing
from benchmarks.common.target import Target
from benchmarks.table1 import kernels


def test_every_kernel_is_timed_on_every_instruction_set(monkeypatch):
    def quick(names):
        return [
            Timing(name, "force", each, 8, 100, 20.0 if name.endswith("gauss") else 8.0)
            for name in names
            for each in available_instruction_sets()
        ]

    monkeypatch.setattr(kernels, "kernel_table", quick)
    monkeypatch.setattr(kernels, "speed_ratios", lambda names: {names[0]: (40.0, 10.0)})
    result = kernels.kernel_speed()
    text = kernels.STUDY.text(result)
    for name in (*module_names(), *available_instruction_sets()):
        assert name in text
    assert [each.value for each in kernels.targets(result)] == [2.5] * len(
        available_instruction_sets()
    ) + [4.0]
    assert all(each.is_met for each in kernels.targets(result))
    data = json.loads(json.dumps(kernels.STUDY.as_record(result)))
    assert data["timings"][0]["operations"] == 100


def test_without_a_compiler_the_other_numbers_stand(monkeypatch):
    def none(names):
        raise FileNotFoundError("cc")

    monkeypatch.setattr(kernels, "speed_ratios", none)
    monkeypatch.setattr(
        kernels,
        "kernel_table",
        lambda names: [
            Timing(n, "force", each, 8, 100, 1.0)
            for n in names
            for each in available_instruction_sets()
        ],
    )
    result = kernels.kernel_speed()
    assert result.lanes == {}
    assert "needs a checkout and a compiler" in kernels.STUDY.text(result)
    assert not any(each.is_met for each in kernels.targets(result))


def test_targets_know_which_side_is_good():
    assert Target("ratio", 9.0, 8.0).is_met
    assert not Target("ratio", 7.0, 8.0).is_met
    assert Target("iterations", 2.5, 2.6, at_most=True).is_met
    assert "MISSED" in str(Target("iterations", 2.7, 2.6, at_most=True))
