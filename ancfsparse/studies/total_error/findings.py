"""What the study of the whole error shows, in sentences that are worked out from it."""

from __future__ import annotations

import math

from ancfsparse.studies.common import paper
from ancfsparse.studies.common.race import OURS, Point, front
from ancfsparse.studies.total_error.run import TotalError


def findings(result: TotalError) -> list[str]:
    """State what the front shows of the paper's choices, the thick element, steps and models."""
    sentences = [_about_choice(result, p) for p in result.paper_choices()]
    sentences += [about_steps(result, p) for p in result.paper_choices()]
    sentences += about_thick(result)
    low, high = result.model_spread()
    if not math.isnan(low):
        sentences.append(
            f"Models that are converged differ by {low:.0e} to {high:.0e} m: below that the choice "
            "of the model decides, not the mesh."
        )
    return sentences + _about_peers(result)


def _about_choice(result: TotalError, p: Point) -> str:
    better = [q for q in result.front() if q.error <= p.error]
    name = f"{p.task.model}, the paper's choice: {p.error:.1e} m in {1e3 * p.seconds:.1f} ms"
    if p in better:
        return f"{name}, on the front."
    cheapest = min(better, key=lambda q: q.seconds)
    return (
        f"{name}; {_say(cheapest)} is as good in {1e3 * cheapest.seconds:.2f} ms, "
        f"{p.seconds / cheapest.seconds:.0f} times faster."
    )


def _say(p: Point) -> str:
    return (
        f"{p.task.model} with {p.task.elements} elements, {p.task.method} and "
        f"dt = {p.task.value:.3g} s"
    )


def about_steps(result: TotalError, p: Point) -> str:
    """State by how much the step of a choice can grow before its error does."""
    largest = result.largest_step(p.task.model, p.task.elements)
    name = f"{p.task.model}, {p.task.elements} elements"
    if largest is None or largest.task.value <= p.task.value:
        return f"{name}: no step larger than dt = {p.task.value:g} s leaves the error as it is."
    return (
        f"{name}: the error is the mesh's, and {largest.task.method} with "
        f"dt = {largest.task.value:g} s, {largest.task.value / p.task.value:.0f} times the "
        f"paper's, leaves it at {largest.error:.1e} m."
    )


def about_thick(result: TotalError) -> list[str]:
    """State whether the thick element locks on the paper's mesh, if it and Thin were run."""
    found = {m: result.at(m, paper.ELEMENTS, paper.DT) for m in ("Thin", "Thick", "Thick, nodal")}
    thin, thick, nodal = found.values()
    if thin is None or thick is None:
        return []
    ratio = thick.error / thin.error
    if ratio < 2.0:
        return [f"Thick on {paper.ELEMENTS} elements does not lock: {thick.error:.1e} m."]
    text = (
        f"Thick on {paper.ELEMENTS} elements locks: its error is {thick.error:.1e} m, {ratio:.0f} "
        "times that of as many Thin ones"
    )
    needed = result.elements_for("Thick", thin.error)
    text += (
        f", and of the meshes that were run {needed} do what {paper.ELEMENTS} Thin ones do"
        if needed
        else ", and no number that was run does what the Thin ones do"
    )
    if nodal is not None:
        text += f"; nodal section strains bring it to {nodal.error:.1e} m"
    return [text + "."]


def _about_peers(result: TotalError) -> list[str]:
    sentences = []
    for program in dict.fromkeys(p.task.program for p in result.points):
        theirs = [p for p in result.points if p.task.program == program and p.finished]
        if program == OURS or not theirs:
            continue
        best = front(theirs)[-1]
        ours = min(
            (p for p in result.ours() if p.error <= best.error),
            key=lambda p: p.seconds,
            default=None,
        )
        first = (
            f"{program}'s most accurate run, {best.task.elements} elements, is off by "
            f"{best.error:.1e} m after {best.seconds:.2g} s"
        )
        if ours is None:
            sentences.append(f"{first}, which no run of ours reaches.")
        else:
            sentences.append(
                f"{first}; {_say(ours)} is as good in {1e3 * ours.seconds:.1f} ms, "
                f"{best.seconds / ours.seconds:.0f} times faster."
            )
    return sentences


def headline(result: TotalError) -> str:
    """State how far the paper's thin choice is from the front, and why."""
    thin = [p for p in result.paper_choices() if p.task.model == "Thin"]
    if not thin:
        return "Whole error against cost"
    (p,) = thin
    as_good = min(q.seconds for q in result.front() if q.error <= p.error)
    as_cheap = min(q.error for q in result.front() if q.seconds <= p.seconds)
    return (
        f"The paper's choice with Thin elements costs {p.seconds / as_good:.0f} times the cheapest "
        f"run as good;\nfor its time the error can be {p.error / as_cheap:.0f} times smaller"
    )
