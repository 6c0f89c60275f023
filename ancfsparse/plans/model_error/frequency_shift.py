"""What a model neglects of a natural frequency, by Rayleigh's quotient of its own mode.

A richer model of the same mode has, to first order, the energies of the cheap one and those that it
neglects.  What becomes softer by an energy U, of a mode whose largest energy is E, vibrates slower
by the share U / 2 E; what becomes stiffer, faster; and inertia adds in the same way.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, LoadError
from ancfsparse.plans.model_error.section_energies import (
    directions,
    folds,
    rotary_energy,
    torsion_energy,
)
from ancfsparse.plans.quantities.quantity import Frequency
from ancfsparse.results import Trajectory
from ancfsparse.results.solutions.modes import Modes
from ancfsparse.scene import ElasticBody, Scene
from ancfsparse.solve.vibration.modes import modes

Array = NDArray[np.float64]

# Largest displacement with which a mode is evaluated, over the size of the scene.
SMALL = 1e-4
# Modes beyond the one asked for whose places may change with it.
MORE = 3
# Cables have no vibrations of twist.  Places do not change if the lowest has so many times the
# frequency.
CLEAR = 1.2
# Whether an effect makes vibrations faster or slower.
SIGNS = {"shear": -1.0, "rotary inertia": -1.0, "torsion": 1.0, "bending": 1.0}


def frequency_effects(scene: Scene, run: Trajectory, quantity: Frequency) -> dict[str, float]:
    """Estimate by how much a natural frequency would change with what a model neglects.

    Parameters
    ----------
    scene : Scene
        The scene, of cables and strings.
    run : Trajectory
        Its equilibrium.
    quantity : Frequency
        The number of the frequency.

    Returns
    -------
    dict of str to float
        Changes by effect, named as in `neglected_effects` [Hz].  The torsion of cables is all of
        the frequency where vibrations of twist, which cables do not have, may come before it.
    """
    found = _modes(scene, run, quantity.number)
    place, frequencies = quantity.number - 1, found.frequencies
    if frequencies[place] == 0.0:
        return {}
    each = [_of_mode(scene, run, found, k) for k in range(len(found))]
    richer = frequencies + [sum(SIGNS[name] * x for name, x in one.items()) for one in each]
    takes = int(np.argsort(richer)[place])  # the mode that has this place in the richer model
    own = sum(each[takes].values())
    off = abs(float(frequencies[place] - richer[takes]))
    effects = {name: x * off / own for name, x in each[takes].items()} if own else {}
    if scene.dim == 3 and any(
        body.kind.is_cable and _slowest_twist(body) < CLEAR * frequencies[place]
        for body in _elastic(scene)
    ):
        effects["torsion"] = float(frequencies[place])
    return effects


def _elastic(scene: Scene) -> list[ElasticBody]:
    return [body for body in scene.beams if isinstance(body, ElasticBody)]


def _modes(scene: Scene, run: Trajectory, number: int) -> Modes:
    """Return some more modes than are asked for, if there are."""
    try:
        return modes(scene, number + MORE, at=run.last)
    except (InputError, LoadError):
        return modes(scene, number, at=run.last)


def _of_mode(scene: Scene, run: Trajectory, found: Modes, k: int) -> dict[str, float]:
    """Return by how much what is neglected would shift the frequency of a mode [Hz]."""
    frequency, shape = float(found.frequencies[k]), found.shapes[k]
    if frequency == 0.0:
        return {}
    size = max(float(np.ptp(body.positions, axis=0).max()) for body in scene.beams)
    one, other = (found.state(k, sign * SMALL * size).q for sign in (1.0, -1.0))
    mass = float(np.square(one - other).sum() / np.square(2.0 * shape).sum())  # of that vibration
    energy = 0.5 * mass * (2.0 * np.pi * frequency) ** 2
    moved = _states(run, (run.q[-1], one, other), 0.5 * (one - other))
    shares: defaultdict[str, float] = defaultdict(float)
    for body in _elastic(scene):
        if body.kind.is_string:
            shares["bending"] += _bending(moved, body) / energy
        elif body.kind.is_cable:
            shares["shear"] += _shear(moved, body) / energy
            shares["rotary inertia"] += float(rotary_energy(moved, body)[0]) / (0.5 * mass)
            if scene.dim == 3:
                twist = torsion_energy(scene, moved, body)
                shares["torsion"] += 0.5 * float(twist[1] + twist[2]) / energy
    return {name: 0.5 * frequency * share for name, share in shares.items()}


def _states(run: Trajectory, q: Sequence[Array], v: Array) -> Trajectory:
    """Return states that move alike, as a trajectory."""
    k = len(q)
    rates, lam = np.tile(v, (k, 1)), np.repeat(run.lam[-1:], k, axis=0)
    return replace(run, t=np.repeat(run.t[-1:], k), q=np.stack(q), v=rates, a=0.0 * rates, lam=lam)


def _shear(moved: Trajectory, body: ElasticBody) -> float:
    """Return the energy of the change of the transverse force that goes with a mode [J]."""
    force = moved.section_force(body).Q
    change = 0.5 * (force[1] - force[2]).reshape(body.n_elements, -1)
    energies = np.square(change).sum(axis=1) / body.stiffnesses()["shear_stiffness_y"]
    return float(0.5 * body.lengths @ energies)


def _bending(moved: Trajectory, body: ElasticBody) -> float:
    """Return the energy that bending the polygon of a string along a mode would take [J]."""
    changes, stiffness = folds(directions(moved, body), body)
    return float(0.125 * stiffness @ np.square(changes[1] - changes[2]).sum(axis=1))


def _slowest_twist(body: ElasticBody) -> float:
    """Return the lowest frequency that twist of a body may have, held at one end [Hz]."""
    given = body.stiffnesses()
    inertia = np.asarray(given["inertia_y"]) + np.asarray(given["inertia_z"])
    speed = np.sqrt(np.min(np.asarray(given["torsion_stiffness"]) / inertia))
    return float(speed / (4.0 * body.lengths.sum()))
