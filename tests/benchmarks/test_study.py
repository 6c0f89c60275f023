"""The convention of studies: what is written, what a page gets, and that every page has a place."""

import csv
import json
import math
import re
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from matplotlib.figure import Figure

from benchmarks import commands
from benchmarks.common.files import plain
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, bullets
from benchmarks.common.target import Target

ROOT = Path(__file__).parents[2]
STUDIES = list(commands.STUDIES.values())


def squares_table(squares):
    rows = [[str(k), str(square)] for k, square in enumerate(squares)]
    return Table(["number", "square"], rows, title="Squares")


SQUARES = Study(
    "squares",
    run=lambda n, progress=False: [k * k for k in range(n)],
    heading=lambda squares: f"{len(squares)} squares",
    tables=lambda squares: [squares_table(squares)],
    rows=lambda squares: [{"number": k, "square": s} for k, s in enumerate(squares)],
    record=lambda squares: {"squares": squares},
    findings=lambda squares: [f"The largest is {max(squares)}."],
    targets=lambda squares: [Target("largest", max(squares), 4.0)],
    charts={"first": lambda squares: Figure(), "second": lambda squares: Figure()},
    notes=lambda squares: ["One note."],
    regions={"squares": squares_table, "second": lambda squares: "more"},
)


def test_a_study_writes_tables_and_charts(tmp_path):
    paths = SQUARES.write(SQUARES.run(3), tmp_path / "new")
    assert [path.name for path in paths] == [
        "squares.csv",
        "squares.json",
        "first.png",
        "second.png",
    ]
    with paths[0].open(newline="", encoding="utf-8") as file:
        assert [row["square"] for row in csv.DictReader(file)] == ["0", "1", "4"]
    data = json.loads(paths[1].read_text(encoding="utf-8"))
    assert data["squares"] == [0, 1, 4]
    assert data["findings"] == ["The largest is 4."]
    assert data["targets"] == [{"what": "largest", "value": 4, "at_least": 4.0, "met": True}]


def test_a_table_alone_is_enough(tmp_path):
    bare = Study(
        "bare",
        run=list,
        tables=lambda numbers: [],
        rows=lambda numbers: [{"n": n} for n in numbers],
    )
    assert [path.name for path in bare.write([1], tmp_path)] == ["bare.csv", "bare.json"]
    assert json.loads((tmp_path / "bare.json").read_text(encoding="utf-8")) == {"rows": [1]}


def test_a_result_is_written_as_json_has_it():
    class Spot(NamedTuple):
        x: float

    @dataclass
    class Found:
        spots: list[Spot]
        at: dict[tuple[str, str], np.ndarray]
        longest: float
        scene: object = field(repr=False)

    found = Found([Spot(1.0)], {("a", "b"): np.array([2.0, np.inf])}, math.nan, object())
    expected = {"spots": [{"x": 1.0}], "at": {"a, b": [2.0, None]}, "longest": None}
    assert plain(found) == expected


@pytest.mark.parametrize(("name", "gallery"), [("a.md", "gallery"), ("README.md", "docs/gallery")])
def test_a_region_gets_its_text_and_its_own_chart_or_the_first(tmp_path, name, gallery):
    study, page = SQUARES, tmp_path / name
    page.write_text(
        "".join(f"<!-- {name}:begin --><!-- {name}:end -->\n" for name in study.regions)
    )
    results = tmp_path / "results"
    study.check(results, [page])
    study.write([0, 1], results)
    study.fill([0, 1], page, results)
    region = "| number | square |\n|---|---:|\n| 0 | 0 |\n| 1 | 1 |\n\n- The largest is 1."
    assert f"<!-- squares:begin -->\n{region}\n<!-- squares:end -->" in page.read_text()
    assert "<!-- second:begin -->\nmore\n<!-- second:end -->" in page.read_text()
    assert {p.name for p in (tmp_path / gallery).iterdir()} == {"first.png", "second.png"}


def test_tables_of_pages():
    found = Table(["", "s", "name"], [["a", "1", ""], ["b", "", "x"]], left=(0, 2))
    assert found.markdown() == ["| | s | name |", "|---|---:|---|", "| a | 1 | |", "| b | | x |"]
    assert bullets(["One.", "Two"]) == ["- One.", "- Two."]


def test_a_terminal_gets_columns_findings_targets_and_notes():
    assert SQUARES.text([0, 1, 16]) == (
        "3 squares\n\n"
        "Squares\n  number  square\n  0            0\n  1            1\n  2           16\n\n"
        "The largest is 16.\n\n" + str(Target("largest", 16, 4.0)) + "\n\nOne note."
    )


def test_names_of_studies_regions_and_charts_are_their_own():
    for names in (
        [study.name for study in STUDIES],
        [name for study in STUDIES for name in study.charts],
        [name for study in STUDIES for name in study.regions],
    ):
        assert len(names) > 6
        assert len(set(names)) == len(names)


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_every_region_has_its_place_on_one_page_with_its_gallery(study):
    for marker in study.regions:
        pages = [
            page for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))
            if re.search(f"<!-- {marker}:begin -->", page.read_text(encoding="utf-8"))
        ]  # fmt: skip
        assert len(pages) == 1, marker
        stem = marker if marker in study.charts else next(iter(study.charts), None)
        assert stem is None or (ROOT / "docs" / "gallery" / f"{stem}.png").is_file()


@pytest.mark.parametrize("words", commands.STUDIES)
def test_every_command_shows_its_options(words, capsys):
    code, text, _ = run(capsys, *words.split(), "--help")
    assert code == 0
    assert "--output" in text
    assert "--page" in text
    assert "--progress" not in text


def run(capsys, *words):
    with pytest.raises(SystemExit) as left:
        commands.main(words)
    out, err = capsys.readouterr()
    return left.value.code, out, err


@pytest.mark.parametrize("words", commands.STUDIES)
def test_outputs_are_checked_before_a_study(capsys, tmp_path, words):
    file = tmp_path / "a.md"
    file.write_text("a page without markers\n", encoding="utf-8")
    cases = [
        (("--page", str(file)), "has no place for"),
        (("--page", str(tmp_path / "no.md")), "no such page"),
        *((("--output", str(each)), "cannot be a folder") for each in (file, file / "deeper")),
    ]
    for options, sentence in cases:
        code, out, err = run(capsys, *words.split(), *options)
        assert (code, out) == (2, "")
        assert sentence in err


@pytest.mark.parametrize("words", [["speed", "pendulum"], ["scaling", "sizes", "--peers"]])
def test_without_exudyn_nothing_is_run(monkeypatch, capsys, words):
    monkeypatch.setitem(sys.modules, "exudyn", None)
    code, _, err = run(capsys, *words)
    assert code == 2
    assert "pip install 'ancfsparse[peers]'" in err
    assert err.count("\n") == 1
