"""The choice of elements: up the ladder as far as a quantity needs, and down where less will do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

from ancfsparse.errors import InputError, LoadError, PlanError, StepError
from ancfsparse.plans.discretization_error.error_model import Found
from ancfsparse.plans.models.model import Rung
from ancfsparse.plans.selection.discretization_search import search
from ancfsparse.plans.selection.element_hierarchy import (
    CABLE,
    NEGLIGIBLE,
    STRING,
    bending_of,
    candidates,
    effects_of,
    floors,
    is_enough,
    left_out,
    model_of,
    needed,
    of_way,
    open_beams,
    within_reach,
)
from ancfsparse.plans.selection.element_per_beam import limp, refusing, staying
from ancfsparse.plans.trial_runs.trial_runs import FREE, Pilots
from ancfsparse.scene import Scene

# The bending of coarse cables may be so many times that of fine strings.
ROUGH = 10.0


def climb(
    pilots: Pilots,
    finer: Scene | None,
    fixed_steps: int | None,
    fixed: Mapping[str, Rung] | None = None,
) -> tuple[Found, list[str]]:
    """Choose the elements of all beams whose own is open, and run their pilots.

    All get the cheapest that is enough for most, and single ones another where they refuse it, need
    a richer one, or can do with strings.

    Parameters
    ----------
    pilots, finer, fixed_steps
        As in `search`.
    fixed : mapping of str to Rung, optional
        Elements of beams that were chosen before.

    Returns
    -------
    Found
        What pilots of the chosen element have shown, with what it neglects.
    list of str
        Why, in sentences.

    Raises
    ------
    InputError
        If no element takes the scene.
    """
    fixed, richer = dict(fixed or {}), [CABLE]
    refused: dict[str, str] = {}
    if refusing(pilots.scene, CABLE, CABLE, fixed, pilots.built, pilots.first[0]):
        fixed, richer, refused = _without_cables(pilots, fixed)
    # What a thick beam neglects is not estimated, so without cables the richest is taken.
    first = CABLE if CABLE in richer else richer[-1]
    found = search(pilots, model_of(pilots.scene, first, fixed), finer, fixed_steps)
    effects = effects_of(pilots, found.judge, found.rough)
    reached = within_reach(effects, found.asked)
    if richer == [CABLE] and not is_enough(CABLE, effects, reached):
        rungs, refused = candidates(pilots.scene, fixed, pilots.built, pilots.first[0])
        richer = [rung for rung in rungs if rung != STRING]
    rung = needed(richer, first, effects, reached)
    why = _sentences(first, rung, effects, found.asked, pilots)
    why += [f"{name} is not possible: {reason}" for name, reason in refused.items()]
    names = [name for name in open_beams(pilots.scene) if name not in fixed]
    left = [left_out(each, rung) for each in effects]
    if rung != first:
        stay, kept = staying(found.judge, names, effects, first, reached)
        fixed |= {name: rung for name in names if name not in stay}
        found = search(pilots, model_of(pilots.scene, first, fixed), finer, fixed_steps, found)
        if stay:
            why.append(f"{' and '.join(stay)} may stay {first}")
            names, left = stay, kept
    if first == CABLE:
        string = _string(pilots, found, finer, fixed_steps, fixed)
        if string is not None and _price(string) < _price(found):
            of = [name for name, each in string.model.rungs.items() if each == STRING]
            some = "" if len(of) == len(string.model.rungs) else f" for {' and '.join(of)}"
            return string, [f"bending adds less than the error, so strings are enough{some}", *(
                why if some else why[1:])]  # fmt: skip
        if string is not None and _price(string)[0] <= 1.0:
            share = _price(string)[1] / _price(found)[1]
            why.append(f"strings would do too, but take {share:.2g} times the work: more elements")
    both = zip(left, effects, strict=True)
    found = replace(found, floors=floors(effects))
    return found.with_effects([own | of_way(each) for own, each in both]), why


def _without_cables(
    pilots: Pilots, fixed: dict[str, Rung]
) -> tuple[dict[str, Rung], list[Rung], dict[str, str]]:
    """Return the elements of beams that refuse to be cables, and what the others, or all, may be.

    With the reasons why some of it is refused.
    """
    rungs, refused = candidates(pilots.scene, fixed, pilots.built, pilots.first[0])
    if rungs and rungs[-1] != STRING:
        stiff = refusing(pilots.scene, CABLE, rungs[-1], fixed, pilots.built, pilots.first[0])
        if 0 < len(stiff) < len(open_beams(pilots.scene)) - len(fixed):
            fixed = fixed | dict.fromkeys(stiff, rungs[-1])
            rungs, _ = candidates(pilots.scene, fixed, pilots.built, pilots.first[0])
    if not rungs:
        raise InputError(f"no element takes the scene: {next(iter(refused.values()))}")
    return fixed, [rung for rung in rungs if rung != STRING] or rungs, refused


def _string(
    pilots: Pilots,
    cables: Found,
    finer: Scene | None,
    fixed_steps: int | None,
    fixed: Mapping[str, Rung],
) -> Found | None:
    """Return what pilots of strings have shown, if they do; None if bending matters.

    Where not all beams can be strings, or not all are limp, some may be.
    """
    # Where a run of cables is the answer already, strings only matter if they surely do, and not at
    # all if it was short: their pilots would take longer.
    is_done = cables.chosen is not None and cables.missed(*cables.chosen) <= 1.0
    if is_done and cables.work(*cables.choice()) <= FREE:
        return None
    names = [name for name in open_beams(pilots.scene) if name not in fixed]
    stiff = refusing(pilots.scene, STRING, CABLE, fixed, pilots.built, pilots.first[0])
    able = [name for name in names if name not in stiff]
    if not able:
        return None
    rough = 1.0 if is_done else ROUGH
    limp_all = not stiff and _limp(bending_of(pilots, cables.judge), cables.asked, rough)
    if not limp_all and len(names) == 1:
        return None
    if not limp_all:
        able = limp(pilots, cables.judge, able, cables.asked, rough * NEGLIGIBLE)
    if not able:
        return None
    model = model_of(pilots.scene, CABLE, {**fixed, **dict.fromkeys(able, STRING)})
    try:
        found = search(pilots, model, finer, fixed_steps, cables)
    except (StepError, PlanError, InputError, LoadError):
        return None  # cables have been found to do
    effects = effects_of(pilots, found.judge)
    if not _limp(effects, found.asked):
        return None
    own = [left_out(each, STRING) | of_way(each) for each in effects]
    if len(able) < len(names):
        most = zip(own, found.asked, strict=True)
        if any(sum(each.values()) > NEGLIGIBLE * asked for each, asked in most):
            return None
    return replace(found, floors=floors(effects)).with_effects(own)


def _limp(
    effects: Sequence[Mapping[str, float]], asked: Sequence[float], factor: float = 1.0
) -> bool:
    """Whether bending is negligible, or nearly so by a factor."""
    return all(
        each.get("bending", 0.0) <= factor * NEGLIGIBLE * most
        for each, most in zip(effects, asked, strict=True)
    )


def _price(found: Found) -> tuple[float, float]:
    """Return by how many times the best choice misses the error, 1 if it does not; and its work."""
    choice = found.choice()
    return max(1.0, found.missed(*choice)), found.work(*choice)


def _sentences(
    first: Rung,
    rung: Rung,
    effects: Sequence[Mapping[str, float]],
    asked: Sequence[float],
    pilots: Pilots,
) -> list[str]:
    """Return what decided between elements, in sentences."""
    out = []
    reached = within_reach(effects, asked)
    for each, most, reach, wanted in zip(effects, asked, reached, pilots.wanted, strict=True):
        unit = wanted.quantity.unit
        own = left_out(each, first)
        parts = ", ".join(f"{name} {value:.1e}" for name, value in own.items())
        is_enough = sum(own.values()) <= most
        enough = "sufficient" if is_enough else "as good as converged elements agree"
        if first != CABLE:
            out.append(f"{first} is the richest element that the scene takes")
        elif rung == first:
            out.append(
                f"{first} is {enough}: what it neglects of the {wanted.quantity.name} is "
                f"predicted to be {parts or 'nothing'} {unit}".rstrip()
            )
        elif sum(own.values()) > NEGLIGIBLE * reach:
            out.append(
                f"{first} is not sufficient for the {wanted.quantity.name}: it neglects {parts} "
                f"{unit}, of which at most {NEGLIGIBLE * reach:.1e} may be left out, so {rung} is "
                "taken"
            )
    return out
