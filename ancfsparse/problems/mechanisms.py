"""Benchmarks of rigid bodies and joints, with a number for each that other programs agree on."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.scene.rigid import RigidBody
from ancfsparse.scene.shapes import Box, Rod

Array = NDArray[np.float64]
G = 9.81
OWN = "two formulations, natural and minimal coordinates, by DOP853 at rtol 1e-12"


@dataclass(frozen=True)
class Mechanism:
    """A scene of rigid bodies.

    Attributes
    ----------
    scene : Scene
        Ready to simulate.
    bodies : dict from str to RigidBody
        Its bodies by name.
    watched : dict from str to callable
        Quantities of a run by name, each (k,) or (k, n).
    """

    scene: Scene
    bodies: Mapping[str, RigidBody]
    watched: Mapping[str, Callable[[Trajectory], Array]]

    def quantities(self, run: Trajectory) -> dict[str, Array]:
        """Return all quantities of a run by name, at its saved times."""
        return {name: of(run) for name, of in self.watched.items()}


def planar_rod() -> Mechanism:
    """Return a uniform rod of 1 m and 1 kg, pinned at one end, that falls from horizontal rest.

    Quantities: ``end`` [m].
    """
    scene = Scene((0.0, -G))
    rod = scene.add_body(Rod(1.0), mass=1.0, position=(0, 0), name="rod")
    scene.pin(rod.origin)
    return Mechanism(scene, {"rod": rod}, {"end": lambda run: run.position(rod.end)})


def spatial_pendulum() -> Mechanism:
    """Return a box of 1 x 0.2 x 0.1 m and 2 kg, pinned at a corner, with omega (1, 2, 3) rad/s.

    Quantities: ``centre`` [m], ``omega`` [rad/s] along the axes of the body.
    """
    scene = Scene((0.0, 0.0, -G))
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
        Angular velocity at the start [rad/s].

    Notes
    -----
    Quantities: ``centre`` [m], ``omega`` [rad/s] along the axes of the body.
    """
    scene = Scene((0.0, 0.0, -G))
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
    return Mechanism(scene, {"top": top}, {"omega": _omega(top), **rotation})


def four_bar() -> Mechanism:
    """Return a crank of 1 m, a coupler of 2 m and a rocker of 2.5 m, 1 kg/m, on a base of 3 m.

    They start at rest with the crank upright.  Quantities: ``A`` and ``B``, the ends of the coupler
    [m].
    """
    scene = Scene((0.0, -G))
    a, d = np.array([0.0, 1.0]), np.array([3.0, 0.0])
    b = _meeting(a, 2.0, d, 2.5)
    crank = _bar(scene, "crank", np.zeros(2), a)
    coupler = _bar(scene, "coupler", a, b)
    rocker = _bar(scene, "rocker", d, b)
    scene.pin(crank.origin)
    scene.pin(rocker.origin)
    scene.connect(crank.end, coupler.origin)
    scene.connect(coupler.end, rocker.end)
    ends = {
        "A": lambda run: run.position(coupler.origin),
        "B": lambda run: run.position(coupler.end),
    }
    return Mechanism(scene, {"crank": crank, "coupler": coupler, "rocker": rocker}, ends)


def slider_crank() -> Mechanism:
    """Return a crank of 1 m, a rod of 2 m, 1 kg/m, and a slider of 1 kg on y = 0, from 45 degrees.

    Quantities: ``pin`` between crank and rod [m], ``slider``, its x [m].
    """
    scene = Scene((0.0, -G))
    pin = np.sqrt([0.5, 0.5])
    place = np.array([pin[0] + np.sqrt(4.0 - pin[1] ** 2), 0.0])
    crank = _bar(scene, "crank", np.zeros(2), pin)
    rod = _bar(scene, "rod", pin, place)
    # It does not turn, so its shape does not matter.
    slider = scene.add_body(Box(0.4, 0.2, 0.2), mass=1.0, position=place, name="slider")
    scene.pin(crank.origin)
    scene.connect(crank.end, rod.origin)
    scene.connect(rod.end, slider.origin)
    scene.prismatic(slider.origin, axis=(1, 0))
    watched = {
        "pin": lambda run: run.position(rod.origin),
        "slider": lambda run: run.position(slider.origin)[:, 0],
    }
    return Mechanism(scene, {"crank": crank, "rod": rod, "slider": slider}, watched)


