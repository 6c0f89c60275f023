"""Secant pairs on incomplete seeds: what the study runs, weighs, says and draws."""

import pytest

from benchmarks.scaling import lattice_pairs as module
from benchmarks.scaling.lattice_pairs import (
    STUDY,
    PairRow,
    candidates,
    chart,
    findings,
    relative_work,
)


def row(update, pairs, carry, work, h_omega=50.0, failed=False):
    return PairRow("steel, at rest", h_omega, update, pairs, carry, 3.0, 4.0, 1, 0, work, failed)


def rows():
    found = []
    for h_omega, failed in ((50.0, False), (250.0, False), (1000.0, True)):
        for update, pairs, carry in candidates():
            broken = failed and update in ("chord", "auto")
            work = 10.0 if update == "chord" else 8.0 + carry
            found.append(row(update, pairs, carry, work, h_omega, broken))
    return found


def test_work_is_relative_to_the_chord():
    made = rows()
    assert relative_work(made, made[1]) == pytest.approx(0.8)
    last = made[-1]
    assert relative_work(made, last) != relative_work(made, last)  # the chord fails there


def test_what_is_said_follows_the_rows():
    first, second = findings(rows())
    assert "auto takes 0.80 (h omega = 50) to 0.80 (50) of the work of the chord" in first
    assert "Pairs complete 16 runs that the chord does not" in second
    assert "bfgs, 2 pairs carried" in STUDY.text(rows())
    table = STUDY.region("memory-lattices", rows())
    assert table.count("| chord |") == 3
    assert "| steel, at rest | 1000 | chord | fails |" in table


def test_the_chart_can_be_read(readable):
    readable(chart(rows()))


def test_the_command_runs_a_small_lattice(run_study, monkeypatch):
    monkeypatch.setattr(module, "H_OMEGA", {"steel": (50, 250)})
    monkeypatch.setattr(module, "MOTIONS", ("rest",))
    table = run_study("scaling lattice-pairs", "--nodes", "4").table
    assert len(table) == 2 * len(candidates())
    assert all(float(line["work"]) > 0.0 for line in table)
