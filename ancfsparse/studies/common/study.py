"""What a study shows of its result: text, tables, findings, targets, charts, regions of pages."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar

from matplotlib.figure import Figure

from ancfsparse.studies.common.files import check_targets, fill_page, write_csv
from ancfsparse.studies.common.target import Target

DPI = 120

Result = TypeVar("Result")


@dataclass(frozen=True)
class Study(Generic[Result]):
    """A study: how it is run, and functions of its result.

    Attributes
    ----------
    name : str
        Stem of the names of its tables.
    run : callable
        Runs it and returns the result; its arguments are its own, and ``progress``.
    text : callable
        Sets the result for a terminal.
    rows : callable
        Gives the lines of the CSV table, by column.
    record : callable, optional
        Gives one JSON object, to which findings and targets are added.
    findings : callable, optional
        Gives sentences that are worked out from the numbers.
    targets : callable, optional
        Gives numbers with what they should be.
    charts : mapping of str to callable
        Draw the result, by the stem of the name of the picture.
    regions : mapping of str to callable
        Set the result for a page, by the name of the markers there.  The picture of the same name
        goes with it, or the first one.
    gallery : str
        Folder of the pictures of a page, beside the page.
    """

    name: str
    run: Callable[..., Result]
    text: Callable[[Result], str]
    rows: Callable[[Result], Sequence[dict[str, Any]]]
    record: Callable[[Result], dict[str, Any]] | None = None
    findings: Callable[[Result], list[str]] | None = None
    targets: Callable[[Result], list[Target]] | None = None
    charts: Mapping[str, Callable[[Result], Figure]] = field(default_factory=dict)
    regions: Mapping[str, Callable[[Result], str]] = field(default_factory=dict)
    gallery: str = "gallery"

    def check(self, output: Path, page: Path | None) -> None:
        """Refuse a folder and a page that could not be written to, before the run."""
        check_targets(output, page, *self.regions)

    def as_record(self, result: Result) -> dict[str, Any]:
        """Return the JSON object with targets and findings."""
        record = {} if self.record is None else self.record(result)
        if self.targets is not None:
            record["targets"] = [each.record() for each in self.targets(result)]
        if self.findings is not None:
            record["findings"] = self.findings(result)
        return record

    def write(self, result: Result, folder: Path) -> list[Path]:
        """Write tables and charts to a folder, made if missing; return their paths."""
        folder.mkdir(parents=True, exist_ok=True)
        paths = [folder / f"{self.name}.csv"]
        write_csv(self.rows(result), paths[0])
        record = self.as_record(result)
        if record:
            paths.append(folder / f"{self.name}.json")
            text = json.dumps(record, indent=1, allow_nan=False)
            paths[-1].write_text(text + "\n", encoding="utf-8")
        for stem, draw in self.charts.items():
            paths.append(folder / f"{stem}.png")
            draw(result).savefig(paths[-1], dpi=DPI)
        return paths

    def fill(self, result: Result, page: Path, folder: Path) -> None:
        """Renew the regions of a page, and beside it the charts that were written to a folder."""
        for marker, text in self.regions.items():
            stem = marker if marker in self.charts else next(iter(self.charts))
            gallery = page.parent / self.gallery
            fill_page(page, marker, text(result), folder / f"{stem}.png", gallery)
