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
from ancfsparse.plans.model_error.effects import LINEAR_FRACTION
from ancfsparse.plans.model_error.frequency_shift import frequency_effects
from ancfsparse.plans.model_error.section_energies import (
    loaded_nodes,
    rotary_energy,
    section_energies,
    strain_spread,
    string_energies,
    torsion_energy,
)
from ancfsparse.plans.quantities.quantity import Quantity, largest_norm
from ancfsparse.results import Trajectory
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.scene import ElasticBody, Scene
from ancfsparse.scene.sections.cross_section import principal_axes
from ancfsparse.scene.sections.standard_sections import Section
from ancfsparse.scene.sections.taper import Taper

Solve = Callable[[Scene], Trajectory]
Change = Callable[[ElasticBody], dict[str, Any]]

MAX_RESPONSE = 10.0  # of a quantity to such a change, over its size
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
    shear ``Q^2/kGA : M^2/EI``; torsion ``T^2/GJ : M^2/EI``; stretch ``2 eps M^2/EI + 3/2 eps N^2/EA
    : M^2/EI + N^2/EA``; rotary inertia ``rho I w^2 : rho A v^2`` with the angular velocity w of the
    axis; bending of strings ``EI kappa^2 : N phi^2`` with the curvature of the polygon and its
    angle phi to the chord; at nodes with forces a kink that is rounded by sqrt(EI / N), which
    displaces them also by itself. Compared with richer models they are right within a factor of 2
    where the effect is below 10 % (tests/plans/model_error/test_neglected_energies.py).
    Quantities with `is_like_rates` contain more of the high frequencies.  Ratios of shear and
    rotary inertia are therefore also formed from the changes between successive states; their
    excess over the ratios above is added as a relative change of the variation of the quantity.
    Frequencies have their own estimates, `frequency_effects`.
    """
    if quantity.mode_number is not None:
        return frequency_effects(run, quantity.mode_number)
    states, history = _thin_out(run), quantity.history(run)
    beams = [b for b in run.system.scene.beams if isinstance(b, ElasticBody)]
    cables = [b for b in beams if b.kind.is_cable]
    strings = [b for b in beams if b.kind.is_string]
    if not cables and not strings:
        return {}
    energies = {b.name: section_energies(states, b) for b in beams}
    bending = sum(each.bending for each in energies.values())
    axial = sum(each.axial for each in energies.values())
    stretch = _ratio(sum(each.spread for each in energies.values()), bending + axial)
    soft: dict[str, float] = {}
    dense: dict[str, float] = {}
    if cables:
        soft["shear"] = _ratio(sum(energies[b.name].shear for b in cables), bending)
        if run.system.scene.dim == 3:
            soft["torsion"] = _ratio(sum(torsion_energy(states, b) for b in cables), bending)
        if "integrator" in run.settings or np.asarray(run.v).any():
            dense["rotary inertia"] = _rotary_ratio(states, cables, np.asarray(states.v))
    size = response = of_stretch = quantity.response_size(history)
    both = sum(soft.values()), sum(dense.values())
    base = coarse or (run, quantity)
    if solve is not None:
        bound = _response_bound(quantity, history, run.t, size)
        if bound * sum(both) > enough:
            weights = [each / max(both) for each in both]
            slow = partial(_soften_and_load, soft=weights[0], dense=weights[1])
            response = _response(*base, solve, slow) / sum(weights)
        if bound * stretch > enough:
            of_stretch = _response(*base, solve, _soften)
    effects = {name: response * each for name, each in {**soft, **dense}.items()}
    effects["stretch"] = of_stretch * stretch
    if quantity.is_axial_strain and quantity.point is not None:
        of_point = [b for b in cables if b is quantity.point.beam]
        spreads = (strain_spread(states, b, quantity.point) for b in of_point)
        effects["stretch"] = max([effects["stretch"], *spreads])
    if strings:  # the resistance is that of tension, which material does not change
        loaded = loaded_nodes(run.system.scene)
        effects["bending"] = bending_effect(run, strings, quantity, loaded)
    if dense and quantity.is_like_rates:
        change = largest_norm(quantity.difference(history, history[:1]))
        for name, ratio in _ratios_of_rates(run, beams, cables).items():
            more = max(0.0, ratio - {**soft, **dense}[name])
            effects[name] += change * more if change > quantity.rounding(run) else 0.0
    return effects


def bending_effect(
    run: Trajectory, bodies: list[ElasticBody], quantity: Quantity, loaded: Mapping[str, set[int]]
) -> float:
    """Estimate the change of a quantity without the bending stiffness of some cables or beams.

    Its size times the bending energy of the polygons of nodes over the energy of their tension,
    both largest over time, or what rounded kinks at the `loaded_nodes` are displaced by [unit of
    the quantity].
    """
    states = _thin_out(run)
    energies = [string_energies(states, body, loaded[body.name]) for body in bodies]
    bending, stretching, cuts = zip(*energies, strict=True)
    size = quantity.response_size(quantity.history(run))
    by_energy = size * _ratio(sum(bending), sum(stretching))
    return max(by_energy, float(np.max(cuts))) if quantity.is_displacement else by_energy


def _rotary_ratio(run: Trajectory, cables: list[ElasticBody], v: Vector) -> float:
    """Return the ratio of kinetic energies, of rotating sections and of all mass, of velocities."""
    rotation = sum(rotary_energy(run, body, v) for body in cables)
    return _ratio(rotation, run.system.energies(run.q, v, run.t)[0])


def _ratios_of_rates(
    run: Trajectory, beams: list[ElasticBody], cables: list[ElasticBody]
) -> dict[str, float]:
    """Return the ratios of shear and rotary inertia of the changes between successive states.

    A wave of angular frequency w is delayed by w times its own ratio.  In the energies of rates it
    has w^2 times the weight, as in the square of a velocity or a moment.
    """
    every = max(1, -(-(len(run.t) - 1) // MAX_STATES))
    before, after = (select_states(run, slice(k, len(run.t) - 1 + k, every)) for k in (0, 1))
    energies = {b.name: section_energies(after, b, before) for b in beams}
    bending = sum(each.bending for each in energies.values())
    rates = np.asarray(after.v) - np.asarray(before.v)
    return {
        "shear": _ratio(sum(energies[b.name].shear for b in cables), bending),
        "rotary inertia": _rotary_ratio(after, cables, rates),
    }


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
    difference = other.largest_difference(other.value(solve(changed)), quantity.value(run))
    return difference / LINEAR_FRACTION


def _soften(body: ElasticBody, soft: float = 1.0, dense: float = 0.0) -> dict[str, Any]:
    """Return the changes that reduce stiffness and increase density, both of which slow a body."""
    material = replace(
        body.material,
        youngs_modulus=(1.0 - soft * LINEAR_FRACTION) * body.material.youngs_modulus,
        density=(1.0 + dense * LINEAR_FRACTION) * body.material.density,
    )
    return {"material": material}


def _soften_and_load(body: ElasticBody, soft: float, dense: float) -> dict[str, Any]:
    """Return the same changes, of bending stiffness alone where the section allows it."""
    section, factor = body.section, 1.0 - soft * LINEAR_FRACTION
    if isinstance(section, Taper):
        return _soften(body, soft, dense)
    _, about_y, about_z = principal_axes(section)
    softer = Section(
        area=section.area,
        inertia_y=factor * about_y,
        inertia_z=factor * about_z,
        torsion_constant=section.torsion_constant,
        shear_factor=section.shear_correction(body.material.poisson_ratio),
    )
    return {"section": softer, **_soften(body, 0.0, dense)}
