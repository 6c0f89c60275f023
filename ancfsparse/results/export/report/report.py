"""The report of a run: one web page with the moving scene, graphs, energies and settings."""

from __future__ import annotations

import platform
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from html import escape
from importlib.metadata import version
from pathlib import Path
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_target
from ancfsparse.messages import format_value
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.export.report.forces import add_forces
from ancfsparse.results.export.report.graphs import make_graph
from ancfsparse.results.export.report.moving_scene import MovingScene, make_moving_scene
from ancfsparse.results.export.report.web_page import make_page
from ancfsparse.results.fields.energy_balance import ENERGIES, Energy
from ancfsparse.results.fields.motion import Motion
from ancfsparse.results.geometry.deformed_shape import read_rows, spread_rows
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.results.geometry.tubes import count_pieces
from ancfsparse.results.plotting.plot import draw_energies, plot_motion
from ancfsparse.scene import Beam, Point, check_point
from ancfsparse.system.coordinates.state import StateHistory

MAX_FRAMES = 501  # of states that are often saved: the first, and 500 steps
MAX_NUMBERS = 6_000_000  # coordinates and quantities of all frames: 5 MB for smooth motions
MAX_TIMES = 2000  # of a graph
N_POINTS = 4  # with graphs over time by default
N_LINES = 4  # beams with graphs along them by default
MAX_EVENTS = 30  # in the table
LABELS = {"march_seconds": "time of the loop [s]", "error": "estimated error"}
"""Names of statistics that differ from those of their attributes."""
OMITTED = "\u2026"


class ReportedRun(Motion, Protocol):
    """The interface of a run for a report; see `Trajectory`."""

    @property
    def lam(self) -> Vector:
        """Multipliers of the constraints, (k, m)."""
        ...

    @property
    def stats(self) -> RunStats:
        """Operation counts and times."""
        ...

    @property
    def settings(self) -> Mapping[str, Any]:
        """Arguments of the run."""
        ...


def write_report(
    run: ReportedRun,
    path: str | Path,
    points: Sequence[Point] | None = None,
    lines: Sequence[Beam] | None = None,
) -> Path:
    """Write a report; see `Trajectory.report`."""
    target = check_target("a report", path, (".html",))
    points, lines = _check_points(run, points), _check_lines(run, lines)
    scene = make_film(run, MAX_FRAMES, MAX_NUMBERS)
    page = make_page(
        scene, escape(target.stem), _header(run, target.stem), _body(run, points, lines, scene)
    )
    try:
        target.write_text(page, encoding="utf-8", newline="\n")
    except OSError as error:
        raise InputError(f"the report cannot be written to {target}: {error.strerror}") from error
    return target


