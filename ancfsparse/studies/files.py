"""What studies write: tables, charts, and regions of a page."""

from __future__ import annotations

import csv
import json
import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from ancfsparse.errors import InputError

DPI = 120


def write_csv(records: Sequence[dict[str, Any]], path: Path) -> None:
    """Write one line per record; what a record lacks is left empty."""
    names = list(dict.fromkeys(key for record in records for key in record))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(records)


def save(figure: Figure, path: Path) -> None:
    """Write a chart."""
    figure.savefig(path, dpi=DPI)


def write_json(data: dict[str, Any], path: Path) -> None:
    """Write one JSON object."""
    path.write_text(json.dumps(data, indent=1, allow_nan=False) + "\n", encoding="utf-8")


def fill_page(page: Path, name: str, text: str, chart: Path) -> None:
    """Put generated text on a page and a chart into the folder ``gallery`` beside it.

    Parameters
    ----------
    page : Path
        A page with the two markers of that name.
    name : str
        What the markers are called.
    text : str
        What to put between them.
    chart : Path
        A picture.

    Raises
    ------
    InputError
        If a marker is missing; nothing is written.
    """
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    old = page.read_text(encoding="utf-8")
    before, opened, rest = old.partition(begin)
    _, closed, after = rest.partition(end)
    if not (opened and closed):
        raise InputError(f"{page} has no place for {name}: add {begin} and {end} to it")
    page.write_text(f"{before}{begin}\n{text}\n{end}{after}", encoding="utf-8")
    gallery = page.parent / "gallery"
    gallery.mkdir(exist_ok=True)
    shutil.copy(chart, gallery)
