"""Files of studies: CSV tables, charts, and regions of a page."""

from __future__ import annotations

import csv
import math
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import asdict, fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ancfsparse.errors import InputError


def plain(value: Any) -> Any:
    """Return a result in the types of JSON; numbers that are not finite become null."""
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


def write_csv(rows: Sequence[Any], path: Path) -> None:
    """Write one line per record; missing entries are left empty."""
    records = [asdict(row) if is_dataclass(row) else row for row in rows]  # type: ignore[arg-type]
    names = list(dict.fromkeys(key for record in records for key in record))
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, names)
        writer.writeheader()
        writer.writerows(records)


def check_output(output: Path) -> None:
    """Check that a folder exists or can be made.

    Raises
    ------
    InputError
        If a file has its place.
    """
    folder = next(path for path in (output, *output.parents) if path.exists())
    if not folder.is_dir():
        raise InputError(
            f"{output} cannot be a folder for tables and charts, because {folder} is a file: give "
            "--output another name"
        )


def find_regions(page: Path, names: Sequence[str]) -> list[str]:
    """Return the names of the regions on a page.

    Raises
    ------
    InputError
        If there is no such page, or it has none of the regions.
    """
    if not page.is_file():
        raise InputError(f"{page} cannot be renewed: there is no such page")
    text = page.read_text(encoding="utf-8")
    entries = [name for name in names if _begin(name) in text and _end(name) in text]
    if not entries:
        places = " or ".join(names)
        example = f"add {_begin(names[0])} and {_end(names[0])} to it" if names else "leave it out"
        raise InputError(f"{page} has no place for {places}: {example}")
    return entries


def fill_page(page: Path, name: str, text: str, chart: Path | None = None) -> None:
    """Put generated text into the region of a page, and a chart into its gallery.

    The gallery, made if missing, is the folder ``gallery`` next to the page, that of the README in
    ``docs``.

    Raises
    ------
    InputError
        If the region is missing; nothing is written.
    """
    find_regions(page, [name])
    before, _, rest = page.read_text(encoding="utf-8").partition(_begin(name))
    after = rest.partition(_end(name))[2]
    region = f"{_begin(name)}\n{text}\n{_end(name)}"
    page.write_text(before + region + after, encoding="utf-8")
    if chart is not None:
        gallery = page.parent / ("docs/gallery" if page.name == "README.md" else "gallery")
        gallery.mkdir(parents=True, exist_ok=True)
        shutil.copy(chart, gallery)


def _begin(name: str) -> str:
    return f"<!-- {name}:begin -->"


def _end(name: str) -> str:
    return f"<!-- {name}:end -->"
