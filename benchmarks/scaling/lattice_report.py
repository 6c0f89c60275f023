"""The study of lattices as text, CSV, JSON and a chart."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure

from benchmarks.common.charts import SMALL, new_figure, set_axes, set_empty, set_legend
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
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
"""Of runs with a result; of the others the second cell has the reason."""


def runs(rows: Sequence[Row]) -> Table:
    """Set a line for each run."""
    lines = []
    for row in rows:
        found = [cell(row) for cell in COLUMNS.values() if not row.note]
        cells = found or ["", row.note.partition(":")[0], *[""] * (len(COLUMNS) - 2)]
        job = row.job
        lines.append([job.title, job.side, job.factorization, f"{job.elements:,}", *cells])
    return Table(["", "size", "seeds", "elements", *COLUMNS], lines, left=(0, 2))


def chart(rows: Sequence[Row]) -> Figure:
    """Draw time and memory per element against the number of elements, by kind of scene."""
    rows = [row for row in rows if row.job.case != "statics" and row.job.threads == 1]
    kinds = {
        "nets and lattices": [
            row for row in rows if row.job.case != "octet" and not (row.job.jitter or row.job.rods)
        ],
        "irregular or on rods": [row for row in rows if row.job.jitter or row.job.rods],
        "octet trusses": [row for row in rows if row.job.case == "octet"],
    }
    kinds = {name: own for name, own in kinds.items() if own}
    figure = new_figure(1.0 + 3.4 * len(kinds), "Time and memory of complete and incomplete seeds")
    colours = dict(zip(dict.fromkeys(map(_label, rows)), COLOURS, strict=False))
    shown: dict[str, Any] = {}
    for (left, right), (name, own) in zip(
        figure.subplots(len(kinds), 2, squeeze=False), kinds.items(), strict=True
    ):
        shown |= _panels(left, right, name, own, colours)
    if shown:
        set_legend(figure, shown, 3, "solid: incomplete seeds, dashed: complete ones")
    return figure


def _panels(
    left: Axes, right: Axes, name: str, rows: Sequence[Row], colours: dict[str, str]
) -> dict[str, Any]:
    """Draw a line for each stiffness, motion and step; return those of incomplete seeds."""
    shown: dict[str, Any] = {}
    if all(row.note for row in rows):
        for ax in (left, right):
            set_empty(ax, "no run has a result")
        return shown
    for label, colour in colours.items():
        for factorization, line in (("complete", "--"), ("incomplete", "-")):
            own = [
                r
                for r in rows
                if (_label(r), r.job.factorization) == (label, factorization) and not r.note
            ]
            x = [row.job.elements for row in own]
            left.plot(x, [row.microseconds for row in own], line, color=colour, marker=".")
            y = [row.bytes_per_element / 1e3 for row in own]
            (drawn,) = right.plot(x, y, line, color=colour, marker=".")
            if factorization == "incomplete" and own:
                shown[label] = drawn
    for ax, what in ((left, "microseconds per element and step"), (right, "kB per element")):
        set_axes(ax, "elements", what, "x", name)
        ax.tick_params(labelsize=SMALL)
    left.set_yscale("log")
    right.set_ylim(bottom=0.0)
    return shown


def _label(row: Row) -> str:
    job = row.job
    return f"{'net' if job.case == 'net' else job.stiff}, {job.course}"


GIGABYTE = 1e9
# The steps of 1 ms of soft lattices that fall from rest, and of nets, to which most targets apply.
LATTICE, NET = "soft lattice, at rest, 0.001 s", "net, at rest, 0.0005 s"


def ratios(exact: Row, incomplete: Row) -> tuple[float, float, float]:
    """Return the ratios of time, set-up and memory of complete seeds to incomplete ones."""
    return (
        exact.microseconds / incomplete.microseconds,
        exact.record["set_up_seconds"] / incomplete.record["set_up_seconds"],
        exact.bytes_per_element / incomplete.bytes_per_element,
    )


def targets(rows: Sequence[Row]) -> list[Target]:
    """Return the targets that the rows can answer."""
    found = []
    for exact, incomplete in pairs(rows):
        case = exact.job.title, exact.job.size
        what = f"{exact.job.title}, {exact.job.size}: complete / incomplete"
        time, set_up, memory = ratios(exact, incomplete)
        if case == (LATTICE, 22):
            found.append(Target(f"{what}, step", time, 8.0))
            found.append(Target(f"{what}, set-up", set_up, 10.0))
            found.append(Target(f"{what}, memory", memory, 3.0))
        if case in ((NET, 200), (NET, 100)):
            found.append(Target(f"{what}, step", time, 2.5 if case[1] == 200 else 1.0))
    own = incomplete_rows(rows)
    for row in own.get(LATTICE, []):
        if row.job.size == 46:
            peak = row.record["peak_bytes"] / GIGABYTE
            found.append(
                Target("soft lattice, 46: us per element and step", row.microseconds, 2.5, True)
            )
            found.append(Target("soft lattice, 46: GB at the peak", peak, 1.5, True))
    by_size = {row.job.size: row.microseconds for row in own.get(LATTICE, [])}
    if {10, 46} <= set(by_size):
        growth = by_size[46] / by_size[10]
        found.append(Target("soft lattice: cost per element, 46 / 10", growth, 1.5, True))
    for title, of_title in own.items():
        large = [row.microseconds for row in of_title if 22 <= row.job.size <= 46]
        if title.startswith("steel lattice, at rest") and large:
            found.append(Target(f"{title}: us per element, 22 to 46", max(large), 6.0, True))
    for one, more in threaded(rows):
        name = f"{one.job.title}, {one.job.size}: gain of {more.job.threads} threads"
        found.append(Target(name, one.record["seconds"] / more.record["seconds"], 1.5))
    for row in rows:
        if row.job.case == "statics" and not row.note:
            name = f"{row.job.title}, {row.job.size}: s"
            found.append(Target(name, row.record["seconds"], 20.0, True))
    return found


def findings(rows: Sequence[Row]) -> list[str]:
    """Summarise what incomplete seeds save, how their cost grows, and from which fill they win."""
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
    return sentences + _limits(rows) + [_as_sentence(each) for each in targets(rows)]


def _limits(rows: Sequence[Row]) -> list[str]:
    """State the fill up to and from which each seed wins, by steps alone and with set-up."""
    known = [(e.record["fill"], e, i) for e, i in pairs(rows) if e.record.get("fill")]
    if not known:
        return []
    out = []
    cost: dict[str, Callable[[Row], float]] = {
        "steps": lambda row: row.microseconds,
        "set-up and steps": lambda row: (
            row.microseconds + 1e6 * row.record["set_up_seconds"] / row.job.steps / row.job.elements
        ),
    }
    for what, of in cost.items():
        slower = [fill for fill, exact, incomplete in known if of(exact) < of(incomplete)]
        faster = [fill for fill, exact, incomplete in known if of(exact) >= of(incomplete)]
        sentence = f"By {what}, "
        if slower:
            sentence += f"complete seeds win {len(slower)} times, up to a fill of {max(slower):.3g}"
        else:
            sentence += "complete seeds never win"
        if faster:
            sentence += (
                f"; incomplete ones {len(faster)} times, from a fill of {min(faster):.3g} on"
            )
            above = [fill for fill in faster if not slower or fill > max(slower)]
            if slower and above:
                sentence += f", and always from {min(above):.3g} on"
        out.append(sentence)
    return out


def _as_sentence(target: Target) -> str:
    bound = "at most" if target.at_most else "at least"
    met = "met" if target.met else "missed"
    what = target.what[0].upper() + target.what[1:]
    return f"{what}: {target.value:.3g} (target: {bound} {target.wanted:g}, {met})"


def incomplete_rows(rows: Sequence[Row]) -> dict[str, list[Row]]:
    """Return the marches with results on incomplete seeds and one thread, by title."""
    found: dict[str, list[Row]] = {}
    for row in rows:
        job = row.job
        if (
            not row.note
            and (job.factorization, job.threads) == ("incomplete", 1)
            and job.case != "statics"
        ):
            found.setdefault(job.title, []).append(row)
    return found


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
