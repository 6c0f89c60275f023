"""What named mechanisms are made of."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.integrators import EnergyMomentum, Implicit
from ancfsparse.results import Trajectory
from ancfsparse.scene import Scene
from ancfsparse.scene.bodies.body import Body
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.bodies.rigid_shapes import Rod

Array = NDArray[np.float64]
G = 9.81
OWN = "two formulations, natural and minimal coordinates, by DOP853 at rtol 1e-12"
# Of most cases.
USUAL = EnergyMomentum()


@dataclass(frozen=True)
class Mechanism:
    """A scene of bodies and joints.

    Attributes
    ----------
    scene : Scene
        Ready to simulate.
    bodies : dict from str to Body
        Its bodies by name.
    watched : dict from str to callable
        Quantities of a run by name, each (k,) or (k, n).
    settles : bool
        Whether a run starts in equilibrium instead of the reference shape.
    """

    scene: Scene
    bodies: Mapping[str, Body]
    watched: Mapping[str, Callable[[Trajectory], Array]]
    settles: bool = False

    def quantities(self, run: Trajectory) -> dict[str, Array]:
        """Return all quantities of a run by name, at its saved times."""
        return {name: of(run) for name, of in self.watched.items()}


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
        Step of the usual setting, extrapolated from this step and half of it [s].
    quantity, time, value, tolerance : str, float, tuple of float, float
        What is asserted, and when [s].
    source : str
        Where the number comes from.
    integrator : Implicit
        Of the usual setting.
    """

    make: Callable[..., Mechanism]
    dt: float
    quantity: str
    time: float
    value: tuple[float, ...]
    tolerance: float
    source: str = OWN
    keys: Mapping[str, tuple[Any, str]] | None = None
    integrator: Implicit = USUAL


def bar(scene: Scene, name: str, start: Array, end: Array) -> RigidBody:
    """Add a uniform bar of 1 kg/m from one point [m] of the plane to another."""
    way = end - start
    length = float(np.linalg.norm(way))
    angle = float(np.arctan2(way[1], way[0]))
    return scene.add_body(Rod(length), mass=length, position=start, orientation=angle, name=name)


def meeting(a: Array, first: float, b: Array, second: float) -> Array:
    """Return the upper point at these distances from two others."""
    way = b - a
    square = float(way @ way)
    along = 0.5 * (square + first**2 - second**2) / square
    up = float(np.sqrt(first**2 / square - along**2))
    return np.asarray(a + along * way + up * np.array([-way[1], way[0]]))
