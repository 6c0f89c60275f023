"""The map of exact beside incomplete seeds: what it says and draws."""

import pytest

from ancfsparse.errors import InputError
from benchmarks.stability.factorizations import (
    CLAIMED_H_OMEGA,
    FACTORIZATIONS,
    Row,
    chart,
    factorizations,
    findings,
    worse,
)


def row(factorization, outcome, dt=1e-3, h_omega=100.0, on_complete=False):
    return Row("lattice", "Newmark(0)", factorization, 1e8, dt, h_omega, outcome, 10, on_complete)


def test_what_is_worse_is_found_and_named(readable):
    rows = [row("complete", "finished"), row("incomplete", "failed"), row("auto", "finished")]
    rows += [row(factorization, "failed", 1e-2, 1e3) for factorization in FACTORIZATIONS]
    assert worse(rows, "incomplete") == [rows[1]]
    assert worse(rows, "auto") == []
    sentences = findings(rows)
    sentence = (
        f"do not finish where complete seeds do, 1 of them at h omega up to {CLAIMED_H_OMEGA:g}"
    )
    assert f"1 of 2 runs {sentence}" in sentences[0]
    assert "lattice, 1e+08 Pa, dt = 0.001 s (h omega = 100), Newmark(0)" in sentences[1]
    readable(chart(rows))


def test_lattices_finish_on_both_where_steps_are_short():
    rows = factorizations(("lattice",), (2e-4,), (1e7, 1e9))
    assert {each.outcome for each in rows} == {"finished"}
    assert max(each.h_omega for each in rows) == pytest.approx(4.77, rel=0.01)
    with pytest.raises(InputError, match="scene"):
        factorizations(("none",))


def test_the_command_writes_the_map(run_study):
    words = ["--scene", "pendulum", "--step", "0.005", "--stiffness", "1e7"]
    assert len(run_study("stability factorizations", *words).table) == 2 * len(FACTORIZATIONS)
