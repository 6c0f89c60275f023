"""The convention of studies: what is written, what a page gets, and that every page has a place."""

import csv
import json
import re
from dataclasses import replace
from pathlib import Path

import pytest
from matplotlib.figure import Figure

from ancfsparse.studies import commands
from ancfsparse.studies.common.study import Study
from ancfsparse.studies.common.tables import table, with_findings
from ancfsparse.studies.common.target import Target
from ancfsparse.studies.table1.report import STUDY as TABLE1

ROOT = Path(__file__).parents[2]
STUDIES = [TABLE1, *(each for each in vars(commands).values() if isinstance(each, Study))]

SQUARES = Study(
    "squares",
    run=lambda n, progress=False: [k * k for k in range(n)],
    text=str,
    rows=lambda squares: [{"number": k, "square": s} for k, s in enumerate(squares)],
    record=lambda squares: {"squares": squares},
    findings=lambda squares: [f"The largest is {max(squares)}."],
    targets=lambda squares: [Target("largest", max(squares), 4.0)],
    charts={"first": lambda squares: Figure(), "second": lambda squares: Figure()},
    regions={"squares": str, "second": lambda squares: "more"},
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
    bare = Study("bare", run=list, text=str, rows=lambda numbers: [{"n": n} for n in numbers])
    assert [path.name for path in bare.write([1], tmp_path)] == ["bare.csv"]


@pytest.mark.parametrize("gallery", ["gallery", "docs/gallery"])
def test_a_region_gets_its_text_and_its_own_chart_or_the_first(tmp_path, gallery):
    study = replace(SQUARES, gallery=gallery)
    page = tmp_path / "page.md"
    page.write_text(
        "".join(f"<!-- {name}:begin --><!-- {name}:end -->\n" for name in study.regions)
    )
    results = tmp_path / "results"
    study.check(results, page)
    study.write([0, 1], results)
    study.fill([0, 1], page, results)
    assert "<!-- squares:begin -->\n[0, 1]\n<!-- squares:end -->" in page.read_text()
    assert "<!-- second:begin -->\nmore\n<!-- second:end -->" in page.read_text()
    assert {p.name for p in (tmp_path / gallery).iterdir()} == {"first.png", "second.png"}


def test_tables_of_pages():
    lines = table(["", "s", "name"], [["a", "1", ""], ["b", "", "x"]], left=(0, 2))
    assert lines == ["| | s | name |", "|---|---:|---|", "| a | 1 | |", "| b | | x |"]
    assert with_findings(["text"], ["One.", "Two."]) == "text\n\n- One.\n- Two."


def test_names_of_studies_regions_and_charts_are_their_own():
    for names in (
        [study.name for study in STUDIES],
        [name for study in STUDIES for name in study.charts],
        [name for study in STUDIES for name in study.regions],
    ):
        assert len(names) > 6
        assert len(set(names)) == len(names)


@pytest.mark.parametrize("study", STUDIES, ids=lambda study: study.name)
def test_every_region_has_its_place_on_one_page_beside_its_gallery(study):
    for marker in study.regions:
        pages = [
            page for page in (ROOT / "README.md", *(ROOT / "docs").glob("*.md"))
            if re.search(f"<!-- {marker}:begin -->", page.read_text(encoding="utf-8"))
        ]  # fmt: skip
        assert len(pages) == 1, marker
        stem = marker if marker in study.charts else next(iter(study.charts))
        assert (pages[0].parent / study.gallery / f"{stem}.png").is_file()
