"""Shift of a natural frequency by neglected effects, from Rayleigh's quotient of its mode.

To first order, a richer model has for the same mode the energies of the simple model and the
neglected ones.  A compliance that stores the energy U lowers the frequency by the fraction U / 2 E,
with the largest energy E of the mode; a stiffness raises it, and inertia lowers it, likewise.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError, LoadError
from ancfsparse.plans.model_error.effects import LINEAR_FRACTION
from ancfsparse.plans.model_error.section_energies import (
    folds,
    loaded_nodes,
    rotary_energy,
    torsion_energy,
)
from ancfsparse.results import Trajectory
from ancfsparse.results.solutions.modes import Modes
from ancfsparse.scene import ElasticBody, Scene
from ancfsparse.solve.vibration.modes import modes

# Sign of the change of a frequency by an effect.
SIGNS = {"shear": -1.0, "rotary inertia": -1.0, "torsion": 1.0, "bending": 1.0}


def frequency_effects(run: Trajectory, number: int) -> dict[str, float]:
    """Estimate the change of a natural frequency of cables and strings at an equilibrium [Hz].

    By effect, named as in `neglected_effects`.  The effect of torsion is the whole frequency if
    torsional vibrations, which cables lack, may precede it.
    """
    scene = run.system.scene
    lowest = _modes(scene, run, number)
    i, frequencies = number - 1, lowest.frequencies
    if frequencies[i] == 0.0:
        return {}
    shifts = [_shifts(scene, run, lowest, k) for k in range(len(lowest))]
    richer = frequencies + [sum(SIGNS[name] * x for name, x in each.items()) for each in shifts]
    k = int(np.argsort(richer)[i])  # mode with this number in the richer model
    total = sum(shifts[k].values())
    change = abs(float(frequencies[i] - richer[k]))
    effects = {name: x * change / total for name, x in shifts[k].items()} if total else {}
    if scene.dim == 3 and any(
        body.kind.is_cable and _lowest_twist(body) < frequencies[i]
        for body in _elastic_bodies(scene)
    ):
        effects["torsion"] = float(frequencies[i])
    return effects


def _elastic_bodies(scene: Scene) -> list[ElasticBody]:
    return [body for body in scene.beams if isinstance(body, ElasticBody)]


def _modes(scene: Scene, run: Trajectory, number: int) -> Modes:
    """Return the requested modes and one more, which may exchange numbers with the last."""
    try:
        return modes(scene, number + 1, at=run.last)
    except (InputError, LoadError):
        return modes(scene, number, at=run.last)


def _shifts(scene: Scene, run: Trajectory, lowest: Modes, k: int) -> dict[str, float]:
    """Return the shifts of the frequency of mode k by neglected effects [Hz]."""
    frequency, shape = float(lowest.frequencies[k]), lowest.shapes[k]
    if frequency == 0.0:
        return {}
    size = max(float(np.ptp(body.positions, axis=0).max()) for body in scene.beams)
    one, other = (lowest.state(k, sign * LINEAR_FRACTION * size).q for sign in (1.0, -1.0))
    mass = float(np.square(one - other).sum() / np.square(2.0 * shape).sum())  # modal mass
    energy = 0.5 * mass * (2.0 * np.pi * frequency) ** 2
    states = _states(run, (run.q[-1], one, other), 0.5 * (one - other))
    ratios: defaultdict[str, float] = defaultdict(float)
    loaded = loaded_nodes(scene)
    for body in _elastic_bodies(scene):
        if body.kind.is_string:
            ratios["bending"] += _bending(states, body, loaded[body.name]) / energy
        elif body.kind.is_cable:
            ratios["shear"] += _shear(states, body) / energy
            ratios["rotary inertia"] += float(rotary_energy(states, body)[0]) / (0.5 * mass)
            if scene.dim == 3:
                twist = torsion_energy(states, body)
                ratios["torsion"] += 0.5 * float(twist[1] + twist[2]) / energy
    return {name: 0.5 * frequency * ratio for name, ratio in ratios.items()}


def _states(run: Trajectory, q: Sequence[Vector], v: Vector) -> Trajectory:
    """Return states with the same velocity, as a trajectory."""
    k = len(q)
    rates, lam = np.tile(v, (k, 1)), np.repeat(run.lam[-1:], k, axis=0)
    return replace(run, t=np.repeat(run.t[-1:], k), q=np.stack(q), v=rates, a=0.0 * rates, lam=lam)


def _shear(states: Trajectory, body: ElasticBody) -> float:
    """Return the shear energy of a mode [J]."""
    force = states.section_force(body).Q
    change = 0.5 * (force[1] - force[2]).reshape(body.n_elements, -1)
    energies = np.square(change).sum(axis=1) / body.stiffnesses()["shear_stiffness_y"]
    return float(0.5 * body.lengths @ energies)


def _bending(states: Trajectory, body: ElasticBody, loaded: set[int]) -> float:
    """Return the bending energy of the polygon of a string in a mode [J]."""
    corners = folds(states, body, loaded, states.section_force(body).N)
    changes = np.square(corners.changes[1] - corners.changes[2]).sum(axis=1)
    return float(0.125 * (corners.stiffness / corners.lengths[0]) @ changes)


def _lowest_twist(body: ElasticBody) -> float:
    """Return the lowest torsional frequency of a body clamped at one end [Hz]."""
    given = body.stiffnesses()
    inertia = np.asarray(given["inertia_y"]) + np.asarray(given["inertia_z"])
    speed = np.sqrt(np.min(np.asarray(given["torsion_stiffness"]) / inertia))
    return float(speed / (4.0 * body.lengths.sum()))
