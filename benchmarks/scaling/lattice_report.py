"""Table, chart, targets and findings of the study of lattices."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.common.charts import (
    LETTER_SIZE,
    draw_lines,
    new_figure,
    panels,
    set_axes,
    set_empty,
    set_legend,
)
from benchmarks.common.study import Study
from benchmarks.common.tables import Table, group_by
from benchmarks.common.target import Target
from benchmarks.scaling.lattices import Row, lattices, pairs, threaded

COLOURS = ("#0072b2", "#e69f00", "#009e73", "#cc79a7", "#56b4e9", "#d55e00", "#000000")
COLUMNS: dict[str, Callable[[Row], str]] = {
    "fill": lambda row: f"{row.record['fill']:.3g}" if "fill" in row.record else "",
    "us per element and step": lambda row: f"{row.microseconds:.3g}",
    "set-up s": lambda row: f"{row.record['set_up_seconds']:.2g}",
    "kB per element": lambda row: f"{row.bytes_per_element / 1e3:.2g}",
    "corrections": lambda row: f"{row.record['corrections']:.2f}",
    "sweeps and products": lambda row: f"{row.inner:.1f}" if row.inner else "",
    "factorisations": lambda row: f"{row.record['factorizations']} in {row.job.steps} steps",
}
"""Columns of runs with a result; without, the second cell has the reason."""


def runs(rows: Sequence[Row]) -> Table:
    """Set a line for each run."""
    lines = []
    for row in rows:
        entries = [cell(row) for cell in COLUMNS.values() if not row.note]
        cells = entries or ["", row.note.partition(":")[0], *[""] * (len(COLUMNS) - 2)]
        job = row.job
        lines.append([job.title, job.side, job.factorization, f"{job.elements:,}", *cells])
    return Table(["", "size", "seeds", "elements", *COLUMNS], lines, left=(0, 2))


def chart(rows: Sequence[Row]) -> Figure:
    """Draw time and memory per element against the number of elements, by kind of scene."""
    rows = [row for row in rows if row.job.case != "statics" and row.job.threads == 1]
    kinds = group_by(rows, _kind)
    figure = new_figure(1.0 + 3.4 * len(kinds), "Time and memory of complete and incomplete seeds")
    colours = dict(zip(dict.fromkeys(map(_label, rows)), COLOURS, strict=False))
    axes = panels(figure, 2 * len(kinds), 2)
    keys: dict[str, Any] = {}
    for left, right, name in zip(
        axes[::2], axes[1::2], sorted(kinds, key=KINDS.index), strict=True
    ):
        keys |= _draw(left, right, name, kinds[name], colours)
    if keys:
        set_legend(figure, keys, 3, "solid: incomplete seeds, dashed: complete ones")
    return figure


def _draw(
    left: Axes, right: Axes, name: str, rows: Sequence[Row], colours: dict[str, str]
) -> dict[str, Any]:
    """Draw a line for each stiffness, motion, step and seed; return those of incomplete seeds."""
    done = [row for row in rows if not row.note]
    if not done:
        for ax in (left, right):
            set_empty(ax, "no run has a result")
        return {}

    def style_of(key: tuple[str, str]) -> dict[str, Any]:
        label, factorization = key
        if factorization == "complete":
            return {"color": colours[label], "linestyle": "--"}
        return {"color": colours[label], "label": label}

    for ax, what, value in (
        (left, "microseconds per element and step", lambda row: row.microseconds),
        (right, "kB per element", lambda row: row.bytes_per_element / 1e3),
    ):
        keys = draw_lines(
            ax, done, lambda row: (_label(row), row.job.factorization),
            lambda row: row.job.elements, value, style_of,
        )  # fmt: skip
        set_axes(ax, "elements", what, "x", name)
        ax.tick_params(labelsize=LETTER_SIZE)
    left.set_yscale("log")
    right.set_ylim(bottom=0.0)
    return keys


KINDS = ("nets and lattices", "irregular or on rods", "octet trusses")
"""Kinds of scenes, from the top down."""


def _kind(row: Row) -> str:
    if row.job.jitter or row.job.rods:
        return KINDS[1]
    return KINDS[2] if row.job.case == "octet" else KINDS[0]


def _label(row: Row) -> str:
    job = row.job
    return f"{'net' if job.case == 'net' else job.stiff}, {job.course}"


GIGABYTE = 1e9  # [bytes]
LATTICE, NET = "soft lattice, at rest, 0.001 s", "net, at rest, 0.0005 s"
MIN_RATIOS = {
    (LATTICE, 22): {"step": 8.0, "set-up": 10.0, "memory": 3.0},
    (NET, 200): {"step": 2.5},
    (NET, 100): {"step": 1.0},
}
"""Ratios of complete to incomplete seeds, by scene and size."""
MAX_SOFT_COST = 2.5  # of a step of the soft lattice [microseconds per element]
MAX_STEEL_COST = 6.0  # of a step of steel lattices [microseconds per element]
MAX_PEAK = 1.5  # memory of the soft lattice [GB]
MAX_GROWTH = 1.5  # cost per element of the largest lattice over that of a small one
MIN_GAIN = 1.5  # of several threads
MAX_STATIC_TIME = 20.0  # of an equilibrium [s]


def ratios(exact: Row, incomplete: Row) -> tuple[float, float, float]:
    """Return the ratios of time, set-up and memory of complete seeds to incomplete ones."""
    return (
        exact.microseconds / incomplete.microseconds,
        exact.record["set_up_seconds"] / incomplete.record["set_up_seconds"],
        exact.bytes_per_element / incomplete.bytes_per_element,
    )


def targets(rows: Sequence[Row]) -> list[Target]:
    """Return the targets that the rows can answer."""
    entries = []
    for exact, incomplete in pairs(rows):
        case = exact.job.title, exact.job.size
        what = f"{exact.job.title}, {exact.job.size}: complete / incomplete"
        values = dict(zip(("step", "set-up", "memory"), ratios(exact, incomplete), strict=True))
        entries += [
            Target(f"{what}, {k}", values[k], v) for k, v in MIN_RATIOS.get(case, {}).items()
        ]
    own = incomplete_rows(rows)
    costs = {row.job.size: row.microseconds for row in own.get(LATTICE, [])}
    for row in own.get(LATTICE, []):
        if row.job.size == 46:
            peak = row.record["peak_bytes"] / GIGABYTE
            what = "soft lattice, 46: us per element and step"
            entries.append(Target(what, row.microseconds, MAX_SOFT_COST, True))
            entries.append(Target("soft lattice, 46: GB at the peak", peak, MAX_PEAK, True))
    if {10, 46} <= set(costs):
        growth = costs[46] / costs[10]
        what = "soft lattice: cost per element, 46 / 10"
        entries.append(Target(what, growth, MAX_GROWTH, True))
    for title, of_title in own.items():
        large = [row.microseconds for row in of_title if 22 <= row.job.size <= 46]
        if title.startswith("steel lattice, at rest") and large:
            what = f"{title}: us per element, 22 to 46"
            entries.append(Target(what, max(large), MAX_STEEL_COST, True))
    for one, more in threaded(rows):
        what = f"{one.job.title}, {one.job.size}: gain of {more.job.threads} threads"
        entries.append(Target(what, one.record["seconds"] / more.record["seconds"], MIN_GAIN))
    return entries + [
        Target(f"{row.job.title}, {row.job.size}: s", row.record["seconds"], MAX_STATIC_TIME, True)
        for row in rows
        if row.job.case == "statics" and not row.note
    ]


def findings(rows: Sequence[Row]) -> list[str]:
    """State savings and cost of incomplete seeds, and the fill from which they win."""
    sentences = []
    for exact, incomplete in pairs(rows):
        time, set_up, memory = ratios(exact, incomplete)
        sentences.append(
            f"{exact.job.title.capitalize()}, {exact.job.side}: the complete seed takes {time:.2g} "
            f"times the time per step, {set_up:.2g} times the set-up, {memory:.2g} times the memory"
        )
    for title, own in incomplete_rows(rows).items():
        large = [row for row in own if row.job.elements >= 2000] or own
        if len(large) > 1:
            growth = large[-1].microseconds / large[0].microseconds
            sentences.append(
                f"{title.capitalize()}: on incomplete seeds a step of {large[-1].job.elements:,} "
                f"elements costs {growth:.2f} times as much per element as of "
                f"{large[0].job.elements:,}"
            )
    return sentences + _limits(rows) + [target.sentence() for target in targets(rows)]


def _limits(rows: Sequence[Row]) -> list[str]:
    """State the fill up to and from which each seed wins, by steps alone and with set-up."""
    known = [(e.record["fill"], e, i) for e, i in pairs(rows) if e.record.get("fill")]
    if not known:
        return []
    costs: dict[str, Callable[[Row], float]] = {
        "steps": lambda row: row.microseconds,
        "set-up and steps": lambda row: (
            row.microseconds + 1e6 * row.record["set_up_seconds"] / row.job.steps / row.job.elements
        ),
    }
    return [_limit(what, known, cost) for what, cost in costs.items()]


def _limit(what: str, known: Sequence[tuple[float, Row, Row]], cost: Callable[[Row], float]) -> str:
    slower = [fill for fill, exact, incomplete in known if cost(exact) < cost(incomplete)]
    faster = [fill for fill, exact, incomplete in known if cost(exact) >= cost(incomplete)]
    above = [fill for fill in faster if fill > max(slower, default=0.0)]
    parts = ["complete seeds never win"]
    if slower:
        parts = [f"complete seeds win {len(slower)} times, up to a fill of {max(slower):.3g}"]
    if faster:
        more = f", and always from {min(above):.3g} on" if slower and above else ""
        times = f"incomplete ones {len(faster)} times, from a fill of {min(faster):.3g} on"
        parts.append(times + more)
    return f"By {what}, {'; '.join(parts)}"


def incomplete_rows(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Return the runs with results on incomplete seeds and one thread, by title."""
    own = [
        row for row in rows
        if not row.note
        and (row.job.factorization, row.job.threads) == ("incomplete", 1)
        and row.job.case != "statics"
    ]  # fmt: skip
    return group_by(own, lambda row: str(row.job.title))


STUDY = Study(
    "lattices",
    run=lattices,
    tables=lambda rows: [runs(rows)],
    rows=lambda rows: [row.flat() for row in rows],
    findings=findings,
    targets=targets,
    charts={"lattices": chart},
    regions={"lattices": runs},
)
