"""The work-precision study on short runs, and what it says about hand-made data."""

import json
import math
import sys
from dataclasses import replace

import pytest
from tqdm import tqdm

from ancfsparse.integrators import Newmark, RungeKuttaNystrom
from ancfsparse.solve import stable_step
from benchmarks.accuracy.candidates import INTEGRATORS, Integrator, candidates
from benchmarks.accuracy.models import MODELS
from benchmarks.accuracy.references import Reference, trapezoidal_tip
from benchmarks.accuracy.timed_runs import Point, Task, measure
from benchmarks.accuracy.work_precision import WorkPrecision, work_precision
from benchmarks.accuracy.work_precision_report import STUDY, chart, findings
from benchmarks.common.timing import OURS

MODEL = "Thin, Biot"
PEER_METHODS = {
    "Exudyn": ("trapezoidal", "generalised-alpha 0.9", "VelocityVerlet", "RK44", "RK67"),
    "SciPy": ("DOP853", "Radau"),
    "SUNDIALS": ("CVODE Adams", "CVODE BDF", "ARKODE 5(4)", "ARKODE 8(7)"),
}
ORDERS = {"Newmark(0)": (Newmark(0.0), 2.0), "Newmark(0.05)": (Newmark(0.05), 1.0)}


def point(program, seconds, error, solver="Newton", value=1e-3, note="", residuals=100):
    task = Task(program, "trapezoidal", solver, MODEL, 10, "dt", value, lambda: None)
    return Point(task, seconds, error, {"residuals": residuals}, note)


def study(*points):
    reference = Reference(None, 1e-12, "by hand")
    settings = {"elements": 10, "t_end_s": 2.0, "instruction_set": "x86_64"}
    settings |= {"seconds": "by hand", "error": "by hand"}
    return WorkPrecision(list(points), {MODEL: reference}, [], settings)


OURS_CURVE = [point(OURS, 0.01, 1e-3), point(OURS, 0.03, 1e-5), point(OURS, 0.1, 1e-6)]


def test_orders_are_those_of_the_methods():
    dts = (1e-3, 5e-4, 2.5e-4, 1.25e-4)
    rows = [Integrator(name, dts, ("BFGS",), scheme=made) for name, (made, _) in ORDERS.items()]
    result = work_precision((MODEL,), 4, 0.4, rounds=1, integrators=rows)
    assert len(result.points) == len(rows) * len(dts)
    orders = result.orders()
    for name, (_, order) in ORDERS.items():
        assert orders[f"{MODEL}: {name}, BFGS"] == pytest.approx(order, abs=0.1)
    assert result.references[MODEL].uncertainty < 1e-9


def test_explicit_steps_are_shares_of_the_stable_step_and_have_the_order_of_the_method():
    fractions = (1.1, 0.9, 0.6, 0.4)
    row = Integrator("RKN", (), (), stable_fractions=fractions, scheme=RungeKuttaNystrom(4))
    result = work_precision((MODEL,), 4, 0.4, rounds=1, integrators=[row])
    refused, *done = result.points
    assert refused.note.startswith("above the stable step")
    limit = stable_step(MODELS[MODEL].problem(4).scene, RungeKuttaNystrom(4))
    assert refused.task.value > limit
    assert all(0.35 * limit < p.task.value < limit for p in done)
    assert result.orders()[f"{MODEL}: RKN"] == pytest.approx(4.0, abs=0.4)


def test_a_step_that_fails_stays_on_the_chart():
    row = Integrator("Newmark(0)", (5e-2, 1e-2, 4e-3), ("BFGS",))
    reference = trapezoidal_tip(MODEL, 10, 2.0, 1e-3)
    tasks = candidates(MODEL, 10, 2.0, [row])
    result = study(*measure(tasks, lambda task: reference, 1, tqdm(disable=True)))
    lost = [p for p in result.points if not p.finished]
    assert [p.task.value for p in lost] == [5e-2]
    assert "t = " in lost[0].note
    assert f"dt = 0.05: {lost[0].note}" in STUDY.text(result)
    hollow = [line for line in chart(result).axes[0].lines if line.get_markerfacecolor() == "none"]
    assert len(hollow) == 1


def test_a_chart_with_all_methods_and_many_failures_can_be_read(readable):
    methods = [(OURS, each.name) for each in INTEGRATORS]
    methods += [(program, name) for program, names in PEER_METHODS.items() for name in names]
    points = []
    for model in (MODEL, "L2T2", "Thick"):
        for k, (program, method) in enumerate(methods):
            for dt in (1e-3, 2e-3, 4e-3):
                task = Task(program, method, "modified Newton", model, 10, "dt", dt, lambda: None)
                note = f"no convergence at t = {k} s" * (dt == 4e-3)
                error = math.nan if note else (k + 1) * dt**2
                points.append(Point(task, 1e-3 / dt, error, {"residuals": round(1 / dt)}, note))
    reference = Reference(None, 1e-12, "by hand")
    both = study(*points)
    readable(chart(replace(both, references=dict.fromkeys((MODEL, "L2T2", "Thick"), reference))))


