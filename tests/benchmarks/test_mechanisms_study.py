"""Mechanisms by both programs have the same errors; what is said of them follows from the rows."""

import math

import pytest

from ancfsparse.errors import InputError
from benchmarks.common.timing import OURS
from benchmarks.mechanisms import mechanisms as study
from benchmarks.mechanisms.mechanisms import STUDY, Comparison, Row, chart, mechanisms


@pytest.mark.parametrize("name", study.CASES)
def test_exudyn_makes_the_same_errors(name, monkeypatch):
    """At the longest step: a wrong mass, joint or function of time would be a larger error."""
    pytest.importorskip("exudyn")
    monkeypatch.setattr(study, "DIVISORS", (1,))
    monkeypatch.setattr(study, "REFERENCE_DIVISORS", (4, 8))
    only = {name: how for name, how in study.exudyn.NEWTON.items() if name.endswith("02, sparse")}
    monkeypatch.setattr(study.exudyn, "NEWTON", only)
    ours, theirs = mechanisms((name,), rounds=1).rows
    assert (ours.program, theirs.program) == (OURS, "Exudyn")
    assert theirs.error == pytest.approx(ours.error, rel=0.02)
    assert 0.0 < ours.error < 0.01
    assert min(ours.seconds, theirs.seconds) > 0.0


@pytest.fixture
def result():
    rows = []
    for scene, factor in (("a_b", 9.0), ("c", 2.0)):
        for dt in (2e-3, 1e-3):
            rows.append(Row(scene, dt, OURS, "auto", 1e-3, dt**2, 2.0))
            rows.append(Row(scene, dt, "Exudyn", "rough", 1e-4, 2.0 * dt**2, 3.0))
            rows.append(Row(scene, dt, "Exudyn", "fast", factor * 1e-3, 1.01 * dt**2, 4.0))
            rows.append(Row(scene, dt, "Exudyn", "failed", math.nan, math.nan, math.nan))
    return Comparison(rows, {"rounds": 1})


def test_the_fastest_of_equal_error_counts(result, tmp_path):
    assert {other.newton for _, other in result.pairs()} == {"fast"}
    first, second = result.targets()
    assert (first.value, first.is_met) == (pytest.approx(9.0), True)
    assert (second.value, second.is_met) == (pytest.approx(2.0), False)
    assert "2.0 times less processor time (c" in result.findings()[1]
    assert "MISSED" in STUDY.text(result)
    assert STUDY.region("mechanisms", result).count("\n| ") == 4
    assert "is reached by 1 of 2 and missed by c 2.0." in STUDY.region("mechanisms", result)
    assert len(chart(result).axes) == 2
    paths = STUDY.write(result, tmp_path)
    assert [path.name for path in paths] == ["mechanisms.csv", "mechanisms.json", "mechanisms.png"]


def test_unknown_mechanisms_are_refused():
    with pytest.raises(InputError, match="did you mean 'spaghetti'"):
        mechanisms(("spagetti",))
