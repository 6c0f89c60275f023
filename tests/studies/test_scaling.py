"""The scaling study on tiny sizes: what it writes, and what it says when something cannot run."""

import csv
import json
import sys

import pytest

from ancfsparse.cli import main
from ancfsparse.studies import roofline as module
from ancfsparse.studies import scaling_job
from ancfsparse.studies.roofline import Loop, Roofline, roofline, triad
from ancfsparse.studies.scaling import Row, Scaling, ratios, scaling, slope
from ancfsparse.studies.scaling_job import SOLVERS, Job, Worker
from ancfsparse.studies.scaling_report import as_text, chart

QUICK = Roofline(20.0, [Loop("solve", 100, 10.0, 50.0, 30.0), Loop("factor", 100, 5.0)])


def rows(size, seconds, note=""):
    job = Job("chain", size, "rest", "auto", 10, 5e-4)
    record = {"iterations_per_step": 1.5, "factorizations": 1, "recoveries": 0}
    record |= {"set_up_seconds": 0.1, "peak_bytes": 10**8 + 500 * size, "base_bytes": 10**8}
    result = []
    for name, each in seconds.items():
        mine = {"note": note} if not each else record
        result.append(Row(Job(**{**vars(job), "solver": name}), each, mine))
    return result


def test_study_on_tiny_sizes(tmp_path, capsys, monkeypatch):
    monkeypatch.setattr("ancfsparse.studies.scaling.roofline", lambda n: QUICK)
    words = ["--largest", "12", "--largest-net", "3", "--steps", "4", "--rounds", "1"]
    with pytest.raises(SystemExit) as left:
        main(["study", "scaling", *words, "--output", str(tmp_path)])
    out = capsys.readouterr().out
    assert left.value.code == 0
    assert "net falling from rest, 3: 12 elements, 69 unknowns" in out
    assert "chain in rough motion, 12: 12 elements, 50 unknowns" in out
    with (tmp_path / "scaling.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert len(table) == 5 * len(SOLVERS)  # chains of 10 and 12 in two motions, and a net
    assert all(float(row["microseconds_per_element_and_step"]) > 0 for row in table)
    assert all(float(row["iterations_per_step"]) >= 1 for row in table)
    data = json.loads((tmp_path / "scaling.json").read_text(encoding="utf-8"))
    assert len(data["rows"]) == len(table)
    assert data["roofline"]["loops"][0]["share_of_triad"] == 0.25
    assert (tmp_path / "scaling.png").stat().st_size > 10_000


def test_what_threads_gain_is_told():
    group = rows(10**6, {"auto": [3.0, 4.0, 3.0]})
    job = Job("chain", 10**6, "rest", "auto, 2 threads", 10, 5e-4, 2)
    group.append(Row(job, [2.0, 2.0, 2.0], group[0].record))
    assert ratios(group)["gain of 2 threads"] == pytest.approx(1.5)
    small = rows(1000, {"auto": [1e-3, 1e-3, 1e-3]})
    result = Scaling(small + group, [], QUICK, {})
    assert result.growth() == {"1,000,000 over 1,000 elements": pytest.approx(3.0)}


def test_threads_run_beside_auto(monkeypatch):
    monkeypatch.setattr("ancfsparse.studies.scaling.roofline", lambda n: QUICK)
    result = scaling(10, 2, 0, rounds=1, threads=2)
    found = [row for row in result.rows if row.job.threads == 2]
    assert [row.job.solver for row in found] == ["auto, 2 threads"] * 2
    assert not any(row.note for row in found)
    assert "auto, 2 threads" in as_text(result)


def test_a_process_answers_with_results_and_with_notes():
    with Worker() as worker:
        good = worker.run(Job("net", 3, "smooth", "Newton", 3, 5e-4))
        bad = worker.run(Job("chain", 2000, "rest", "Davidon, dense", 3, 5e-4))
        again = worker.run(Job("net", 3, "smooth", "Newton", 3, 5e-4))
    assert good["seconds"] > 0
    assert good["peak_bytes"] >= good["base_bytes"] > 10**7
    assert "dense inverse" in bad["note"]
    assert again["iterations_per_step"] == good["iterations_per_step"]


def test_a_process_that_dies_leaves_a_note():
    with Worker() as worker:
        worker.process.kill()
        worker.process.wait()
        record = worker.run(Job("chain", 5, "rest", "auto", 1, 5e-4))
    assert record["note"] == "the process died with exit code -9"


def test_peers_run_the_same_scenes():
    pytest.importorskip("exudyn")
    for case, size in (("chain", 5), ("net", 3)):
        job = Job(case, size, "rough", "Exudyn, full Newton", 5, 5e-4)
        record = scaling_job.run(job, 0)
        assert record["seconds"] > 0
        assert 1.0 <= record["iterations_per_step"] < 5.0


def test_without_exudyn_nothing_is_run(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "exudyn", None)
    with pytest.raises(SystemExit) as left:
        main(["study", "scaling", "--peers"])
    assert left.value.code == 2
    assert "pip install 'ancfsparse[peers]'" in capsys.readouterr().err


def test_ratios_are_medians_of_rounds_in_turn():
    seconds = {"auto": [1.0, 4.0, 1.0], "Newton": [3.0, 12.0, 5.0]}
    seconds |= {"modified Newton": [0.5, 4.0, 2.0], "Davidon, dense": []}
    group = rows(100, seconds, "too large")
    found = ratios(group)
    assert found["Newton / auto"] == 3.0
    assert found["auto / best fixed"] == 1.0
    counts = {"scene": "chain falling from rest", "size": 100, "elements": 100, "unknowns": 400}
    counts |= {"pattern_entries": 9, "factor_entries": 8, "factor_flops": 9, "ordering": "amd"}
    result = Scaling(group, [counts], QUICK, {"dt_s": 5e-4, "steps": 10, "rounds": 3})
    assert "too large" in as_text(result)
    assert "0.1 GB/s" not in as_text(result)
    assert "Newton takes 3.0 times as long as auto at 100" in chart(result).axes[0].get_title()


def test_slope_leaves_out_small_sizes():
    assert slope([(10, 1e9), (1000, 2.0), (10_000, 20.0)]) == pytest.approx(1.0)
    assert slope([(10, 1.0), (1000, 2.0)]) != slope([(10, 1.0), (1000, 2.0)])  # NaN


def test_roofline_measures_something(monkeypatch):
    assert triad(10_000, 2) > 0.1
    monkeypatch.setattr(module, "time_kernel", lambda kind, kernel, **how: 10.0)
    result = roofline(50, 10_000)
    assert [each.name for each in result.loops] == [
        "factor", "solve", "kernel residual", "kernel residual", "kernel tangent", "kernel tangent",
    ]  # fmt: skip
    assert all(each.nanoseconds > 0 for each in result.loops)
    assert "of triad" in str(result)
