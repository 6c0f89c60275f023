"""Planar linkages of rigid bars, with reference values of other programs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_count
from ancfsparse.problems.mechanism import GRAVITY, Mechanism, bar, upper_intersection
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.bodies.rigid_shapes import Box, Rod


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
