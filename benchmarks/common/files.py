"""What studies write: tables, charts, and regions of a page."""

from __future__ import annotations

import csv
import math
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ancfsparse.errors import InputError


def plain(value: Any) -> Any:
    """Return a result as JSON has it: objects, lists, and null for what is no finite number."""
    if is_dataclass(value):
        return {f.name: plain(getattr(value, f.name)) for f in fields(value) if f.repr}
    if isinstance(value, Mapping):
        return {k if isinstance(k, str) else ", ".join(k): plain(v) for k, v in value.items()}
    if hasattr(value, "_asdict"):
        return plain(value._asdict())
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(each) for each in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write_csv(records: Sequence[dict[str, Any]], path: Path) -> None:
    """Write one line per record; what a record lacks is left empty."""
    names = list(dict.fromkeys(key for record in records for key in record))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(records)


def check_targets(output: Path, page: Path | None, *names: str) -> None:
    """Refuse a folder and a page that could not be written to, before a study and not after it."""
    folder = next(each for each in (output, *output.parents) if each.exists())
    if not folder.is_dir():
        raise InputError(
            f"{output} cannot be a folder for tables and charts, because {folder} is a file: give "
            "--output another name"
        )
    if page is not None:
        for name in names:
            _split(page, name)


def fill_page(
    page: Path, name: str, text: str, chart: Path | None = None, gallery: Path | None = None
) -> None:
    """Put generated text between the two markers of a name on a page, and a chart into its gallery.

    The gallery, made if missing, is the folder ``gallery`` beside the page by default.

    Raises
    ------
    InputError
        If a marker is missing; nothing is written.
    """
    before, after = _split(page, name)
    page.write_text(f"{before}\n{text}\n{after}", encoding="utf-8")
    if chart is not None:
        gallery = gallery or page.parent / "gallery"
        gallery.mkdir(parents=True, exist_ok=True)
        shutil.copy(chart, gallery)


def _split(page: Path, name: str) -> tuple[str, str]:
    """Return a page up to the one marker of a name, and from the other on."""
    begin, end = f"<!-- {name}:begin -->", f"<!-- {name}:end -->"
    if not page.is_file():
        raise InputError(f"{page} cannot be renewed: there is no such page")
    before, opened, rest = page.read_text(encoding="utf-8").partition(begin)
    _, closed, after = rest.partition(end)
    if not (opened and closed):
        raise InputError(f"{page} has no place for {name}: add {begin} and {end} to it")
    return before + begin, end + after