def test_ratios_and_targets_of_hand_made_curves():
    exudyn = [point("Exudyn", 0.1, 1e-3), point("Exudyn", 0.3, 1e-5)]
    explicit = point("Exudyn", 0.02, 1e-6, solver="")
    result = study(*OURS_CURVE, *exudyn)
    assert result.ratio(MODEL, "Exudyn", 1e-3) == pytest.approx(10.0)
    assert result.ratio(MODEL, "Exudyn", 9e-4) == pytest.approx(10.0)  # next smaller errors
    assert math.isinf(result.ratio(MODEL, "Exudyn", 1e-6))
    assert math.isnan(result.ratio(MODEL, "Exudyn", 1e-7))
    assert [t.is_met for t in result.targets()] == [True, True]

    result = study(*OURS_CURVE, *exudyn, explicit)
    assert result.ratio(MODEL, "Exudyn", 1e-6) == pytest.approx(0.2)
    assert result.ratio(MODEL, "Exudyn", 1e-5, implicit=True) == pytest.approx(10.0)
    quick = study(*OURS_CURVE, *exudyn, point(OURS, 0.001, 1e-5, solver=""))
    assert quick.ratio(MODEL, "Exudyn", 1e-5, implicit=True) == pytest.approx(300.0)
    assert quick.ratio(MODEL, "Exudyn", 1e-5, implicit=True, alike=True) == pytest.approx(10.0)
    assert any("implicit against implicit, Exudyn takes 10.0" in s for s in findings(quick))
    assert [t.is_met for t in result.targets()] == [False, True]

    slow = study(*OURS_CURVE, point("Exudyn", 0.04, 1e-3), point("Exudyn", 0.12, 1e-5))
    assert [t.is_met for t in slow.targets()] == [True, False]


def test_findings_name_who_is_fastest_whoever_it_is():
    def said(*others):
        return "\n".join(findings(study(*OURS_CURVE, *others)))

    ahead = said(point("Exudyn", 0.1, 1e-3), point("SciPy", 0.5, 1e-5))
    assert "Exudyn takes 10.0 to 10.0 times as long" in ahead
    assert "it is faster at" not in ahead
    assert "fewest evaluations" not in ahead
    behind = said(point("SUNDIALS", 0.005, 1e-5, solver=""))
    assert "SUNDIALS takes 0.2 to " in behind
    assert "it is faster at" in behind
    assert "only it has a result" in said(point("SciPy", 0.5, 1e-9, solver=""))
    thrifty = said(point("SciPy", 0.5, 1e-5, solver="", residuals=99))
    assert "SciPy's trapezoidal needs the fewest" in thrifty


def test_record_and_page_hold_failures_and_verdicts():
    result = study(*OURS_CURVE, point("Exudyn", math.nan, math.nan, note="gave up at t = 1 s"))
    data = json.loads(json.dumps([p.record() for p in result.points], allow_nan=False))
    assert data[-1]["note"] == "gave up at t = 1 s"
    assert data[-1]["tip_error_m"] is None
    page = STUDY.region("work-precision", result)
    assert "| 1e-05 | trapezoidal, Newton, 0.001 s | 30.0 |" in page


def test_solvers_of_a_row_are_those_of_both_lists():
    row = Integrator("Newmark(0)", (1e-3, 3e-4), ("BFGS", "Newton"))
    names = [t.name for t in candidates(MODEL, 4, 2.0, [row], ("Newton", "Davidon"))]
    assert names == ["Newmark(0), Newton"]  # and 3e-4 s does not meet the output times
    explicit = Integrator("Explicit", (1e-3,), ())
    assert [t.solver for t in candidates(MODEL, 4, 2.0, [explicit])] == [""]


def test_command_writes_tables_and_charts_without_peers(run_study, monkeypatch):
    for name in ("exudyn", "benchmarks.other_codes._sundials", "elastica"):
        monkeypatch.setitem(sys.modules, name, None)
    words = ["--elements", "4", "--time", "0.08", "--rounds", "1", "--peers"]
    written = run_study("accuracy work-precision", *words)
    assert written.out.count("pip install 'ancfsparse[peers]'") == 2
    assert written.out.count("`make peers`") == 1
    assert {row["program"] for row in written.table} == {OURS, "SciPy"}
    assert all(row["note"] or float(row["seconds"]) > 0.0 for row in written.table)
    assert len(written.data["points"]) == len(written.table)
    assert written.data["references"]["L2T2"]["uncertainty"] < 1e-9
