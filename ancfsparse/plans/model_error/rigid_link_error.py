"""What rigid rods leave out of a motion: bending and stretching of beams, from its forces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.plans.quantities.quantity import Position, Quantity
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.system import System

Array = NDArray[np.float64]

SPATIAL = 3
# A load that sets in at once deflects twice as far as one that grows slowly.
SUDDEN = 2.0
# Middle of a beam on two hinges under an even load: 5 q L^4 / 384 E I.
EVEN = 5.0 / 384.0
# Square of the ratio of frequencies, of the motion and of the beam, and share of the load under
# which it buckles, up to which together it neither vibrates nor gives way.
NEAR = 0.5


def deflection(run: Trajectory, rod: RigidBody, beam: Beam) -> float:
    """Estimate how far a beam would bend and stretch in a motion in which it is a rigid rod.

    Parameters
    ----------
    run : Trajectory
        The motion.
    rod : RigidBody
        The rod.
    beam : Beam
        The beam in its place, which gives its stiffness.

    Returns
    -------
    float
        Largest deflection over time [m]; infinite where the motion is about as fast as its lowest
        vibration, or compression is about that under which it buckles.

    Notes
    -----
    The multiplier of the length of the rod is the integral of the axial force along it, by the
    principle of virtual work for a stretch of all of it; that over EA is its elongation.  Across
    it, its inertia and weight are a load of at most ``q = rho A |a - g|``, which bends it by ``5 q
    L^4 / 384 EI`` between its ends.  Both are doubled, for loads that set in at once, and divided
    by ``1 - (omega / omega_1)^2 - P L^2 / pi^2 EI`` with the frequency of the accelerations, that
    of the beam on hinges or along it, and its largest compression P.
    """
    given = {name: float(np.mean(value)) for name, value in beam.stiffnesses().items()}
    length, dense = beam.length, given["mass_per_length"]
    bending = given["bending_stiffness_z"]
    if beam.dim == SPATIAL:
        bending = min(bending, given["bending_stiffness_y"])
    pulls = _multipliers(run, rod) * rod.size
    along = run.position(rod.end) - run.position(rod.origin)
    along /= np.linalg.norm(along, axis=1)[:, None]
    across, rates, total = 0.0, 0.0, 0.0
    for end in (rod.origin, rod.end):
        felt = run.acceleration(end) - run.system.scene.gravity
        beside = felt - np.einsum("kd,kd->k", felt, along)[:, None] * along
        across = max(across, float(np.linalg.norm(beside, axis=1).max()))
        rates += float(np.square(np.diff(felt, axis=0) / np.diff(run.t)[:, None]).sum())
        total += float(np.square(felt).sum())
    static = np.abs(pulls).max() / given["axial_stiffness"]
    static += under(beam, across) / SUDDEN
    lowest = min(np.pi**2 * bending / length**4, given["axial_stiffness"] / length**2) / dense
    lowest *= np.pi**2
    ratio = rates / (total * lowest) if total > 0.0 else 0.0
    ratio += max(0.0, -float(pulls.min())) * length**2 / (np.pi**2 * bending)
    return float(SUDDEN * static / (1.0 - ratio)) if ratio < NEAR else np.inf


def under(beam: Beam, across: float) -> float:
    """Return how far a beam between its ends bends under an acceleration that sets in [m].

    Parameters
    ----------
    beam : Beam
        The beam.
    across : float
        Acceleration at right angles to it [m/s2].
    """
    given = {name: float(np.mean(value)) for name, value in beam.stiffnesses().items()}
    bending = given["bending_stiffness_z"]
    if beam.dim == SPATIAL:
        bending = min(bending, given["bending_stiffness_y"])
    return SUDDEN * EVEN * given["mass_per_length"] * across * beam.length**4 / bending


def change(deflected: float, length: float, quantity: Quantity, run: Trajectory) -> float:
    """Return by how much a quantity changes with a beam that deflects [unit of the quantity].

    It moves points by as much, and changes lengths by a share with which the quantity drifts as it
    goes on: by half of it in all of its way, as the phase of a pendulum does.
    """
    history = quantity.history(run)
    way = float(np.linalg.norm(np.diff(history, axis=0), axis=1).sum())
    once = length if isinstance(quantity, Position) else quantity.size(history)
    return deflected / length * (once + 0.5 * way)


def _multipliers(run: Trajectory, rod: RigidBody) -> Array:
    """Return the multipliers of the length of a rod, (k,) [N]."""
    system = run.system
    assert isinstance(system, System)
    rows = [k for k, (owner, _) in enumerate(system.constraints.source) if owner == id(rod)]
    lam: Array = np.asarray(run.lam)[:, rows]
    return np.asarray(lam.sum(axis=1))
