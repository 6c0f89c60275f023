"""Runs of several programs on the pendulum with their references."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from benchmarks.accuracy.references import Reference
from benchmarks.accuracy.timed_runs import Point
from benchmarks.common.tables import group_by
from benchmarks.common.timing import OURS


@dataclass(frozen=True)
class Comparison:
    """Runs of several programs."""

    points: list[Point]  # one for each run, failures included
    references: dict[str, Reference]  # by model
    missing: list[str]  # what could not be compared with, and how to get it
    settings: dict[str, Any]  # of the study and the machine

    def of(self, model: str | None = None, program: str | None = None) -> list[Point]:
        """Return the points of a model and of a program, if they are named."""
        return [
            p for p in self.points
            if model in (None, p.task.model) and program in (None, p.task.program)
        ]  # fmt: skip

    def heading(self, what: str, known: str) -> str:
        """State the quantity, its measurement, and the uncertainty of the references."""
        given = self.settings
        models = [f"{name} to {each.uncertainty:.1e} m" for name, each in self.references.items()]
        return (
            f"{what}, {given['t_end_s']:g} s, {given['instruction_set']}; {given['seconds']}\n"
            f"error: {given['error']}\n{known}: {', '.join(models)}"
        )

    def notes(self) -> list[str]:
        """List runs without result, and programs that did not run."""
        return [*(f"Without result: {each}" for each in failures(self.points)), *self.missing]


def failures(points: Sequence[Point]) -> list[str]:
    """Sum up runs without result: one line per method, model, value and kind of reason."""
    return [failure(*key, found) for key, found in grouped_failures(points).items()]


Key = tuple[str, str, str, float, str]


def grouped_failures(points: Sequence[Point]) -> dict[Key, list[Point]]:
    """Group runs without result by method, model, value and kind of reason."""

    def key(p: Point) -> Key:
        t = p.task
        head = t.method if t.program == OURS else f"{t.program}, {t.method}"
        return head, t.model, t.knob, t.value, p.note.partition(" at ")[0]

    return group_by((p for p in points if not p.finished), key)


def failure(head: str, model: str, knob: str, value: float, kind: str, points: list[Point]) -> str:
    """Describe one of these groups."""
    solvers = dict.fromkeys(p.task.solver for p in points if p.task.solver)
    named = f" ({', '.join(solvers)})" if solvers else ""
    meshes = dict.fromkeys(str(p.task.elements) for p in points)
    reason = points[0].note if len({p.note for p in points}) == 1 else kind
    return f"{head}{named}, {', '.join(meshes)} {model}, {knob} = {value:.3g}: {reason}"
