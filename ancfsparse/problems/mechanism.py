"""The data of named mechanisms, and helpers to build them."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from inspect import signature
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.integrators import EnergyMomentum, Implicit
from ancfsparse.results import Trajectory
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.scene import Scene
from ancfsparse.scene.bodies.body import Body
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.scene.bodies.rigid_shapes import Rod

GRAVITY = 9.81  # [m/s2]
OWN_REFERENCE = "two formulations, natural and minimal coordinates, by DOP853 at rtol 1e-12"
KEY_UNITS = {
    "omega": "rad/s",
    "load": "N",
    "t1": "N",
    "ei": "N m2",
    "w1": "rad/s",
    "turning": "rad/s",
    "angle": "degrees",
    "stiffness": "N/m2",
    "height": "m",
    "length": "m",
    "free_length": "m",
    "speed": "m/s",
    "slip_speed": "m/s",
    "radius": "m",
    "pitch": "m",
    "acceleration": "m/s2",
}
DEFAULT_INTEGRATOR = EnergyMomentum()


@dataclass(frozen=True)
class Mechanism:
    """A scene of bodies and joints.

    Attributes
    ----------
    scene : Scene
        The scene.
    watched : dict from str to callable
        Quantities of a run by name, each (k,) or (k, n).
    settles : bool
        True if a run starts in equilibrium instead of the reference shape.
    separate : bool
        True if each quantity depends on the state at its own time alone, not on those before as
        energies lost and angles of several turns do.
    measured : tuple of str
        Quantities of the computation, not of the motion, which are not extrapolated.
    """

    scene: Scene
    watched: Mapping[str, Callable[[Trajectory], Vector]]
    settles: bool = False
    separate: bool = False
    measured: tuple[str, ...] = ()

    @property
    def bodies(self) -> dict[str, Body]:
        """Bodies of the scene by name."""
        return {body.name: body for body in self.scene.bodies}

    def quantities(self, run: Trajectory, rows: Sequence[int] | None = None) -> dict[str, Vector]:
        """Return all quantities of a run by name, at its saved times or at those of some rows."""
        if rows is None:
            return {name: quantity(run) for name, quantity in self.watched.items()}
        if not self.separate:
            return {name: values[rows] for name, values in self.quantities(run).items()}
        # At all times, the forces in a rod that touches itself took longer than its run.
        return self.quantities(select_states(run, np.asarray(rows)))


@dataclass(frozen=True)
class Case:
    """A named scene and its reference value.

    Attributes
    ----------
    make : callable
        Function that returns the mechanism.
    dt : float
        Time step [s]; the value is extrapolated from this step and half of it.
    quantity, time, value, tolerance : str, float, tuple of float, float
        Reference value of a quantity at a time [s], and its tolerance.
    source : str
        Source of the reference value.
    integrator : Implicit
        Default time integrator.
    units : dict from str to str
        Units of parameters of `make` that differ from `KEY_UNITS`.
    """

    make: Callable[..., Mechanism]
    dt: float
    quantity: str
    time: float
    value: tuple[float, ...]
    tolerance: float
    source: str = OWN_REFERENCE
    integrator: Implicit = DEFAULT_INTEGRATOR
    units: Mapping[str, str] = field(default_factory=dict)

    @property
    def keys(self) -> dict[str, tuple[Any, str]]:
        """Default and unit of each parameter of `make`."""
        parameters = signature(self.make).parameters.values()
        units = {**KEY_UNITS, **self.units}
        return {each.name: (each.default, units.get(each.name, "")) for each in parameters}


def bar(scene: Scene, name: str, start: Vector, end: Vector) -> RigidBody:
    """Add a uniform bar of 1 kg/m from one point [m] of the plane to another."""
    chord = end - start
    length = float(np.linalg.norm(chord))
    angle = float(np.arctan2(chord[1], chord[0]))
    return scene.add_body(Rod(length), mass=length, position=start, orientation=angle, name=name)


def upper_intersection(a: Vector, first: float, b: Vector, second: float) -> Vector:
    """Return the upper intersection of circles about two points with given radii [m]."""
    axis = b - a
    square = float(axis @ axis)
    along = 0.5 * (square + first**2 - second**2) / square
    height = float(np.sqrt(first**2 / square - along**2))
    return np.asarray(a + along * axis + height * np.array([-axis[1], axis[0]]))