def make_film(run: ReportedRun, max_frames: int, max_numbers: int) -> MovingScene:
    """Return the moving scene of a run, at times as equal in distance as saved states allow."""
    outline = make_outline(run.system)
    elements = sum(len(part.lengths) for part in outline.parts)
    numbers = 3 * elements * (1 + count_pieces(outline.parts)) + 12 * len(outline.solids)
    frames = int(np.clip(max_numbers // max(numbers, 1), 2, max_frames))
    some = select_rows(run, spread_rows(run.t, frames))
    page = make_moving_scene(run.system, outline, some._states)
    add_forces(page, some)
    return page


def select_rows(run: ReportedRun, rows: NDArray[np.intp]) -> Any:
    """Return a run of the same class with some of its states in memory."""
    trajectory: Any = run
    names = StateHistory._fields
    return replace(trajectory, **{name: read_rows(getattr(run, name), rows) for name in names})


def _check_points(run: ReportedRun, points: Sequence[Point] | None) -> list[Point]:
    """Return the points of graphs, by default those of some bodies."""
    if points is None:
        bodies = run.system.scene.bodies
        return [body.default_point for body in bodies if body.default_point][:N_POINTS]
    if not isinstance(points, (list, tuple)):
        raise InputError(f"points must be a list such as [rod.end], got {format_value(points)}")
    return [check_point("a report", point) for point in points]


def _check_lines(run: ReportedRun, lines: Sequence[Beam] | None) -> list[Beam]:
    """Return the beams of graphs, by default the first of those that have elements."""
    if lines is None:
        beams = (body for body in run.system.scene.bodies if isinstance(body, Beam))
        return [beam for beam in beams if beam.n_elements][:N_LINES]
    if not isinstance(lines, (list, tuple)) or not all(isinstance(x, Beam) for x in lines):
        raise InputError(f"lines must be a list of beams such as [rod], got {format_value(lines)}")
    return list(lines)


def _header(run: ReportedRun, name: str) -> str:
    first, _, rest = repr(run).partition("\n")
    second = f"<p class='soft'>{escape(rest.strip())}</p>" if rest else ""
    return f"<h1>{escape(name)}</h1>\n<p>{escape(first)}</p>{second}"


def _body(run: ReportedRun, points: list[Point], lines: list[Beam], scene: MovingScene) -> str:
    """Return all sections below the scene."""
    frames = len(scene.contents["t"])
    about = (
        f"The scene shows {frames} of {len(run.t)} saved states; sections are circles of equal "
        "area in true size, at least two pixels wide."
        + " Arrows are loads at points, and forces of joints on bodies, in proportion."
        * bool(scene.contents["arrows"])
    )
    sections = {
        "Histories": "".join(_histories(run, points)),
        "Ranges along the lines": "".join(_ranges(run, lines)),
        "Energy": _energies(run),
        "Solver": _solver(run.stats),
        "Settings and versions": _settings(run),
    }
    text = "\n".join(f"<h2>{name}</h2>\n{html}" for name, html in sections.items() if html)
    return f"<p class='soft'>{about}</p>\n{text}"


def _histories(run: ReportedRun, points: list[Point]) -> Iterator[str]:
    """Yield graphs of the position of points and the axial force there over time."""
    if not points or len(run.t) < 2:
        return
    some = select_rows(run, spread_rows(run.t, MAX_TIMES))
    ends = float(run.t[0]), float(run.t[-1])
    yield "<div class='graphs'>"
    for point in points:
        for what in ("position", "N") if point.beam.n_elements else ("position",):
            yield make_graph(partial(plot_motion, some, what, point), ends)
    yield "</div>"


def _ranges(run: ReportedRun, lines: list[Beam]) -> Iterator[str]:
    """Yield graphs of the minimum, mean and maximum axial force and bending moment of beams."""
    yield "<div class='graphs'>" if lines else ""
    for line in lines:
        for what in ("N", "M")[: 1 + (len(line.kind.axis) > 1)]:
            yield make_graph(partial(plot_motion, run, what, line, times="range"))
    yield "</div>" if lines else ""


def _energies(run: ReportedRun) -> str:
    """Return the energy book: energies at both ends, a graph, and the error of the balance."""
    energy = run.energy
    rows = [
        (name.replace("_", " "), f"{values[0]:.6g}", f"{values[-1]:.6g}")
        for name in ENERGIES
        if (values := getattr(energy, name)).any()
    ]
    table = _table(rows, ("[J]", "at the start", "at the end"))
    drift = ""
    if energy.kinetic.any():  # not between equilibria
        text = f"Largest error of the balance, over the largest kinetic energy: {energy.drift:.3g}"
        drift = f"<p class='soft'>{text}</p>"
    if len(run.t) < 2:
        return table + drift
    chosen = spread_rows(run.t, MAX_TIMES)
    some = Energy(*(getattr(energy, name)[chosen] for name in ENERGIES if name != "total"))
    ends = float(run.t[0]), float(run.t[-1])
    graph = make_graph(partial(draw_energies, run.t[chosen], some), ends)
    return f"<div class='columns'>{graph}<div>{table}{drift}</div></div>"


def _solver(stats: RunStats) -> str:
    """Return the selection of the solver with its reasons, counts, times and events."""
    method, _, reasons = stats.solver.partition(":")
    chosen = f"<p>{escape(method) or 'not stated'}{': ' if reasons else ''}{escape(reasons)}</p>"
    counts = [
        (LABELS.get(name, name.replace("_", " ")), f"{value:.6g}")
        for name, value in vars(stats).items()
        if isinstance(value, (int, float)) and value == value and value != 0
    ]
    times = [(f"time for {name} [s]", f"{x:.3g}") for name, x in stats.seconds.items()]
    half = (len(counts) + len(times) + 1) // 2
    both = [*counts, *times]
    columns = f"<div class='columns'>{_table(both[:half])}{_table(both[half:])}</div>"
    if not stats.events:
        return f"{chosen}{columns}<p class='soft'>No step needed the recovery sequence.</p>"
    rows = [
        (str(e.step), f"{e.time:.6g}", e.cause, e.rung, f"{e.contraction:.3g}")
        for e in stats.events[:MAX_EVENTS]
    ]
    if len(stats.events) > MAX_EVENTS:
        rows.append((OMITTED, f"{len(stats.events) - MAX_EVENTS} more", "", "", ""))
    heads = "step", "time [s]", "cause", "next attempt", "contraction"
    return f"{chosen}{columns}<h2>Events</h2>{_table(rows, heads)}"


def _settings(run: ReportedRun) -> str:
    """Return settings, versions, and the description of the scene."""
    versions = {name: version(name) for name in ("ancfsparse", "numpy", "scipy", "matplotlib")}
    versions["Python"] = platform.python_version()
    versions["system"] = f"{sys.platform}, {platform.machine()}"
    versions["three.js"] = "r180"
    tables = _table(_texts(run.settings)), _table(_texts(versions))
    scene = f"<details><summary>Scene</summary><pre>{escape(str(run.system.scene))}</pre></details>"
    return f"<div class='columns'>{tables[0]}{tables[1]}</div>{scene}"


def _texts(values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return names and values that are not empty."""
    return [(name, str(value)) for name, value in values.items() if value not in (None, "")]


def _table(rows: Iterable[tuple[str, ...]], heads: tuple[str, ...] = ()) -> str:
    """Return a table whose first column names the rows; other cells with numbers are aligned."""
    lines = []
    for first, *others in [heads, *rows] if heads else rows:
        cells = "".join(f"<td class='number'>{escape(text)}</td>" for text in others)
        lines.append(f"<tr><th>{escape(first)}</th>{cells}</tr>")
    return f"<table>{''.join(lines)}</table>"
