"""What a study shows of its result: tables, findings, targets, charts, regions of pages."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar

from matplotlib.figure import Figure

from benchmarks.common.files import check_targets, fill_page, plain, write_csv
from benchmarks.common.tables import Table, bullets
from benchmarks.common.target import Target

DPI = 120

Result = TypeVar("Result")


@dataclass(frozen=True)
class Study(Generic[Result]):
    """A study: how it is run, and functions of its result.

    Attributes
    ----------
    name : str
        Stem of the names of its files.
    run : callable
        Runs it and returns the result; its arguments are its own, and ``progress``.
    tables : callable
        Gives the tables for a terminal.
    rows : callable
        Gives the lines of the CSV table, by column.
    heading : callable, optional
        Gives the lines above the tables on a terminal.
    record : callable, optional
        Gives what goes into the JSON object besides findings and targets: by default the result.
    findings : callable, optional
        Gives sentences that are worked out from the numbers.
    targets : callable, optional
        Gives numbers with what they should be.
    notes : callable, optional
        Gives the lines below all else on a terminal.
    charts : mapping of str to callable
        Draw the result, by the stem of the name of the picture.
    regions : mapping of str to callable
        Give what goes on a page, by the name of the markers there: a table, below which the
        findings are listed, or text.  The picture of the same name goes with it, or the first one.
    gallery : str
        Folder of the pictures of a page, beside the page.
    """

    name: str
    run: Callable[..., Result]
    tables: Callable[[Result], Sequence[Table]]
    rows: Callable[[Result], Sequence[dict[str, Any]]]
    heading: Callable[[Result], str] | None = None
    record: Callable[[Result], Any] = lambda result: result
    findings: Callable[[Result], list[str]] | None = None
    targets: Callable[[Result], list[Target]] | None = None
    notes: Callable[[Result], list[str]] | None = None
    charts: Mapping[str, Callable[[Result], Figure]] = field(default_factory=dict)
    regions: Mapping[str, Callable[[Result], Table | str]] = field(default_factory=dict)
    gallery: str = "gallery"

    def text(self, result: Result) -> str:
        """Set the result for a terminal."""
        parts = [] if self.heading is None else [self.heading(result)]
        parts += map(str, self.tables(result))
        for give in (self.findings, self.targets, self.notes):
            if give is not None:
                parts.append("\n".join(map(str, give(result))))
        return "\n\n".join(part for part in parts if part)

    def region(self, marker: str, result: Result) -> str:
        """Set the region of a page."""
        found = self.regions[marker](result)
        if isinstance(found, str):
            return found
        sentences = [] if self.findings is None else self.findings(result)
        return "\n".join([*found.markdown(), "", *bullets(sentences)])

    def check(self, output: Path, page: Path | None) -> None:
        """Refuse a folder and a page that could not be written to, before the run."""
        check_targets(output, page, *self.regions)

    def as_record(self, result: Result) -> dict[str, Any]:
        """Return the JSON object with targets and findings."""
        found = plain(self.record(result))
        record: dict[str, Any] = found if isinstance(found, dict) else {"rows": found}
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
        paths.append(folder / f"{self.name}.json")
        text = json.dumps(self.as_record(result), indent=1, allow_nan=False)
        paths[-1].write_text(text + "\n", encoding="utf-8")
        for stem, draw in self.charts.items():
            paths.append(folder / f"{stem}.png")
            draw(result).savefig(paths[-1], dpi=DPI)
        return paths

    def fill(self, result: Result, page: Path, folder: Path) -> None:
        """Renew the regions of a page, and beside it the charts that were written to a folder."""
        for marker in self.regions:
            stem = marker if marker in self.charts else next(iter(self.charts))
            gallery = page.parent / self.gallery
            fill_page(page, marker, self.region(marker, result), folder / f"{stem}.png", gallery)
