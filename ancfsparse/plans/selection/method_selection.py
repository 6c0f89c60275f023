"""The choice between equilibria and motions: what is within the error at less counted work."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ancfsparse.errors import AncfError, InputError, LoadError, PlanError, StepError
from ancfsparse.plans.discretization_error.error_model import Found
from ancfsparse.plans.discretization_error.mesh_error import COARSEST
from ancfsparse.plans.model_error.quasi_static_error import lowest
from ancfsparse.plans.models.model import Model, coarsest, spread, undecided
from ancfsparse.plans.selection.discretization_search import search
from ancfsparse.plans.selection.element_hierarchy import (
    CABLE,
    NAMES,
    SHEARED,
    effects_of,
    model_of,
    of_way,
    open_beams,
)
from ancfsparse.plans.selection.element_selection import climb
from ancfsparse.plans.selection.explicit_alternative import explicit
from ancfsparse.plans.selection.rigid_link_selection import links
from ancfsparse.plans.trial_runs.load_resolution import paced, resolving
from ancfsparse.plans.trial_runs.solution_methods import ModalSum, Statics, Way
from ancfsparse.plans.trial_runs.trial_runs import FREE, Pilots, tolerances
from ancfsparse.scene import Scene
from ancfsparse.system import System

# What is tried before marching, where loads are slow, and what is tried where marching takes long:
# finding modes takes as much as short motions do.
FIRST: tuple[type[Way], ...] = (Statics,)
LAST: tuple[type[Way], ...] = (ModalSum,)
# Pilots of a motion take this many runs of the longest steps at least: those steps, half of them
# by two integrators, and one more mesh (see `time_error`).
LEAST_PILOTS = 6.0
# Share of the error asked for by which vibrations matter.
MATTERS = 0.25


@dataclass(frozen=True)
class Chosen:
    """What is planned.

    Attributes
    ----------
    pilots : Pilots
        The runs, with the integrator or the way.
    found : Found
        What they have shown.
    why : tuple of str
        Why, in sentences.
    beside : float
        Work of pilots of what was not taken.
    """

    pilots: Pilots
    found: Found
    why: tuple[str, ...]
    beside: float = 0.0


def choose(
    pilots: Pilots,
    finer: Scene | None,
    fixed_steps: int | None,
    free: bool,
    stop: StepError | PlanError | None = None,
) -> Chosen:
    """Choose the way, the elements, the mesh and the step.

    Parameters
    ----------
    pilots : Pilots
        Runs by an integrator.
    finer, fixed_steps
        As in `search`.
    free : bool
        Whether the motion may be found without that integrator.
    stop : StepError or PlanError, optional
        Why it cannot be marched, if that is known: then other ways are left.
    """
    pilots = _paced(pilots, fixed_steps)
    why: list[str] = []
    beside, other, found = 0.0, None, None
    mine = pilots

    def tried(way: Way) -> Chosen | None:
        """Return a way with its pilots, None if it does not do."""
        nonlocal beside, mine
        mine = replace(pilots.with_integrator(way), base=way.fewest)
        try:
            hopeless, lacks_modes = _hopeless(mine)
            if hopeless:
                why.append(hopeless)
                beside += mine.spent
                more = way.richer() if lacks_modes else None
                return None if more is None else tried(more)
            found, reasons = elements(mine, finer, None)
        except AncfError as failure:
            why.append(f"{way} is not possible: {failure}")
            beside += mine.spent
            return None
        excess = _excess(found)
        more = way.richer() if excess > 1.0 and _lacks_modes(found) else None
        if more is not None:
            beside += mine.spent
            return tried(more)
        if excess > 1.0:
            why.append(_missed(way, found.errors(*found.choice()), found.asked, excess))
        made = Chosen(mine, found, (way.reason, *reasons), beside)
        beside += mine.spent
        return made if excess <= 1.0 else None

    for way in _suiting(pilots, FIRST) if free and stop is None else ():
        other = tried(way)
        pilots = _seeing(pilots, mine)
        if other is not None and _amount(other.found) <= _least(pilots, other.found):
            return other
    try:
        if stop is None:
            found, reasons = elements(pilots, finer, fixed_steps)
    except (StepError, PlanError) as failure:
        stop = failure
    if free and (found is None or _excess(found) > 1.0 or _amount(found) > FREE):
        for way in _suiting(pilots, LAST):
            other = tried(way) or other
    if stop is not None and other is None:
        raise stop.with_causes(why) if isinstance(stop, PlanError) else stop
    if found is None:
        assert other is not None
        return other
    other_steps = explicit(pilots, found) if free and pilots.t_end is not None else None
    if other_steps is not None:
        beside += pilots.spent
        pilots, found = other_steps
        reasons = [*reasons, "the stable step of central differences is no burden on this mesh"]
    if other is not None and (_excess(found) > 1.0 or _amount(other.found) < _amount(found)):
        return other
    return Chosen(pilots, found, (*why, *reasons), beside)


def _paced(pilots: Pilots, fixed_steps: int | None) -> Pilots:
    """Return pilots whose longest steps follow loads and drives."""
    if pilots.t_end is None or fixed_steps is not None:
        return pilots
    system = _coarse(pilots)
    return (
        pilots if system is None else replace(pilots, base=paced(system, pilots.t_end, pilots.base))
    )


def _seeing(pilots: Pilots, equilibria: Pilots) -> Pilots:
    """Return pilots whose longest steps see vibrations, where equilibria miss them.

    Steps that are longer than a vibration take most of it away, the undamped ones too, and longer
    and shorter ones agree on what is left.
    """
    run = next((each for each in equilibria.done.values() if each is not None), None)
    way, t_end = equilibria.integrator, pilots.t_end
    if run is None or t_end is None or not isinstance(way, Statics):
        return pilots
    scene = run.run.system.scene
    missed = [way.neglected(run.run, each.quantity.on(scene)) for each in pilots.wanted]
    asked = tolerances(pilots.wanted, run)
    if all(m["inertia"] <= MATTERS * most for m, most in zip(missed, asked, strict=True)):
        return pilots
    return replace(pilots, base=resolving(lowest(run.run), t_end, pilots.base))


def elements(
    pilots: Pilots, finer: Scene | None, fixed_steps: int | None
) -> tuple[Found, list[str]]:
    """Choose the elements where they are open, and run pilots."""
    names = open_beams(pilots.scene)
    if names:
        return _with_links(pilots, finer, fixed_steps, names)
    found = search(pilots, Model(), finer, fixed_steps)
    if not undecided(pilots.scene) and not isinstance(pilots.integrator, Way):
        return found, []
    effects = effects_of(pilots, found.judge, found.rough)
    return found.with_effects([of_way(each) for each in effects]), _given(pilots, effects)


def _with_links(
    pilots: Pilots, finer: Scene | None, fixed_steps: int | None, names: Sequence[str]
) -> tuple[Found, list[str]]:
    """Choose which beams are rigid, and the elements of the others."""
    rods = links(pilots)
    if not rods.rungs:
        return climb(pilots, finer, fixed_steps)
    why = [
        f"{' and '.join(rods.rungs)} may be rigid: deflections are predicted to change the "
        f"{each.quantity.name} by {effects['flexibility']:.1e} {each.quantity.unit}".rstrip()
        for each, effects in zip(pilots.wanted, rods.effects, strict=True)
    ]
    try:
        if len(rods.rungs) < len(names):
            found, more = climb(pilots, finer, fixed_steps, rods.rungs)
        else:
            found, more = search(pilots, Model(rods.rungs), finer, fixed_steps), []
    except (StepError, PlanError):
        return climb(pilots, finer, fixed_steps)
    own = found.effects or ({},) * len(rods.effects)
    both = [{**one, **other} for one, other in zip(own, rods.effects, strict=True)]
    return found.with_effects(both), why + more


def _suiting(pilots: Pilots, kinds: Sequence[type[Way]]) -> Iterator[Way]:
    """Give the ways of some kinds that may do."""
    if pilots.t_end is None:
        return
    system = _coarse(pilots)
    if system is None:
        return
    moved = [replace(each, quantity=each.quantity.on(system.scene)) for each in pilots.wanted]
    for kind in kinds:
        try:
            way = kind.fit(system, pilots.t_end, moved, pilots.start)
        except AncfError:  # what is wrong is stated where motions are tried
            continue
        if way is not None:
            yield way


def _excess(found: Found) -> float:
    """Return the predicted error of the best choice over the one asked for, the largest."""
    errors = found.errors(*found.choice())
    return max(sum(each.values()) / most for each, most in zip(errors, found.asked, strict=True))


def _lacks_modes(found: Found) -> bool:
    """Whether an error is missed for modes that are left out, and not without them."""
    errors = found.errors(*found.choice())
    return all(
        sum(each.values()) - each.get("modes", 0.0) <= most
        for each, most in zip(errors, found.asked, strict=True)
    )


def _coarse(pilots: Pilots) -> System | None:
    """Return the system of cables, or thick beams, on the mesh of the first pilot."""
    counts = spread(pilots.scene, pilots.first[0])
    for rung in (CABLE, SHEARED):
        model = model_of(pilots.scene, rung).with_counts(counts)
        try:
            return pilots.system_of(model)
        except (InputError, LoadError):
            continue
    return None


def _hopeless(pilots: Pilots) -> tuple[str, bool]:
    """Explain what a way leaves out on a coarse mesh already, and whether that is modes alone.

    The sentence is empty if it is little enough.
    """
    way = pilots.integrator
    assert isinstance(way, Way)
    for rung in (CABLE, SHEARED):
        counts = spread(pilots.scene, coarsest(pilots.scene, COARSEST))
        model = model_of(pilots.scene, rung).with_counts(counts)
        try:
            run = pilots.run(model, pilots.base)
        except (InputError, LoadError):
            continue
        if run is None:
            return "", False
        asked, scene = tolerances(pilots.wanted, run), run.run.system.scene
        errors = [way.neglected(run.run, each.quantity.on(scene)) for each in pilots.wanted]
        excess = max(sum(each.values()) / most for each, most in zip(errors, asked, strict=True))
        if excess <= 1.0:
            return "", False
        others = (sum(each.values()) - each.get("modes", 0.0) for each in errors)
        lacks_modes = all(each <= most for each, most in zip(others, asked, strict=True))
        return _missed(way, errors, asked, excess), lacks_modes
    return "", False


def _missed(
    way: Way, errors: Sequence[Mapping[str, float]], asked: Sequence[float], excess: float
) -> str:
    """Explain by what a way misses the error."""
    worst = max(zip(errors, asked, strict=True), key=lambda x: sum(x[0].values()) / x[1])[0]
    largest = max(worst, key=lambda name: worst[name])
    if not np.isfinite(excess):
        return (
            f"{way} would not do: {NAMES[largest]} has no bound, since an equilibrium ceases to "
            "exist, or is unstable"
        )
    return f"{way} would miss the error by {excess:.2g} times, mostly by {NAMES[largest]}"


def _amount(found: Found) -> float:
    finest, steps = found.choice()
    return found.cost.amount(steps, found.coordinates(finest))


def _least(pilots: Pilots, found: Found) -> float:
    """Return what a motion takes at least, with its pilots: the longest steps are enough.

    One such pilot is run on the coarsest mesh; it is needed anyway if the motion is marched.
    """
    model = found.model.with_counts(spread(pilots.scene, coarsest(pilots.scene, COARSEST)))
    run = pilots.run(model, pilots.base)
    if run is None:  # shorter steps take more
        run = pilots.run(model, 2 * pilots.base)
    if run is None:
        return float("inf")
    finest, _ = found.choice()
    step = run.cost.work * run.steps
    return step * (found.coordinates(finest) + LEAST_PILOTS * run.cost.coordinates)


def _given(pilots: Pilots, effects: list[dict[str, float]]) -> list[str]:
    """Return what elements that were given neglect, in sentences: it comes on top of the errors."""
    out = []
    for each, own in zip(pilots.wanted, effects, strict=True):
        left = {name: value for name, value in own.items() if name not in of_way(own)}
        parts = ", ".join(f"{name} {value:.1e}" for name, value in left.items() if value)
        if parts:
            out.append(
                f"element given: of the {each.quantity.name} it neglects about {parts} "
                f"{each.quantity.unit}".rstrip()
                + ", which come on top of the errors of mesh and "
                "steps (stretch: by which converged elements differ)"
            )
    return out
