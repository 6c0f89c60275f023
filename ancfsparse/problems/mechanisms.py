"""Benchmarks of rigid bodies, joints and linkages, with reference values of other programs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count
from ancfsparse.problems.mechanism import GRAVITY, Mechanism, bar, upper_intersection
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.bodies.rigid_shapes import Box, Rod


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


def four_bar() -> Mechanism:
    """Return a crank of 1 m, a coupler of 2 m and a rocker of 2.5 m, 1 kg/m, on a base of 3 m.

    They start at rest with the crank upright.  Quantities: ``A`` and ``B``, the ends of the coupler
    [m].
    """
    scene = Scene((0.0, -GRAVITY))
    a, d = np.array([0.0, 1.0]), np.array([3.0, 0.0])
    b = upper_intersection(a, 2.0, d, 2.5)
    crank = bar(scene, "crank", np.zeros(2), a)
    coupler = bar(scene, "coupler", a, b)
    rocker = bar(scene, "rocker", d, b)
    scene.pin(crank.origin)
    scene.pin(rocker.origin)
    scene.connect(crank.end, coupler.origin)
    scene.connect(coupler.end, rocker.end)
    ends = {
        "A": lambda run: run.position(coupler.origin),
        "B": lambda run: run.position(coupler.end),
    }
    return Mechanism(scene, ends)


def slider_crank() -> Mechanism:
    """Return a crank of 1 m, a rod of 2 m, 1 kg/m, and a slider of 1 kg on y = 0, from 45 degrees.

    Quantities: ``pin`` between crank and rod [m], ``slider``, its x [m].
    """
    scene = Scene((0.0, -GRAVITY))
    pin = np.sqrt([0.5, 0.5])
    position = np.array([pin[0] + np.sqrt(4.0 - pin[1] ** 2), 0.0])
    crank = bar(scene, "crank", np.zeros(2), pin)
    rod = bar(scene, "rod", pin, position)
    # The shape has no effect, because the slider does not rotate.
    slider = scene.add_body(
        Box(length=0.4, width=0.2, height=0.2), mass=1.0, position=position, name="slider"
    )
    scene.pin(crank.origin)
    scene.connect(crank.end, rod.origin)
    scene.connect(rod.end, slider.origin)
    scene.prismatic(slider.origin, axis=(1, 0))
    watched = {
        "pin": lambda run: run.position(rod.origin),
        "slider": lambda run: run.position(slider.origin)[:, 0],
    }
    return Mechanism(scene, watched)


def n_four_bar(n: int = 2) -> Mechanism:
    """Return four-bar linkages in a row, IFToMM benchmark A02: all bars have 1 m and 1 kg.

    N + 1 uprights start at 1 rad/s, joined by N couplers.  When all bars are collinear the
    constraints lose rank; a run warns if a step requires recovery there.

    Parameters
    ----------
    n : int, optional
        Number of couplers.

    Notes
    -----
    Quantities: ``b0``, the upper end of the first upright [m]; ``energy`` [J].
    """
    scene = Scene((0.0, -GRAVITY))
    count = check_count("n", n, 1)
    speed = 1.0  # of the couplers [m/s]
    uprights = [
        scene.add_body(
            Rod(1.0),
            mass=1.0,
            position=(k, 0),
            orientation=0.5 * np.pi,
            angular_velocity=-speed,
            name=f"upright {k}",
        )
        for k in range(count + 1)
    ]
    couplers = [
        scene.add_body(
            Rod(1.0), mass=1.0, position=(k, 1), velocity=(speed, 0), name=f"coupler {k}"
        )
        for k in range(count)
    ]
    for upright in uprights:
        scene.pin(upright.origin)
    for k, coupler in enumerate(couplers):
        scene.connect(coupler.origin, uprights[k].end)
        scene.connect(coupler.end, uprights[k + 1].end)
    watched = {
        "b0": lambda run: run.position(couplers[0].origin),
        "energy": lambda run: run.energy.total,
    }
    return Mechanism(scene, watched)


def andrews() -> Mechanism:
    """Return Andrews' squeezer: seven bodies in a plane, a spring, and a motor of 0.033 N m.

    Data and angles are taken from the IVP test set.  The four bodies that meet in one point make
    three loops.  Quantities: ``beta``, ``theta``, ``gamma``, ``phi``, ``delta``, ``omega`` and
    ``epsilon`` [rad].
    """
    scene = Scene((0.0, 0.0))
    beta, gamma, delta = -0.06171389001427645, 0.45527981916307036, 0.48736497954384254
    phi, epsilon = 0.22266839016588590, 1.2305474445498211
    theta, omega = 0.0, -phi
    at_a, at_b, at_c = np.array([(-0.06934, -0.00227), (-0.03635, 0.03273), (0.014, 0.072)])
    rr, d, ss, e, zt, zf, u = 0.007, 0.028, 0.035, 0.02, 0.04, 0.02, 0.04

    def add(
        number: int, mass: float, inertia: float, at: Vector, angle: float, *centre: float
    ) -> RigidBody:
        return scene.add_body(
            mass=mass,
            inertia=inertia,
            position=at,
            orientation=angle,
            centre=centre,
            name=f"K{number}",
        )

    crank = rr * _unit(beta)
    k1 = add(1, 0.04325, 2.194e-6, np.zeros(2), beta, 0.00092, 0.0)
    k2 = add(2, 0.00365, 4.410e-7, crank, beta + theta, -0.0115, 0.0)
    k3 = add(3, 0.02373, 5.255e-6, at_b, gamma, 0.01043, -0.01874)
    knee = at_a + zt * _unit(delta)
    k4 = add(4, 0.00706, 5.667e-7, knee, phi + delta, 0.0, 0.01421 - e)
    k5 = add(5, 0.07050, 1.169e-5, at_a, delta, 0.02308, 0.00916)
    heel = at_a + u * _unit(epsilon - 0.5 * np.pi)
    k6 = add(6, 0.00706, 5.667e-7, heel, omega + epsilon, zf - 0.01421, 0.0)
    k7 = add(7, 0.05498, 1.912e-5, at_a, epsilon, 0.00449, -0.01228)
    for body in (k1, k3, k5, k7):
        scene.pin(body.origin)
    scene.connect(k1.at((rr, 0)), k2.origin)
    scene.connect(k5.at((zt, 0)), k4.origin)
    scene.connect(k7.at((0, -u)), k6.origin)
    for point in (k3.at((0, -ss)), k4.at((0, -e)), k6.at((zf, 0))):
        scene.connect(k2.at((-d, 0)), point)
    scene.spring(k3.at((0.02, -0.018)), at_c, stiffness=4530.0, length=0.07785)
    scene.point_moment(k1.origin, 0.033)

    def angle(one: RigidBody, less: RigidBody | None = None) -> Callable[[Trajectory], Vector]:
        if less is None:
            return lambda run: run.body(one).angles
        return lambda run: np.asarray(run.body(one).angles - run.body(less).angles)

    watched = {
        "beta": angle(k1),
        "theta": angle(k2, k1),
        "gamma": angle(k3),
        "phi": angle(k4, k5),
        "delta": angle(k5),
        "omega": angle(k6, k7),
        "epsilon": angle(k7),
    }
    return Mechanism(scene, watched)


def _unit(angle: float) -> Vector:
    return np.array([np.cos(angle), np.sin(angle)])
