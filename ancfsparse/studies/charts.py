"""What the charts of the studies have in common: failures in the margin, files, pages."""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.transforms import blended_transform_factory

from ancfsparse.errors import InputError
from ancfsparse.studies.race import OURS, Point

DPI = 120

# A page shows a picture 800 pixels wide: what is drawn at this width [in] keeps its letters, of
# 8 points and more, at ten pixels and more.
WIDTH = 9.0
SMALL = 8.0


def failures(points: Sequence[Point]) -> list[str]:
    """Sum up runs without result: one line per method, model, value and kind of reason."""
    groups = _grouped(points)
    return [_say(*key, solvers) for key, solvers in groups.items()]


Key = tuple[str, str, str, float, str]


def _grouped(points: Sequence[Point]) -> dict[Key, list[Point]]:
    groups: dict[Key, list[Point]] = {}
    for p in points:
        if not p.finished:
            t = p.task
            head = t.method if t.program == OURS else f"{t.program}, {t.method}"
            kind = p.note.partition(" at ")[0]
            key = (head, t.model, t.knob, t.value, kind)
            groups.setdefault(key, []).append(p)
    return groups


def _say(head: str, model: str, knob: str, value: float, kind: str, points: list[Point]) -> str:
    solvers = dict.fromkeys(p.task.solver for p in points if p.task.solver)
    named = f" ({', '.join(solvers)})" if solvers else ""
    meshes = dict.fromkeys(str(p.task.elements) for p in points)
    reason = points[0].note if len({p.note for p in points}) == 1 else kind
    return f"{head}{named}, {', '.join(meshes)} {model}, {knob} = {value:.3g}: {reason}"


def mark_failures(
    ax: Axes, points: Sequence[Point], colour: Callable[[Point], str], notes: list[str]
) -> None:
    """Put a numbered hollow marker at the top edge for each failure, and its reason into notes.

    Parameters
    ----------
    ax : Axes
        Where curves are drawn already.
    points : sequence of Point
        Of this panel, failures among them.
    colour : callable
        Colour of a point's curve.
    notes : list of str
        Lines of all panels so far; the new ones are appended.
    """
    groups = _grouped(points)
    place = blended_transform_factory(ax.transAxes, ax.transAxes)
    for column, (key, members) in enumerate(groups.items()):
        x = 0.98 - 0.045 * column
        notes.append(f"{len(notes) + 1}: {_say(*key, members)}")
        ax.plot(
            x, 0.965, "o", transform=place, markerfacecolor="none", markersize=8,
            markeredgecolor=colour(members[0]), clip_on=False,
        )  # fmt: skip
        ax.annotate(
            str(len(notes)), (x, 0.915), xycoords=place, ha="center", va="center", fontsize=7
        )
    if groups:
        low, high = ax.get_ylim()
        ax.set_ylim(low, high * (high / low) ** 0.12)  # room for them above the curves


def write_notes(figure: Figure, notes: Sequence[str], columns: int = 2) -> None:
    """Set the reasons of the hollow markers below the panels."""
    if not notes:
        return
    rows = -(-len(notes) // columns)
    width = max(len(each) for each in notes[:rows])
    block = ["   ".join(f"{each:<{width}}" for each in notes[row::rows]) for row in range(rows)]
    figure.supxlabel(
        "hollow markers, runs without result\n" + "\n".join(line.rstrip() for line in block),
        fontsize=7, x=0.01, ha="left", family="monospace",
    )  # fmt: skip


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
