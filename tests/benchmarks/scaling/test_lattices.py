"""The study of lattices on tiny sizes: what it writes and says."""

import pytest

from benchmarks.scaling.lattice_jobs import OTHERS, RUNS, Job, jobs_of
from benchmarks.scaling.lattice_report import STUDY, chart, findings, targets
from benchmarks.scaling.lattices import Row, _again_in_turn, in_process, pairs, run


def row(size, factorization, seconds, case="lattice", threads=1, jitter=0.0, **more):
    job = Job(case, size, "soft", "rest", 1e-3, 10, factorization, jitter, threads=threads)
    record = {"seconds": seconds, "set_up_seconds": 2.0 * seconds, "corrections": 3.0}
    record |= {"sweeps": 4.0, "products": 1.0, "factorizations": 2, "recoveries": 0}
    record |= {"peak_bytes": 10**8 + 10**5 * seconds, "base_bytes": 10**8}
    return Row(job, record | more)


def test_study_on_tiny_sizes(run_study, monkeypatch):
    # All in this process, whose memory says nothing.
    monkeypatch.setattr("benchmarks.scaling.lattice_jobs.OCTETS", {1: 3, 2: 6})
    here = "benchmarks.scaling.lattices.in_process"
    monkeypatch.setattr(here, lambda job: run(job) | {"base_bytes": 0})
    words = ["--largest", "3", "--largest-net", "3", "--largest-exact", "3", "--steps", "2"]
    out, table, data, page = run_study("scaling lattices", *words, "--threads", "2")
    assert "steel lattice, at rest, 0.004 s" in out
    scenes = 1 + 2 * len(RUNS) + len(OTHERS)
    assert len(table) == 2 * scenes + 3  # the last three on two threads
    assert [line["threads"] for line in table[-4:]] == ["1", "2", "2", "2"]
    assert {line["elements"] for line in table if line["case"] == "octet"} == {"36"}
    assert not any(line["note"] for line in table)
    assert all(float(line["microseconds"]) > 0 for line in table)
    incomplete = [line for line in table if line["factorization"] == "incomplete"]
    assert all(float(line["sweeps"]) >= float(line["corrections"]) for line in incomplete)
    exact = [line for line in table if line["factorization"] == "complete"]
    assert all(1.0 <= float(line["fill"]) < 3.0 for line in exact)
    assert len(data["findings"]) == scenes + 2 + 3  # who wins by what; gains of two threads
    assert [each["what"] for each in data["targets"]] == [
        f"{case}, 3: gain of 2 threads"
        for case in (
            "soft lattice, at rest, 0.001 s",
            "steel lattice, at rest, 0.004 s",
            "steel lattice, at rest, 0.01 s",
        )
    ]
    assert "| net, at rest, 0.0005 s | 3 nodes a side | complete | 12 |" in page


def test_what_is_said_follows_the_rows():
    rows = [row(10, "complete", 8.0), row(10, "incomplete", 2.0), row(20, "incomplete", 30.0)]
    rows.append(row(20, "complete", 1.0, note="too large: it does not fit"))
    assert [(a.job.factorization, b.job.factorization) for a, b in pairs(rows)] == [
        ("complete", "incomplete")
    ]
    first, second = findings(rows)
    assert targets(rows) == []
    assert "takes 4 times the time per step, 4 times the set-up, 4 times the memory" in first
    assert "costs 1.78 times as much per element as of 2,700" in second
    assert "too large" in STUDY.text(rows)