def bricard() -> Mechanism:
    """Return Bricard's mechanism, IFToMM benchmark A04: five bars of 1 m and 1 kg, six hinges.

    Its constraints outnumber its freedoms by one although it moves: a run warns of that.
    Quantities: ``p3`` [m], ``energy`` [J].
    """
    scene = Scene((0.0, -G, 0.0))
    points = np.array(
        [(0, 0, 0), (1, 0, 0), (1, -1, 0), (1, -1, 1), (0, -1, 1), (0, 0, 1)], dtype=float
    )
    axes, bars = np.eye(3)[[1, 2, 0, 1, 2, 0]], []
    for k in range(5):
        way = points[k + 1] - points[k]
        moments = np.where(np.abs(way) > 0.5, 2 * 0.1**2, 1.0 + 0.1**2) / 12.0
        name = f"bar {k}"
        bars.append(
            scene.add_body(
                inertia=moments, mass=1.0, centre=0.5 * way, position=points[k], name=name
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
    return Mechanism(scene, {bar.name: bar for bar in bars}, watched)


def _spinning(scene: Scene, body: RigidBody) -> Mechanism:
    watched = {"centre": lambda run: run.body(body).centre, "omega": _omega(body)}
    return Mechanism(scene, {body.name: body}, watched)


def _omega(body: RigidBody) -> Callable[[Trajectory], Array]:
    return lambda run: run.body(body).angular_velocity_in_body


def _bar(scene: Scene, name: str, start: Array, end: Array) -> RigidBody:
    """Add a uniform bar of 1 kg/m between two points of the plane."""
    way = end - start
    length = float(np.linalg.norm(way))
    angle = float(np.arctan2(way[1], way[0]))
    return scene.add_body(Rod(length), mass=length, position=start, orientation=angle, name=name)


def _meeting(a: Array, first: float, b: Array, second: float) -> Array:
    """Return the upper point at these distances from two others."""
    way = b - a
    square = float(way @ way)
    along = 0.5 * (square + first**2 - second**2) / square
    up = float(np.sqrt(first**2 / square - along**2))
    return np.asarray(a + along * way + up * np.array([-way[1], way[0]]))


@dataclass(frozen=True)
class Case:
    """A named scene and its reference value.

    Attributes
    ----------
    make : callable
        Returns the scene.
    keys : dict from str to (default, unit)
        What it takes.
    dt : float
        Step of the usual setting: `EnergyMomentum`, extrapolated from this step and half of it [s].
    quantity, time, value, tolerance : str, float, tuple of float, float
        What is asserted, and when [s].
    source : str
        Where the number comes from.
    """

    make: Callable[..., Mechanism]
    dt: float
    quantity: str
    time: float
    value: tuple[float, ...]
    tolerance: float
    source: str = OWN
    keys: Mapping[str, tuple[Any, str]] | None = None


MECHANISMS = {
    "planar_rod": Case(planar_rod, 1e-3, "end", 2.0, (0.9994654895, -0.0326915167), 1e-8, OWN),
    "spatial_pendulum": Case(
        spatial_pendulum, 1e-3, "centre", 2.0, (-0.4672929732, -0.1624837349, -0.1331777500), 1e-8
    ),
    "heavy_top": Case(
        heavy_top,
        1e-4,
        "centre",
        0.2,
        (0.605550561, 0.598957682, -0.523983027),
        1e-7,
        f"data of Exudyn's test heavyTop after Terze (2016); {OWN}",
        {"omega": ((0.0, 150.0, -4.61538), "rad/s")},
    ),
    "dzhanibekov": Case(
        dzhanibekov, 5e-3, "omega", 10.0, (0.003232663, -4.999998740, -0.002173719), 2e-7
    ),
    "four_bar": Case(four_bar, 1e-3, "A", 1.0, (0.4428171674, -0.8966119318), 1e-7),
    "slider_crank": Case(slider_crank, 1e-3, "slider", 1.0, (1.5171638197,), 1e-8),
    "bricard": Case(
        bricard,
        2e-3,
        "p3",
        1.0,
        (0.510501461, -1.649167599, 0.140123115),
        1e-7,
        f"IFToMM benchmark A04; {OWN}",
    ),
}
"""Scenes of rigid bodies by name."""
