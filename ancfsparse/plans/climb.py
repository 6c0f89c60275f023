"""The choice of elements: up the ladder as far as a quantity needs, and down where less will do."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ancfsparse.errors import InputError, PlanFailure, StepFailure
from ancfsparse.plans.models import Rung
from ancfsparse.plans.pilots import Pilots
from ancfsparse.plans.rungs import (
    CABLE,
    FLOOR,
    NEGLIGIBLE,
    STRING,
    bending_of,
    candidates,
    effects_of,
    left_out,
    model_of,
    needed,
    of_way,
)
from ancfsparse.plans.search import Found, search
from ancfsparse.scene import Scene

# The bending of coarse cables may be so many times that of fine strings.
ROUGH = 10.0


def climb(
    pilots: Pilots,
    finer: Scene | None,
    fixed_steps: int | None,
    fixed: Mapping[str, Rung] | None = None,
) -> tuple[Found, list[str]]:
    """Choose one element for all beams whose own is open, and run its pilots.

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
    rungs, refused = candidates(pilots.scene, fixed)
    if not rungs:
        raise InputError(f"no element takes the scene: {next(iter(refused.values()))}")
    richer = [rung for rung in rungs if rung != STRING] or rungs
    # What a thick beam neglects is not estimated, so without cables the richest is taken.
    first = CABLE if CABLE in richer else richer[-1]
    found = search(pilots, model_of(pilots.scene, first, fixed), finer, fixed_steps)
    effects = effects_of(pilots, found.judge, response=True)
    rung = needed(richer, first, effects, found.asked)
    why = _sentences(first, rung, effects, found.asked, pilots)
    why += [f"{name} is not possible: {reason}" for name, reason in refused.items()]
    if rung != first:
        found = search(pilots, model_of(pilots.scene, rung, fixed), finer, fixed_steps)
    elif first == CABLE and STRING in rungs:
        string = _string(pilots, found, finer, fixed_steps, fixed)
        if string is not None and _work(string) < _work(found):
            return string, ["bending adds less than the error, so strings are enough", *why[1:]]
        if string is not None:
            share = _work(string) / _work(found)
            why.append(f"strings would do too, but take {share:.2g} times the work: more elements")
    return found.with_effects([left_out(each, rung) | of_way(each) for each in effects]), why


def _string(
    pilots: Pilots,
    cables: Found,
    finer: Scene | None,
    fixed_steps: int | None,
    fixed: Mapping[str, Rung] | None,
) -> Found | None:
    """Return what pilots of strings have shown, if they do; None if bending matters."""
    if not _limp(bending_of(pilots, cables.judge), cables.asked, ROUGH):
        return None
    try:
        found = search(pilots, model_of(pilots.scene, STRING, fixed), finer, fixed_steps)
    except (StepFailure, PlanFailure, InputError):
        return None  # cables have been found to do
    effects = effects_of(pilots, found.judge, response=False)
    if not _limp(effects, found.asked):
        return None
    return found.with_effects([left_out(each, STRING) | of_way(each) for each in effects])


def _limp(
    effects: Sequence[Mapping[str, float]], asked: Sequence[float], factor: float = 1.0
) -> bool:
    """Whether bending is negligible, or nearly so by a factor."""
    return all(
        each.get("bending", 0.0) <= factor * NEGLIGIBLE * most
        for each, most in zip(effects, asked, strict=True)
    )


def _work(found: Found) -> float:
    finest, steps = found.choice()
    return found.cost.amount(steps, found.coordinates(finest))


def _sentences(
    first: Rung,
    rung: Rung,
    effects: Sequence[Mapping[str, float]],
    asked: Sequence[float],
    pilots: Pilots,
) -> list[str]:
    """Return what decided between elements, in sentences."""
    out = []
    for each, most, wanted in zip(effects, asked, pilots.wanted, strict=True):
        unit = wanted.quantity.unit
        own = left_out(each, first)
        parts = ", ".join(f"{name} {value:.1e}" for name, value in own.items())
        if first != CABLE:
            out.append(f"{first} is the richest element that the scene takes")
        elif rung == first:
            out.append(
                f"{first} is sufficient: what it neglects of the {wanted.quantity.name} is "
                f"predicted to be {parts or 'nothing'} {unit}".rstrip()
            )
        elif sum(own.values()) > NEGLIGIBLE * most:
            out.append(
                f"{first} is not sufficient for the {wanted.quantity.name}: it neglects {parts} "
                f"{unit}, of which at most {NEGLIGIBLE * most:.1e} may be left out, so {rung} is "
                "taken"
            )
        if each.get(FLOOR, 0.0) > most:
            out.append(
                f"elements that are all converged differ by about {each[FLOOR]:.1e} {unit} in the "
                f"{wanted.quantity.name}, because bending and stretch are measured in several ways:"
                f" no model here can promise {most:.1e} {unit}".rstrip()
            )
    return out
