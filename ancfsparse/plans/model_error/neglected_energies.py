"""Error of a model by the energies it neglects, estimated without a run of a richer model.

Section forces of the solution give the energy that the model neglects; its ratio to the energy that
the model retains is, to first order, the relative change of the compliance or of the inertia.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any, cast

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.plans.model_error.frequency_shift import frequency_effects
from ancfsparse.plans.model_error.section_energies import (
    energies_of_changes,
    loaded_nodes,
    rotary_energy,
    section_energies,
    strain_spread,
    string_energies,
    torsion_energy,
)
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.results import Trajectory
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.scene import ElasticBody, Scene
from ancfsparse.scene.sections.cross_section import principal_axes
from ancfsparse.scene.sections.standard_sections import Section
from ancfsparse.scene.sections.taper import Taper

Solve = Callable[[Scene], Trajectory]
Change = Callable[[ElasticBody], dict[str, Any]]

PROBE = 0.01  # relative change of stiffness or density, to measure the response of a quantity
MAX_RESPONSE = 10.0  # of a quantity to such a change, over its size
STRETCH_WEIGHT = 0.5  # an effect of all elements only matters above the tolerance, twice `enough`
MAX_STATES = 64  # in which energies of sections are evaluated


def neglected_effects(
    run: Trajectory,
    quantity: Quantity,
    solve: Solve | None = None,
    enough: float = 0.0,
    coarse: tuple[Trajectory, Quantity] | None = None,
) -> dict[str, float]:
    """Estimate the change of a quantity by the effects that the model of a run neglects.

    Parameters
    ----------
    run : Trajectory
        A motion, or a path of equilibria by `quasi_static`.
    quantity : Quantity
        Of its scene.
    solve : callable, optional
        Returns the solution of a changed scene, computed as `run` was.  A solution with slightly
        softer and denser material then shows the response of the quantity; otherwise the relative
        response is assumed to be one, which overestimates it for beams that mostly rotate rigidly.
    enough : float, optional
        Effects that are certainly smaller than this [unit of the quantity] need no such solution.
    coarse : Trajectory and Quantity, optional
        A cheaper run that `solve` repeats in place of `run`, and the quantity in its scene.

    Returns
    -------
    dict of str to float
        Largest change over time [unit of the quantity], by effect.

        - ``"shear"``: of cables, whose sections stay normal to the axis.
        - ``"torsion"``: of cables in space.
        - ``"rotary inertia"``: of cables, whose mass is on their axis.
        - ``"stretch"``: difference between converged elements, which define tension and bending
          of a stretched axis in several ways.
        - ``"bending"``: of strings.

        Effects that the model includes are absent.

    Notes
    -----
    Ratios of neglected to retained energies, integrated over the beams, each the largest over time:
    shear ``Q^2/kGA : M^2/EI``; torsion ``T^2/GJ : M^2/EI``; rotary inertia ``rho I w^2 : rho A
    v^2`` with the angular velocity w of the axis; stretch ``2 eps M^2/EI : M^2/EI`` or, if larger,
    ``3/2 eps N^2/EA : N^2/EA + M^2/EI``; bending of strings ``EI kappa^2 : N phi^2`` with the
    curvature of the polygon and its angle phi to the chord; at nodes with forces a kink that is
    rounded by sqrt(EI / N), which displaces them also by itself. Compared with richer models they
    are right within a factor of 2 where the effect is below 10 %
    (tests/plans/model_error/test_neglected_energies.py).
    Quantities with `is_like_rates` contain more of the high frequencies.  Ratios of shear and
    rotary inertia are therefore also formed from the changes between successive states; their
    excess over the ratios above is added as a relative change of the variation of the quantity.
    Frequencies have their own estimates, `frequency_effects`.
    """
    scene = run.system.scene
    if quantity.mode_number is not None:
        return frequency_effects(scene, run, quantity.mode_number)
    all_states, run = run, _thin_out(run)
    beams = [b for b in scene.beams if isinstance(b, ElasticBody)]
    cables = [b for b in beams if b.kind.is_cable]
    strings = [b for b in beams if b.kind.is_string]
    ratios: dict[str, float] = {}
    energies = {b.name: section_energies(run, b) for b in (beams if cables or strings else ())}
    bending: Any = 0.0
    cut = 0.0
    if cables:
        bending = sum(energies[b.name].bending for b in beams if not b.kind.is_string)
        ratios["shear"] = _ratio(sum(energies[b.name].shear for b in cables), bending)
        if scene.dim == 3:
            ratios["torsion"] = _ratio(sum(torsion_energy(scene, run, b) for b in cables), bending)
        ratios["stretch"] = _ratio(sum(energies[b.name].bending_spread for b in cables), bending)
    if strings:
        loaded = loaded_nodes(scene)
        tensions = {b.name: energies[b.name].tension for b in strings}
        ratios["bending"], cut = _bending(run, strings, loaded, tensions)
    is_static = "integrator" not in run.settings and not np.asarray(run.v).any()
    rotary = 0.0
    if cables and not is_static:
        rotary = _rotary_ratio(run, cables, np.asarray(run.v))
    history = quantity.history(all_states)
    size = quantity.response_size(history)
    response, stretch_response = size, size
    base = coarse or (all_states, quantity)
    softening = sum(each for name, each in ratios.items() if name != "stretch")
    bound = max(
        _response_bound(quantity, history, all_states.t, size) * (softening + rotary),
        STRETCH_WEIGHT * size * ratios.get("stretch", 0.0),
    )
    if solve is not None and bound > enough:
        largest = max(softening, rotary)
        both = partial(_soften_and_load, soft=softening / largest, dense=rotary / largest)
        measured = _response(*base, solve, both if largest else _soften_bending)
        response = measured * (largest / (softening + rotary) if largest else 1.0)
    effects = {name: response * each for name, each in ratios.items()}
    if cables or strings:
        retained = sum(each.axial for each in energies.values()) + bending
        spread = _ratio(sum(each.axial_spread for each in energies.values()), retained)
        if solve is not None and STRETCH_WEIGHT * stretch_response * spread > enough:
            stretch_response = _response(*base, solve, _soften)
        effects["stretch"] = max(effects.get("stretch", 0.0), stretch_response * spread)
        if quantity.is_axial_strain and quantity.point is not None:
            of_point = [b for b in cables if b is quantity.point.beam]
            spreads = (strain_spread(run, b, quantity.point) for b in of_point)
            effects["stretch"] = max([effects["stretch"], *spreads])
    if strings:  # the resistance is that of tension, which material does not change
        effects["bending"] = _bending_effect(quantity, ratios["bending"] * size, cut)
    if cables and not is_static:
        effects["rotary inertia"] = response * rotary
        if quantity.is_like_rates:
            shear, inertia = _ratios_of_rates(all_states, beams, cables)
            change = _change(quantity, history, quantity.rounding(all_states))
            if shear > ratios["shear"]:
                effects["shear"] += change * (shear - ratios["shear"])
            if inertia > rotary:
                effects["rotary inertia"] += change * (inertia - rotary)
    return effects


def bending_effect(
    run: Trajectory, bodies: list[ElasticBody], quantity: Quantity, loaded: Mapping[str, set[int]]
) -> float:
    """Estimate the change of a quantity without the bending stiffness of some cables or beams.

    Its size times the bending energy of the polygons of nodes over the energy of their tension,
    both largest over time, or what rounded kinks at the `loaded_nodes` are displaced by [unit of
    the quantity].
    """
    ratio, cut = _bending(_thin_out(run), bodies, loaded)
    return _bending_effect(quantity, ratio * quantity.response_size(quantity.history(run)), cut)


def _bending(
    run: Trajectory,
    bodies: list[ElasticBody],
    loaded: Mapping[str, set[int]],
    tensions: Mapping[str, Vector] | None = None,
) -> tuple[float, float]:
    """Return the ratio of energies of bending and tension, and the displacement of kinks [m]."""
    known = tensions or {}
    energies = [string_energies(run, b, loaded[b.name], known.get(b.name)) for b in bodies]
    bending, stretching, cuts = zip(*energies, strict=True)
    return _ratio(sum(bending), sum(stretching)), float(np.max(cuts))


def _bending_effect(quantity: Quantity, by_energy: float, cut: float) -> float:
    """Return the effect of bending on a quantity; on positions at least that of rounded kinks."""
    return max(by_energy, cut) if quantity.is_displacement else by_energy


def _change(quantity: Quantity, history: Vector, rounding: float) -> float:
    """Return the largest change of a quantity since the start, zero if it is rounding error."""
    change = float(np.linalg.norm(quantity.difference(history, history[:1]), axis=1).max())
    return change if change > rounding else 0.0


def _rotary_ratio(run: Trajectory, cables: list[ElasticBody], v: Vector) -> float:
    """Return the ratio of kinetic energies, of rotating sections and of all mass, of velocities."""
    rotation = sum(rotary_energy(run, body, v) for body in cables)
    return _ratio(rotation, run.system.energies(run.q, v, run.t)[0])


def _ratios_of_rates(
    run: Trajectory, beams: list[ElasticBody], cables: list[ElasticBody]
) -> tuple[float, float]:
    """Return the ratios of shear and rotary inertia of the changes between successive states.

    A wave of angular frequency w is delayed by w times its own ratio.  In the energies of rates it
    has w^2 times the weight, as in the square of a velocity or a moment.
    """
    every = max(1, -(-(len(run.t) - 1) // MAX_STATES))
    before, after = (select_states(run, slice(k, len(run.t) - 1 + k, every)) for k in (0, 1))
    energies = {b.name: energies_of_changes(before, after, b) for b in beams}
    bending = sum(energies[b.name].bending for b in beams if not b.kind.is_string)
    shear = _ratio(sum(energies[b.name].shear for b in cables), bending)
    return shear, _rotary_ratio(after, cables, np.asarray(after.v) - np.asarray(before.v))


def _thin_out(run: Trajectory) -> Trajectory:
    """Return a motion with about as many states as suffice for energies."""
    every = -(-(len(run.t) - 1) // MAX_STATES)
    return run if every <= 1 else select_states(run, slice(None, None, every))


def _ratio(neglected: Any, retained: Any) -> float:
    """Return the ratio of the largest energies over time; zero if nothing is neglected."""
    largest = float(np.max(neglected))
    if largest <= 0.0:
        return 0.0
    return largest / float(np.max(retained)) if np.max(retained) > 0.0 else np.inf


def _response_bound(quantity: Quantity, history: Vector, t: Vector, size: float) -> float:
    """Return a bound of the change of a quantity over the relative change of a property.

    A relative error of the frequency delays a motion by half of this fraction of its duration.
    """
    if len(t) < 2:
        return MAX_RESPONSE * size
    rates = np.linalg.norm(quantity.difference(history[1:], history[:-1]), axis=1) / np.diff(t)
    delay = 0.5 * float(t[-1] - t[0]) * float(rates.max())
    return float(min(MAX_RESPONSE * size, max(size, delay)))


def _response(run: Trajectory, quantity: Quantity, solve: Solve, change: Change) -> float:
    """Return the change of a quantity over the relative change of a property of all beams."""
    scene = changed = run.system.scene
    for body in scene.beams:
        handle = cast(ElasticBody, changed.counterpart(body))
        changed = changed.replaced(handle, **change(handle))
    other = quantity.in_scene(changed)
    return other.largest_difference(other.value(solve(changed)), quantity.value(run)) / PROBE


def _soften(body: ElasticBody) -> dict[str, Any]:
    """Return the changes that reduce every stiffness of a body."""
    youngs_modulus = (1.0 - PROBE) * body.material.youngs_modulus
    return {"material": replace(body.material, youngs_modulus=youngs_modulus)}


def _soften_bending(body: ElasticBody, share: float = 1.0) -> dict[str, Any]:
    """Return the changes that reduce the bending stiffness of a body by a share of `PROBE`."""
    section, factor = body.section, 1.0 - share * PROBE
    if isinstance(section, Taper):
        youngs_modulus = factor * body.material.youngs_modulus
        return {"material": replace(body.material, youngs_modulus=youngs_modulus)}
    _, about_y, about_z = principal_axes(section)
    softer = Section(
        area=section.area,
        inertia_y=factor * about_y,
        inertia_z=factor * about_z,
        torsion_constant=section.torsion_constant,
        shear_factor=section.shear_correction(body.material.poisson_ratio),
    )
    return {"section": softer}


def _soften_and_load(body: ElasticBody, soft: float, dense: float) -> dict[str, Any]:
    """Return the changes that make a body softer in bending and denser; both make it slower."""
    changes = _soften_bending(body, soft)
    material = changes.get("material", body.material)
    density = (1.0 + dense * PROBE) * body.material.density
    return changes | {"material": replace(material, density=density)}
