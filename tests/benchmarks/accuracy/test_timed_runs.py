"""Runs in turn: best times, failures that stay, and who is fastest at an error."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from tqdm import tqdm

from benchmarks.accuracy.comparison import failures
from benchmarks.accuracy.models import OUTPUTS, distance, meets_outputs, output_times, step_up_to
from benchmarks.accuracy.timed_runs import FailedError, Point, Sample, Task, fastest, front, measure
from benchmarks.common.files import fill_page
from benchmarks.common.timing import OURS, in_turn

TRUE = np.zeros((OUTPUTS, 2))


def a_task(run, value=1e-3, program=OURS):
    return Task(program, "Newmark(0)", "Newton", "Thin", 10, "dt", value, run)


def a_point(seconds, error, program=OURS, solver="Newton", note="", value=1e-3, counts=None):
    task = Task(program, "some", solver, "Thin", 10, "dt", value, lambda: None)
    return Point(task, seconds, error, counts or {"residuals": 100}, note)


def measured(tasks, rounds):
    return measure(tasks, lambda task: TRUE, rounds, tqdm(disable=True))


def test_the_best_of_the_rounds_counts_and_rounds_are_interleaved():
    order, times = [], {"a": [0.3, 0.1, 0.2], "b": [0.2, 0.4, 0.3]}

    def runner(name):
        def run():
            order.append(name)
            return Sample(times[name][order.count(name) - 1], TRUE + 0.5, {"steps": 4})

        return run

    a, b = measured([a_task(runner("a")), a_task(runner("b"), 2e-3)], 3)
    assert order == ["a", "b"] * 3
    assert (a.seconds, b.seconds) == (0.1, 0.2)
    assert a.error == pytest.approx(math.sqrt(0.5))
    assert a.counts == {"steps": 4}


def test_failures_stay_with_their_reason_and_are_not_repeated():
    calls = []

    def fail():
        calls.append(1)
        raise FailedError("no convergence at t = 1.3 s")

    lost = a_task(lambda: Sample(0.1, TRUE + 1e10), 2e-3)
    nowhere = a_task(lambda: Sample(0.1, TRUE + math.nan), 3e-3)
    points = measured([a_task(fail), lost, nowhere], 3)
    assert len(calls) == 1
    assert not any(p.finished for p in points)
    assert points[0].note == "no convergence at t = 1.3 s"
    assert "off by 1e+10 m" in points[1].note
    assert points[0].record()["seconds"] is None
    lines = failures(points)
    assert lines[0] == "Newmark(0) (Newton), 10 Thin, dt = 0.001: no convergence at t = 1.3 s"
    assert len(lines) == 3


def test_waiting_for_the_processor_is_not_counted(monkeypatch):
    # Clocks of the test's own: on a busy machine other threads of this process count as well.
    wall, busy = [0.0], [0.0]
    clocks = SimpleNamespace(perf_counter=lambda: wall[0], process_time=lambda: busy[0])
    monkeypatch.setattr("benchmarks.accuracy.timed_runs.time", clocks)

    def wait(share):
        wall[0] += 0.05
        busy[0] += 0.01
        return Sample(share * 0.05, TRUE)

    most, little = measured([a_task(lambda: wait(1.0)), a_task(lambda: wait(0.5), 2e-3)], 1)
    assert most.seconds == pytest.approx(0.01)
    assert little.seconds == 0.025


def test_a_long_run_is_not_repeated():
    calls = []

    def slow():
        calls.append(1)
        return Sample(3.0, TRUE)

    measured([a_task(slow)], 4)
    assert len(calls) == 1


def test_fastest_and_front_are_what_trying_all_pairs_finds():
    random = np.random.default_rng(3)
    points = [a_point(*each) for each in random.uniform(0.1, 1.0, (60, 2))]
    points.append(a_point(math.nan, math.nan, note="failed"))
    good = points[:-1]
    for level in (0.05, 0.2, 0.5, 2.0):
        allowed = [p.seconds for p in good if p.error <= level]
        best = fastest(points, level)
        assert (best is None) == (not allowed)
        assert best is None or best.seconds == min(allowed)
    undominated = {
        id(p)
        for p in good
        if not any(q.seconds < p.seconds and q.error <= p.error for q in good)
        and not any(q.seconds <= p.seconds and q.error < p.error for q in good)
    }
    assert {id(p) for p in front(points)} == undominated


def test_output_times_and_the_steps_that_meet_them():
    np.testing.assert_allclose(output_times(2.0), [0.5, 1.0, 1.5, 2.0], rtol=1e-15)
    assert meets_outputs(5e-4, 2.0)
    assert not meets_outputs(3e-4, 2.0)
    assert not meets_outputs(0.6, 2.0)
    assert step_up_to(5e-4, 2.0) == 5e-4
    dt = step_up_to(5e-4, 0.03)
    assert dt <= 5e-4
    assert meets_outputs(dt, 0.03)
    assert distance(TRUE, TRUE + np.array([3.0, 4.0])) == pytest.approx(5.0)


def test_pages_are_filled_between_their_markers(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("a\n<!-- x:begin -->\nold\n<!-- x:end -->\nb\n", encoding="utf-8")
    chart = tmp_path / "elsewhere" / "chart.png"
    chart.parent.mkdir()
    chart.write_bytes(b"picture")
    fill_page(page, "x", "new", chart)
    assert (tmp_path / "gallery" / "chart.png").read_bytes() == b"picture"
    text = page.read_text(encoding="utf-8")
    assert text == "a\n<!-- x:begin -->\nnew\n<!-- x:end -->\nb\n"
    with pytest.raises(ValueError, match="no place for y"):
        fill_page(page, "y", "new", chart)
    assert page.read_text(encoding="utf-8") == text


def test_entrants_run_in_turn_until_they_need_not_go_on():
    order = []

    def run(entrant):
        order.append(entrant)
        return len(order)

    found = in_turn("ab", run, 3, goes_on=lambda entrant, kept: entrant == "a" or len(kept) < 2)
    assert "".join(order) == "ababa"
    assert found == [[1, 3, 5], [2, 4]]
    assert in_turn("ab", run, 0) == [[], []]
