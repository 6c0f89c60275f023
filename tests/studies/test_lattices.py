"""The study of lattices on tiny sizes: what it writes and says."""

import csv
import json

import pytest

from ancfsparse.cli import main
from ancfsparse.studies.lattices.report import as_text, chart, findings
from ancfsparse.studies.lattices.run import RUNS, Job, Row, in_process, pairs, run


def row(size, seed, seconds, case="lattice", **more):
    job = Job(case, size, "soft", "rest", 1e-3, 10, seed)
    record = {"seconds": seconds, "set_up_seconds": 2.0 * seconds, "corrections": 3.0}
    record |= {"sweeps": 4.0, "products": 1.0, "factorizations": 2, "recoveries": 0}
    record |= {"peak_bytes": 10**8 + 10**5 * seconds, "base_bytes": 10**8}
    return Row(job, record | more)


def test_study_on_tiny_sizes(tmp_path, capsys, monkeypatch):
    # All in this process, whose memory says nothing.
    monkeypatch.setattr("ancfsparse.studies.lattices.run.OCTETS", {1: 3, 2: 6})
    here = "ancfsparse.studies.lattices.run.in_process"
    monkeypatch.setattr(here, lambda job: run(job) | {"base_bytes": 0})
    page = tmp_path / "page.md"
    page.write_text("<!-- lattices:begin -->\n<!-- lattices:end -->\n", encoding="utf-8")
    words = ["--largest", "3", "--largest-net", "3", "--largest-exact", "3", "--steps", "2"]
    with pytest.raises(SystemExit) as left:
        main(["study", "lattices", *words, "--output", str(tmp_path), "--page", str(page)])
    out = capsys.readouterr().out
    assert left.value.code == 0
    assert "steel lattice, at rest, 0.004 s" in out
    with (tmp_path / "lattices.csv").open(encoding="utf-8") as file:
        table = list(csv.DictReader(file))
    assert len(table) == 2 * (1 + 2 * len(RUNS))
    assert {line["elements"] for line in table if line["case"] == "octet"} == {"36"}
    assert not any(line["note"] for line in table)
    assert all(float(line["microseconds"]) > 0 for line in table)
    incomplete = [line for line in table if line["seed"] == "incomplete"]
    assert all(float(line["sweeps"]) >= float(line["corrections"]) for line in incomplete)
    assert len(json.loads((tmp_path / "lattices.json").read_text())["findings"]) == 1 + 2 * len(
        RUNS
    )
    assert "| net, at rest, 0.0005 s | 3 nodes a side | exact | 12 |" in page.read_text(
        encoding="utf-8"
    )
    assert (tmp_path / "gallery" / "lattices.png").stat().st_size > 10_000


def test_what_is_said_follows_the_rows():
    rows = [row(10, "exact", 8.0), row(10, "incomplete", 2.0), row(20, "incomplete", 30.0)]
    rows.append(row(20, "exact", 1.0, note="too large: it does not fit"))
    assert [(a.job.seed, b.job.seed) for a, b in pairs(rows)] == [("exact", "incomplete")]
    first, second = findings(rows)
    assert "takes 4 times the time per step, 4 times the set-up, 4 times the memory" in first
    assert "costs 1.78 times as much per element as of 2,700" in second
    assert "too large" in as_text(rows)


def test_the_chart_can_be_read(readable):
    rows = [row(n, seed, 0.1 * n) for n in (10, 20) for seed in ("exact", "incomplete")]
    readable(chart(rows))
    rows += [row(n, "incomplete", 0.2 * n, "octet") for n in (4, 8)]
    figure = chart(rows)
    readable(figure)
    above, _, below, _ = figure.axes
    # Lattices on both kinds of seeds, and trusses in their colour.
    assert len(above.lines) == len(below.lines) == 2
    assert above.lines[1].get_color() == below.lines[1].get_color()
    readable(chart([row(10, "exact", 1.0, note="too large")]))


def test_a_process_of_its_own_answers():
    record = in_process(Job("lattice", 4, "steel", "rough", 1e-3, 2, "incomplete"))
    assert record["seconds"] > 0
    assert record["peak_bytes"] >= record["base_bytes"] > 10**7


def test_a_run_that_cannot_be_leaves_a_note():
    assert "unknown seed" in run(Job("lattice", 2, "soft", "rest", 1e-3, 1, "none"))["note"]
    assert "exit code" in in_process(Job("lattice", 0, "soft", "rest", 1e-3, 1, "exact"))["note"]
