"""A study: its run, and tables, findings, targets, charts and regions of pages from its result."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Generic, TypeVar

from matplotlib.figure import Figure

from benchmarks.common.files import check_output, fill_page, find_regions, plain, write_csv
from benchmarks.common.tables import Table, bullets
from benchmarks.common.target import Target

DPI = 120  # pixels per inch of charts

Result = TypeVar("Result")


@dataclass(frozen=True)
class Study(Generic[Result]):
    """A run and functions of its result.

    The run takes ``progress`` and the options of its command, which are annotated by Typer; its
    docstring is the help.  A region of a page is a table, with the findings below it, or text; the
    chart of the same name goes with it, or the first chart.
    """

    name: str  # stem of the names of its files
    run: Callable[..., Result]
    tables: Callable[[Result], Sequence[Table]]  # for a terminal
    rows: Callable[[Result], Sequence[Any]]  # of the CSV table: records or dictionaries
    heading: Callable[[Result], str] | None = None  # above the tables on a terminal
    record: Callable[[Result], Any] = lambda result: result  # of the JSON object
    findings: Callable[[Result], list[str]] | None = None  # sentences
    targets: Callable[[Result], list[Target]] | None = None
    notes: Callable[[Result], list[str]] | None = None  # below all else on a terminal
    charts: Mapping[str, Callable[[Result], Figure]] = field(default_factory=dict)
    regions: Mapping[str, Callable[[Result], Table | str]] = field(default_factory=dict)

    def text(self, result: Result) -> str:
        """Set the result for a terminal."""
        parts = [] if self.heading is None else [self.heading(result)]
        parts += map(str, self.tables(result))
        for give in (self.findings, self.targets, self.notes):
            if give is not None:
                parts.append("\n".join(map(str, give(result))))
        return "\n\n".join(part for part in parts if part)

    def region(self, marker: str, result: Result) -> str:
        """Set a region of a page."""
        content = self.regions[marker](result)
        if isinstance(content, str):
            return content
        sentences = [] if self.findings is None else self.findings(result)
        return "\n".join([*content.markdown(), "", *bullets(sentences)])

    def check(self, output: Path, pages: Sequence[Path]) -> None:
        """Check the folder and the pages to be written, before the run."""
        check_output(output)
        for page in pages:
            find_regions(page, list(self.regions))

    def as_record(self, result: Result) -> dict[str, Any]:
        """Return the JSON object with targets and findings."""
        content = plain(self.record(result))
        record: dict[str, Any] = content if isinstance(content, dict) else {"rows": content}
        if self.targets is not None:
            record["targets"] = [target.record() for target in self.targets(result)]
        if self.findings is not None:
            record["findings"] = self.findings(result)
        return record

    def write(self, result: Result, folder: Path) -> list[Path]:
        """Write tables and charts to a folder, made if missing; return their paths."""
        folder.mkdir(parents=True, exist_ok=True)
        paths = [folder / f"{self.name}.csv", folder / f"{self.name}.json"]
        write_csv(self.rows(result), paths[0])
        text = json.dumps(self.as_record(result), indent=1, allow_nan=False)
        paths[1].write_text(text + "\n", encoding="utf-8")
        for stem, draw in self.charts.items():
            paths.append(folder / f"{stem}.png")
            draw(result).savefig(paths[-1], dpi=DPI)
        return paths

    def fill(self, result: Result, page: Path, folder: Path) -> None:
        """Renew the regions on a page, and in its gallery their charts from a folder."""
        for marker in find_regions(page, list(self.regions)):
            stem = marker if marker in self.charts else next(iter(self.charts), None)
            chart = None if stem is None else folder / f"{stem}.png"
            fill_page(page, marker, self.region(marker, result), chart)
