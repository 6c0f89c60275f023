"""The run that a plan chooses, made as the last pilot where it is short.

Its distance from the pilots before must be what their estimates leave.  If it is larger, errors
decrease more slowly than was believed, and the choice is made again.  The run is then the answer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from ancfsparse.plans.discretization_error.error_model import SURE, UNSURE, Found, scaled
from ancfsparse.plans.discretization_error.mesh_error import corrected_estimates, elements_of
from ancfsparse.plans.discretization_error.richardson import Estimate
from ancfsparse.plans.models.model import spread
from ancfsparse.plans.selection.discretization_search import thorough
from ancfsparse.plans.trial_runs.trial_runs import FREE, SHARE, Pilot, Pilots, distances

# How often a choice is made again, and work of one that is run, in that of free pilots.
MOST, WORTH = 4, 2.0
# Where a choice takes so many times the work that few pilots had shown, more are made.
SURPRISE = 3.0
# Motions may differ by so many times what the estimates leave, and by this share of the error asked
# for, which decides nothing.
ALIKE, SMALL = 1.25, 0.1
# Errors are not believed to fall with less than this share of the orders that were estimated.
LEAST = 0.5


def confirmed(pilots: Pilots, found: Found) -> Found:
    """Run the choice if that is cheap, and correct it until its error is what was foreseen.

    Parameters
    ----------
    pilots : Pilots
        Runs.
    found : Found
        What they have shown.

    Returns
    -------
    Found
        With corrected estimates and the choice that was run; as it is where a run is long.
    """
    if found.chosen is not None:
        if found.missed(*found.chosen) <= 1.0:
            return found
        found = replace(found, chosen=None)  # what elements neglect leaves less to the others
    known = _sufficient(pilots, found)
    if known is not None:
        return replace(found, chosen=known)
    judge = found.judge
    found = replace(found, sure=SURE)
    for _ in range(MOST):
        chosen = found.choice()
        tried = _affordable(found, judge, chosen)
        if tried is None:
            break
        run = pilots.run(found.model.with_counts(spread(pilots.scene, tried[0])), tried[1])
        if run is None:
            break
        before = found
        found = _by_corrections(pilots, found, judge, run) or _corrected(
            found, judge, tried, distances(pilots.wanted, judge, run)
        )
        if found.missed(*tried) <= 1.0:
            return replace(found, chosen=tried)
        if found.is_short and found.work(*found.choice()) > SURPRISE * before.work(*chosen):
            longer = thorough(pilots, found.model, None, None)
            return confirmed(pilots, longer.with_effects(found.effects))
        if found is before and tried != chosen:  # as foreseen, so the choice will be too
            return found
        judge, found = run, _reaching(found, run)
        if tried == found.choice():  # nothing better is within reach
            break
    return replace(found, sure=UNSURE)


def _reaching(found: Found, run: Pilot) -> Found:
    """Return what was found with a finer run: errors are continued from it."""
    if found.mesh is None or elements_of(run) <= elements_of(found.mesh.runs[-1]):
        return found
    return replace(found, mesh=replace(found.mesh, runs=(*found.mesh.runs, run)))


def _by_corrections(pilots: Pilots, found: Found, judge: Pilot, run: Pilot) -> Found | None:
    """Return the error of the mesh of an equilibrium as it shows itself; None if it does not."""
    if pilots.t_end is not None or found.mesh is None:
        return None
    apart = elements_of(judge) != elements_of(run)
    estimates = corrected_estimates(pilots, (judge, run) if apart else (run,), found.order)
    if estimates is None:
        return None
    return replace(found, mesh=replace(found.mesh, estimates=estimates))


def _affordable(found: Found, judge: Pilot, chosen: tuple[float, int]) -> tuple[float, int] | None:
    """Return the choice, or one on the way to it that costs a small share of it; None if none."""
    work = found.work(*chosen)
    most, tried = max(WORTH * FREE, SHARE * work), chosen
    while found.work(*tried) > most:
        tried = scaled(found, *tried, 2.0)
        if found.missed(*tried) >= found.missed(finest_of(judge), judge.steps):
            return None
    return tried


def _sufficient(pilots: Pilots, found: Found) -> tuple[float, int] | None:
    """Return mesh and steps of the cheapest pilot whose error is small enough already."""
    time, mesh = found.time.runs, found.mesh.runs if found.mesh is not None else ()
    counts = {id(run.model): run for run in (*time[:1], *mesh)}.values()
    steps = {run.steps for run in time if found.fixed_steps in (None, run.steps)}
    able = [
        (found.work(finest_of(run), n), (finest_of(run), n))
        for run in counts
        for n in steps
        if (made := pilots.find(run.model, n)) is not None
        and found.missed(finest_of(run), n) <= (found.share if made is found.judge else UNSURE)
    ]
    return min(able)[1] if able else None


def finest_of(run: Pilot) -> float:
    """Return the number of elements on the longest open beam."""
    return float(max(run.model.counts.values(), default=1))


def _corrected(
    found: Found, judge: Pilot, choice: tuple[float, int], apart: Sequence[float]
) -> Found:
    """Return estimates that leave the distance that was measured."""
    times, meshes, as_foreseen = list(found.time.estimates), [], True
    if found.mesh is not None:
        meshes = list(found.mesh.estimates)
    for i, far in enumerate(apart):
        pairs = [(times[i], float(judge.steps), float(choice[1]))]
        if meshes:
            here, there = (n * found.density for n in (finest_of(judge), choice[0]))
            pairs.append((meshes[i], here, there))
        if far <= ALIKE * _left(pairs, 1.0) + SMALL * found.asked[i]:
            continue
        as_foreseen = False
        low, high = LEAST, 1.0
        while high - low > 0.01:
            share = 0.5 * (low + high)
            low, high = (low, share) if _left(pairs, share) < far else (share, high)
        left = _left(pairs, low)
        new = [each.with_order(low * each.order) for each, _, _ in pairs]
        if left > 0.0:
            new = [replace(each, error=max(1.0, far / left) * each.error) for each in new]
        else:  # no difference at all was foreseen
            new = [replace(each, error=each.error + far) for each in new]
        times[i] = new[0]
        if meshes:
            meshes[i] = new[1]
    if as_foreseen:
        return found
    mesh = None if found.mesh is None else replace(found.mesh, estimates=tuple(meshes))
    return replace(found, time=replace(found.time, estimates=tuple(times)), mesh=mesh)


def _left(pairs: Sequence[tuple[Estimate, float, float]], share: float) -> float:
    """Return by how much solutions differ if errors have a share of their order."""
    parts = ((each.with_order(share * each.order), a, b) for each, a, b in pairs)
    return sum(abs(each.at(a) - each.at(b)) for each, a, b in parts)
