"""What a model neglects, estimated from its own solution: no run of the richer model is needed.

Forces in sections of the cheap solution give the energy of what is neglected; over the energy that
is kept it is, to first order, the relative change of the compliance or of the inertia.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.plans.model_error.frequency_shift import frequency_effects
from ancfsparse.plans.model_error.section_energies import (
    energies_of,
    rotary_energy,
    string_energies,
    torsion_energy,
)
from ancfsparse.plans.quantities.quantity import Frequency, Position, Quantity
from ancfsparse.results import Trajectory
from ancfsparse.scene import ElasticBody, Scene
from ancfsparse.scene.sections.cross_section import principal_axes
from ancfsparse.scene.sections.standard_sections import Section
from ancfsparse.scene.sections.taper import Taper

Array = NDArray[np.float64]
March = Callable[[Scene], Trajectory]
Change = Callable[[ElasticBody], dict[str, Any]]

# Relative change of stiffness or density with which the response of a quantity is measured, and by
# how many times its size it may respond at most.
PROBE, UNLIKELY = 0.01, 10.0
# Of what no element includes, it is only stated whether it is larger than what was asked for, of
# which `enough` is half.
FLOOR_SHARE = 0.5
# States of which energies in sections are looked at.
MOST_STATES = 64


def neglected_effects(
    scene: Scene,
    run: Trajectory,
    quantity: Quantity,
    march: March | None = None,
    enough: float = 0.0,
    rough: tuple[Trajectory, Quantity] | None = None,
) -> dict[str, float]:
    """Estimate by how much a quantity would change with what the model of a run neglects.

    Parameters
    ----------
    scene : Scene
        The scene of the run.
    run : Trajectory
        Its motion, or what `quasi_static` returned.
    quantity : Quantity
        What is asked for, of this scene.
    march : callable, optional
        Runs a changed scene as `run` was run.  With it, a run with slightly softer and slightly
        denser material shows how the quantity responds; without, it is taken to respond as much as
        it is large, which is pessimistic for beams that turn more than they bend.
    enough : float, optional
        Effects that are surely smaller than this [unit of the quantity] need no such run.
    rough : Trajectory and Quantity, optional
        A cheaper run that `march` repeats in place of `run`, and the quantity of its scene.

    Returns
    -------
    dict of str to float
        Largest change over time [unit of the quantity], by effect.

        - ``"shear"``: of cables, whose sections stay at right angles to the axis.
        - ``"torsion"``: of cables in space.
        - ``"rotary inertia"``: of cables, whose mass is on their axis.
        - ``"stretch"``: by which converged elements differ, since their tension and their bending
          depend on it in several ways.
        - ``"bending"``: of strings.

        An effect that the model includes is left out.

    Notes
    -----
    Ratios of neglected to retained energies, integrated over the beams, each the largest over time:
    shear ``Q^2/kGA : M^2/EI``; torsion ``T^2/GJ : M^2/EI``; rotary inertia ``rho I w^2 : rho A
    v^2`` with the angular velocity w of the axis; stretch ``2 eps M^2/EI : M^2/EI`` or, if larger,
    ``3/2 eps N^2/EA : N^2/EA + M^2/EI``; bending of strings ``EI kappa^2 : N phi^2`` with the
    curvature of the polygon and its angle phi to the chord.  Compared with richer models they are
    right within a factor of 2 where the effect is below 10 %
    (tests/plans/model_error/test_neglected_energies.py).
    Frequencies have their own estimates, `frequency_effects`.
    """
    if isinstance(quantity, Frequency):
        return frequency_effects(scene, run, quantity)
    whole, run = run, _thinned(run, MOST_STATES)
    beams = [b for b in scene.beams if isinstance(b, ElasticBody)]
    cables = [b for b in beams if b.kind.is_cable]
    strings = [b for b in beams if b.kind.is_string]
    shares: dict[str, float] = {}
    energies = {b.name: energies_of(run, b) for b in (beams if cables or strings else ())}
    bending: Any = 0.0
    if cables:  # beside which thick beams bend too
        bending = sum(energies[b.name].bending for b in beams if not b.kind.is_string)
        shares["shear"] = _ratio(sum(energies[b.name].shear for b in cables), bending)
        if scene.dim == 3:
            shares["torsion"] = _ratio(sum(torsion_energy(scene, run, b) for b in cables), bending)
        shares["stretch"] = _ratio(sum(energies[b.name].bent for b in cables), bending)
    if strings:
        pairs = (string_energies(run, b, energies[b.name].tension) for b in strings)
        shares["bending"] = _ratio(*(sum(each) for each in zip(*pairs, strict=True)))
    still = "integrator" not in run.settings and not np.asarray(run.v).any()
    heavy = 0.0
    if cables and not still:
        turning = sum(rotary_energy(run, body) for body in cables)
        heavy = _ratio(turning, run.system.energies(run.q, run.v, run.t)[0])
    history = quantity.history(whole)
    size = _size(quantity, history)
    soft = dense = taut = size
    base, own = rough or (whole, quantity)
    share = sum(each for name, each in shares.items() if name != "stretch")
    surely = max(
        _most(quantity, history, whole.t, size) * (share + heavy),
        FLOOR_SHARE * size * shares.get("stretch", 0.0),
    )
    if march is not None and surely > enough:
        largest = max(share, heavy)
        both = partial(_altered, soft=share / largest, dense=heavy / largest) if largest else None
        response = _response(base, own, march, both or _softer)
        soft = dense = response * (largest / (share + heavy) if largest else 1.0)
    effects = {name: soft * each for name, each in shares.items()}
    if cables or strings:
        kept = sum(each.axial for each in energies.values()) + bending
        tense = _ratio(sum(each.stretched for each in energies.values()), kept)
        if march is not None and FLOOR_SHARE * taut * tense > enough:
            taut = _response(base, own, march, _slacker)
        effects["stretch"] = max(effects.get("stretch", 0.0), taut * tense)
    if strings:  # tension resists, which material does not change
        effects["bending"] = shares["bending"] * size
    if cables and not still:
        effects["rotary inertia"] = dense * heavy
    return effects


def bending_effect(run: Trajectory, bodies: list[ElasticBody], quantity: Quantity) -> float:
    """Estimate by how much a quantity would change without the bending of some bodies.

    Parameters
    ----------
    run : Trajectory
        Their motion, with bending.
    bodies : list of ElasticBody
        Cables or beams.
    quantity : Quantity
        What is asked for, of their scene.

    Returns
    -------
    float
        Its size times the energy that bends the polygons of the nodes over that of their tension,
        both largest over time [unit of the quantity].
    """
    few = _thinned(run, MOST_STATES)
    folded, held = (sum(each) for each in zip(*(string_energies(few, b) for b in bodies),
                                              strict=True))  # fmt: skip
    return _ratio(folded, held) * _size(quantity, quantity.history(run))


def _thinned(run: Trajectory, most: int) -> Trajectory:
    """Return a motion with about as many states as are enough for energies."""
    every = -(-(len(run.t) - 1) // most)
    if every <= 1:
        return run
    t, q, v, a, lam = (np.asarray(x)[::every] for x in (run.t, run.q, run.v, run.a, run.lam))
    return replace(run, t=t, q=q, v=v, a=a, lam=lam)


def _ratio(neglected: Any, kept: Any) -> float:
    """Return the largest energies over time beside one another; nothing neglected is nothing."""
    most = float(np.max(neglected))
    if most <= 0.0:
        return 0.0
    return most / float(np.max(kept)) if np.max(kept) > 0.0 else np.inf


def _most(quantity: Quantity, history: Array, t: Array, size: float) -> float:
    """Return by how much a quantity changes at most with the relative change of a property.

    A frequency that is off by a share delays a motion by half of that share of its time.
    """
    if len(t) < 2:
        return UNLIKELY * size
    rates = np.linalg.norm(quantity.difference(history[1:], history[:-1]), axis=1) / np.diff(t)
    delayed = 0.5 * float(t[-1] - t[0]) * float(rates.max())
    return float(min(UNLIKELY * size, max(size, delayed)))


def _response(run: Trajectory, quantity: Quantity, march: March, change: Change) -> float:
    """Return the change of the quantity over the relative change of a property of all beams."""
    scene = changed = run.system.scene
    for body in scene.beams:
        own = cast(ElasticBody, changed.counterpart(body))
        changed = changed.replaced(own, **change(own))
    other = quantity.on(changed)
    off = quantity.difference(other.value(march(changed)), quantity.value(run))
    return float(np.linalg.norm(off, axis=1).max()) / PROBE


def _slacker(body: ElasticBody) -> dict[str, Any]:
    """Return what makes a body softer in every way."""
    less = (1.0 - PROBE) * body.material.youngs_modulus
    return {"material": replace(body.material, youngs_modulus=less)}


def _softer(body: ElasticBody, share: float = 1.0) -> dict[str, Any]:
    """Return what makes a body softer in bending, and as stiff along its axis as it is."""
    section, less = body.section, 1.0 - share * PROBE
    if isinstance(section, Taper):
        youngs = less * body.material.youngs_modulus
        return {"material": replace(body.material, youngs_modulus=youngs)}
    _, about_y, about_z = principal_axes(section)
    softer = Section(
        area=section.area,
        inertia_y=less * about_y,
        inertia_z=less * about_z,
        torsion_constant=section.torsion_constant,
        shear_factor=section.shear_correction(body.material.poisson_ratio),
    )
    return {"section": softer}


def _altered(body: ElasticBody, soft: float, dense: float) -> dict[str, Any]:
    """Return what makes a body softer in bending and heavier, both of which make it slower."""
    changes = _softer(body, soft)
    material = changes.get("material", body.material)
    heavier = (1.0 + dense * PROBE) * body.material.density
    return changes | {"material": replace(material, density=heavier)}


def _size(quantity: Quantity, history: Array) -> float:
    """Return how large a quantity is; of a position how far it is from the reference shape."""
    size = quantity.size(history)
    if isinstance(quantity, Position):
        apart = np.linalg.norm(history - quantity.point.position, axis=1)
        size = max(size, float(apart.max()))
    return size
