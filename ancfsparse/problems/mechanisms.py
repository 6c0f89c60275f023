"""Benchmarks of rigid bodies and joints, with reference values of other programs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.problems.mechanism import GRAVITY, Mechanism
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.bodies.rigid_shapes import Rod


def planar_rod() -> Mechanism:
    """Return a uniform rod of 1 m and 1 kg, pinned at one end, that falls from the horizontal.

    Quantities: ``end`` [m].
    """
    scene = Scene((0.0, -GRAVITY))
    rod = scene.add_body(Rod(1.0), mass=1.0, position=(0, 0), name="rod")
    scene.pin(rod.origin)
    return Mechanism(scene, {"end": lambda run: run.position(rod.end)})


def spatial_pendulum() -> Mechanism:
    """Return a box of 1 x 0.2 x 0.1 m and 2 kg, pinned at a corner, with omega (1, 2, 3) rad/s.

    Quantities: ``centre`` [m], ``omega`` [rad/s] along the axes of the body.
    """
    scene = Scene((0.0, 0.0, -GRAVITY))
    moments = 2.0 / 12.0 * np.array([0.2**2 + 0.1**2, 1.0 + 0.1**2, 1.0 + 0.2**2])
    box = scene.add_body(
        inertia=moments,
        mass=2.0,
        centre=(0.5, 0.1, 0.05),
        position=(0, 0, 0),
        angular_velocity=(1, 2, 3),
        name="box",
    )
    scene.pin(box.origin)
    return _spinning(scene, box)


def heavy_top(omega: ArrayLike = (0.0, 150.0, -4.61538)) -> Mechanism:
    """Return the heavy top of Terze (2016): a disc of 15 kg at 1 m from its fixed point.

    Parameters
    ----------
    omega : array_like, shape (3,), optional
        Initial angular velocity [rad/s].

    Notes
    -----
    Quantities: ``centre`` [m], ``omega`` [rad/s] along the axes of the body.
    """
    scene = Scene((0.0, 0.0, -GRAVITY))
    disc = scene.add_body(
        inertia=(0.234375, 0.46875, 0.234375),
        mass=15.0,
        centre=(0, 1, 0),
        position=(0, 0, 0),
        angular_velocity=omega,
        name="disc",
    )
    scene.pin(disc.origin)
    return _spinning(scene, disc)


def dzhanibekov() -> Mechanism:
    """Return a free top that spins about its middle axis, I = diag(2, 3, 4) kg m2, and flips over.

    Quantities: ``omega`` [rad/s] along the axes of the body, ``rotation`` (3 x 3, by rows).
    """
    scene = Scene((0.0, 0.0, 0.0))
    top = scene.add_body(
        inertia=(2, 3, 4), mass=6.0, position=(0, 0, 0), angular_velocity=(1e-3, 5, 0), name="top"
    )
    rotation = {"rotation": lambda run: run.body(top).rotation.reshape(len(run.t), 9)}
    return Mechanism(scene, {"omega": _omega(top), **rotation})


def bricard() -> Mechanism:
    """Return Bricard's mechanism, IFToMM benchmark A04: five bars of 1 m and 1 kg, six hinges.

    It moves although it has one redundant constraint, of which a run warns.
    Quantities: ``p3`` [m], ``energy`` [J].
    """
    scene = Scene((0.0, -GRAVITY, 0.0))
    points = np.array(
        [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)], dtype=float
    )
    axes, bars = np.eye(3)[[1, 2, 0, 1, 2, 0]], []
    for k in range(5):
        axis = points[k + 1] - points[k]
        moments = np.where(np.abs(axis) > 0.5, 2 * 0.1**2, 1.0 + 0.1**2) / 12.0
        name = f"bar {k}"
        bars.append(
            scene.add_body(
                inertia=moments, mass=1.0, centre=0.5 * axis, position=points[k], name=name
            )
        )
    scene.revolute(bars[0].origin, axis=axes[0])
    for k in range(1, 5):
        scene.revolute(bars[k - 1].at(points[k] - points[k - 1]), bars[k].origin, axis=axes[k])
    scene.revolute(bars[4].at(points[5] - points[4]), axis=axes[5])
    watched = {
        "p3": lambda run: run.position(bars[3].origin),
        "energy": lambda run: run.energy.total,
    }
    return Mechanism(scene, watched)


def _spinning(scene: Scene, body: RigidBody) -> Mechanism:
    watched = {"centre": lambda run: run.body(body).centre, "omega": _omega(body)}
    return Mechanism(scene, watched)


def _omega(body: RigidBody) -> Callable[[Trajectory], Vector]:
    return lambda run: run.body(body).angular_velocity_in_body
