"""What table 1 shows, in sentences that are worked out from its numbers."""

from __future__ import annotations

import math

from ancfsparse.studies.common import paper
from ancfsparse.studies.table1.cells import Cell
from ancfsparse.studies.table1.run import Table

# What our quasi-Newton cells should be faster by than the paper's.
OVER_PAPER = 50.0

# What Davidon should be faster by than the best of the ode columns.
OVER_ODE = 10.0


def findings(table: Table) -> list[str]:
    """State what the numbers show."""
    ours = [cell for (_, column), cell in table.cells.items() if column in paper.QUASI_NEWTON]
    sentences = []
    compared = [cell for cell in ours if not math.isnan(cell.speed_up)]
    if compared:
        slowest = min(compared, key=lambda cell: cell.speed_up)
        holds = slowest.speed_up >= OVER_PAPER
        sentences.append(
            f"The quasi-Newton cells are at least {slowest.speed_up:.0f} times faster than the "
            f"paper's ({slowest.row}, {slowest.column}): "
            + _verdict(holds, f"the aim of {OVER_PAPER:.0f} times")
        )
    sentences += [
        f"{cell.row}, {cell.column}: no result, {cell.note}." for cell in ours if not cell.finished
    ]
    return sentences + [sentence for row in table.rows for sentence in _against_ode(table, row)]


def _against_ode(table: Table, row: str) -> list[str]:
    davidon = table.cells[row, "Davidon"]
    finished = [table.cells[row, c] for c in paper.ODE_FUNCTIONS if table.cells[row, c].finished]
    if not davidon.finished:
        return []
    if not finished:
        return [f"{row}: no SciPy method finished, so there is nothing to compare with."]
    best = min(finished, key=lambda cell: cell.seconds)
    ratio = best.seconds / davidon.seconds
    as_good = davidon.tip_error <= best.tip_error
    text = (
        f"{row}: Davidon at the paper's step is {ratio:.1f} times faster than the fastest SciPy "
        f"method, {best.column}, with a tip error of {davidon.tip_error:.1e} m against "
        f"{best.tip_error:.1e} m"
    )
    if as_good:
        return [f"{text}: {_verdict(ratio >= OVER_ODE, _aim())}"]
    match = table.matches[row, best.column]
    holds = match.ratio >= OVER_ODE
    if match.found:
        text += (
            f". At dt = {match.dt:.3g} s its error is {match.tip_error:.1e} m and it is "
            f"{match.ratio:.1f} times faster: {_verdict(holds, _aim())}"
        )
    else:
        parts = math.sqrt(davidon.tip_error / best.tip_error)
        text += (
            f". An error that falls with the square of the step would take {parts:.0f} times the "
            f"steps: {_verdict(False, _aim())}"
        )
    return [text if holds else f"{text} {_why(best)}"]


def _why(best: Cell) -> str:
    return (
        f"The fast waves of the mesh force {best.column} into small steps, {best.evaluations} "
        f"right-hand sides, so it ends far more accurate than its tolerance of {paper.RTOL:g} asks."
    )


def _aim() -> str:
    return f"the aim of {OVER_ODE:.0f} times at equal or better tip error"


def _verdict(holds: bool, aim: str) -> str:
    return f"{aim} is {'met' if holds else 'missed'}."
