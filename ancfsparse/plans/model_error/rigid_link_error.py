"""Error of rigid rods in place of beams: bending and stretching, estimated from their forces."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.system import System

SPATIAL = 3
DYNAMIC_FACTOR = 2.0  # deflection under a load applied suddenly over that applied slowly
UNIFORM_LOAD_FACTOR = 5.0 / 384.0  # of q L^4 / E I, midpoint of a hinged beam under a uniform load


def deflection(run: Trajectory, rod: RigidBody, beam: Beam) -> float:
    """Estimate the deflection of a beam in a motion in which it is a rigid rod.

    Largest over time [m]; infinite if the motion is as fast as the lowest vibration of the beam, or
    compression exceeds its buckling load.

    Notes
    -----
    By the principle of virtual work, the multiplier of the length of the rod is the integral of
    the axial force along it; over EA, it is the elongation.  Transversely, inertia and weight are
    a load of at most ``q = rho A |a - g|``, with the deflection ``5 q L^4 / 384 EI`` between the
    ends.  Both are doubled for sudden loads, and divided by ``1 - (omega / omega_1)^2 - P L^2 /
    pi^2 EI`` with the frequency of the accelerations, the lowest axial or bending frequency of the
    hinged beam, and its largest compression P.
    """
    given = {name: float(np.mean(value)) for name, value in beam.stiffnesses().items()}
    length = beam.length
    bending = _bending_stiffness(beam)
    axial = _multipliers(run, rod) * rod.size
    along = run.position(rod.end) - run.position(rod.origin)
    along /= np.linalg.norm(along, axis=1)[:, None]
    across, rates, total = 0.0, 0.0, 0.0
    for end in (rod.origin, rod.end):
        load = run.acceleration(end) - run.system.scene.gravity
        transverse = load - np.einsum("kd,kd->k", load, along)[:, None] * along
        across = max(across, float(np.linalg.norm(transverse, axis=1).max()))
        rates += float(np.square(np.diff(load, axis=0) / np.diff(run.t)[:, None]).sum())
        total += float(np.square(load).sum())
    static = np.abs(axial).max() / given["axial_stiffness"]
    static += transverse_deflection(beam, across) / DYNAMIC_FACTOR
    ratio = rates / (total * _lowest_frequency(beam) ** 2) if total > 0.0 else 0.0
    ratio += max(0.0, -float(axial.min())) * length**2 / (np.pi**2 * bending)
    return float(DYNAMIC_FACTOR * static / (1.0 - ratio)) if ratio < 1.0 else np.inf


def transverse_deflection(beam: Beam, across: float) -> float:
    """Return the deflection [m] of a hinged beam under a sudden transverse acceleration [m/s2]."""
    dense = float(np.mean(beam.stiffnesses()["mass_per_length"]))
    load = DYNAMIC_FACTOR * UNIFORM_LOAD_FACTOR * dense * across
    return float(load * beam.length**4 / _bending_stiffness(beam))


def _bending_stiffness(beam: Beam) -> float:
    """Return the smaller of the mean bending stiffnesses of a beam [N m2]."""
    axes = "zy" if beam.dim == SPATIAL else "z"
    return min(float(np.mean(beam.stiffnesses()[f"bending_stiffness_{axis}"])) for axis in axes)


def _lowest_frequency(beam: Beam) -> float:
    """Return the lowest axial or bending angular frequency of a hinged beam [1/s]."""
    given = {name: float(np.mean(value)) for name, value in beam.stiffnesses().items()}
    slender = np.pi**2 * _bending_stiffness(beam) / beam.length**4
    square = min(slender, given["axial_stiffness"] / beam.length**2) / given["mass_per_length"]
    return float(np.pi * square**0.5)


def deflection_effect(deflected: float, beam: Beam, quantity: Quantity, run: Trajectory) -> float:
    """Return the change of a quantity by the deflection of a beam [unit of the quantity].

    Points move by the deflection, and vibrate about the static one.  Its ratio to the length is a
    relative change of lengths, by half of which the quantity drifts over its path, as the phase of
    a pendulum does.
    """
    history = quantity.history(run)
    path = float(np.linalg.norm(np.diff(history, axis=0), axis=1).sum())
    size = 0.0 if quantity.is_displacement else quantity.size(history)
    direct = quantity.change_by_vibration(deflected, _lowest_frequency(beam))
    return direct + deflected / beam.length * (size + 0.5 * path)


def _multipliers(run: Trajectory, rod: RigidBody) -> Vector:
    """Return the multipliers of the length of a rod, (k,) [N]."""
    system = run.system
    assert isinstance(system, System)
    rows = [k for k, (owner, _) in enumerate(system.constraints.source) if owner == id(rod)]
    lam: Vector = np.asarray(run.lam)[:, rows]
    return np.asarray(lam.sum(axis=1))