def test_what_is_aimed_at_is_looked_up():
    rows = [
        row(n, factorization, 0.1 * n)
        for n in (10, 22, 46)
        for factorization in ("complete", "incomplete")
    ]
    rows += [row(46, "incomplete", 2.0, threads=2), row(16, "incomplete", 4.0, "statics")]
    found = {target.what: target for target in targets(rows)}
    assert len(found) == 8
    of_22 = "soft lattice, at rest, 0.001 s, 22: complete / incomplete, "
    assert found[of_22 + "step"].value == found[of_22 + "memory"].value == 1.0
    assert not found[of_22 + "set-up"].is_met
    growth = found["soft lattice: cost per element, 46 / 10"]
    assert growth.value == pytest.approx(4.6 * 2700 / 285_660)
    assert growth.is_met
    gain = found["soft lattice, at rest, 0.001 s, 46: gain of 2 threads"]
    assert gain.value == pytest.approx(2.3)
    assert found["soft lattice, equilibrium, 16: s"].value == 4.0
    assert found["soft lattice, 46: GB at the peak"].value == pytest.approx(0.10046)


def test_from_which_fill_on_seeds_win_is_said():
    rows = []
    for n, fill, seconds in ((3, 1.5, 0.5), (4, 2.5, 2.0), (5, 3.5, 0.9), (6, 5.0, 9.0)):
        rows += [row(n, "complete", seconds, fill=fill), row(n, "incomplete", 1.0)]
    by_steps, with_set_up = findings(rows)[-2:]
    assert by_steps == (
        "By steps, complete seeds win 2 times, up to a fill of 3.5; incomplete ones 2 times, from "
        "a fill of 2.5 on, and always from 5 on"
    )
    assert with_set_up.startswith("By set-up and steps, complete seeds win 2 times")


def test_all_that_is_asked_for_is_listed():
    jobs = jobs_of(46, 200, 16, 20, 2)
    assert len(set(jobs)) == len(jobs)
    expected = {"steel irregular lattice, rough, 0.001 s", "soft lattice on rods, at rest, 0.001 s"}
    assert expected <= {job.title for job in jobs}
    exact = [job for job in jobs if job.factorization == "complete"]
    assert max(job.size for job in exact if job.case == "lattice") == 22
    special = [job for job in jobs if job.threads == 2 or job.case == "statics"]
    assert {job.factorization for job in special} == {"incomplete"}


def test_runs_on_one_and_two_threads_are_compared_by_the_fastest_in_turn(monkeypatch):
    rows = [row(10, "incomplete", 3.0), row(10, "complete", 5.0)]
    rows.append(row(10, "incomplete", 2.0, threads=2))
    seconds, ran = iter([4.0, 1.5, 2.5, 1.0]), []

    def answer(job):
        ran.append(job.threads)
        return {"seconds": next(seconds)}

    monkeypatch.setattr("benchmarks.scaling.lattices.in_process", answer)
    _again_in_turn(rows)
    assert ran == [1, 2, 1, 2]
    assert [each.record["seconds"] for each in rows] == [2.5, 5.0, 1.0]


def test_the_chart_can_be_read(readable):
    rows = [
        row(n, factorization, 0.1 * n)
        for n in (10, 20)
        for factorization in ("complete", "incomplete")
    ]
    readable(chart(rows))
    rows += [row(n, "incomplete", 0.2 * n, "octet") for n in (4, 8)]
    rows += [row(n, "incomplete", 0.3 * n, jitter=0.2) for n in (10, 20)]
    figure = chart(rows)
    readable(figure)
    above, _, between, _, below, _ = figure.axes
    # Lattices on both kinds of seeds, and trusses in their colour.
    assert [len(ax.lines) for ax in (above, between, below)] == [2, 1, 1]
    assert above.lines[1].get_color() == below.lines[0].get_color()
    readable(chart([row(10, "exact", 1.0, note="too large")]))


def test_a_process_of_its_own_answers():
    record = in_process(Job("lattice", 4, "steel", "rough", 1e-3, 2, "incomplete"))
    assert record["seconds"] > 0
    assert record["peak_bytes"] >= record["base_bytes"] > 10**7


def test_a_run_that_cannot_be_leaves_a_note():
    note = run(Job("lattice", 2, "soft", "rest", 1e-3, 1, "none"))["note"]
    assert "unknown factorization" in note
    note = in_process(Job("lattice", 2, "glass", "rest", 1e-3, 1, "complete"))["note"]
    assert "exit code" in note
