"""Named mechanisms of cables in Exudyn, with the same elements, integrator, start and motions.

Functions of time are Exudyn's symbolic expressions, which it evaluates in compiled code.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from importlib import import_module
from typing import Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.problems import Mechanism
from ancfsparse.scene.bodies.rigid_body import RigidBody
from ancfsparse.system.coordinates.state import State
from benchmarks.other_codes.exudyn import Model, OtherRun, Setting

Expression = Callable[[Any], Any]

SPECTRAL_RADIUS = 0.9


def _setting(contractivity: float, linear_solver: str, relative: float = 1e-8) -> Setting:
    sparse = linear_solver == "EigenSparse"
    return Setting("", contractivity, linear_solver, sparse, SPECTRAL_RADIUS, relative=relative)


NEWTON = {
    "modified Newton 0.02, dense": _setting(0.02, "EigenDense"),
    "modified Newton 0.02, sparse": _setting(0.02, "EigenSparse"),
    "modified Newton 0.5, sparse": _setting(0.5, "EigenSparse"),
    "modified Newton 0.02, sparse, to 1e-5": _setting(0.02, "EigenSparse", 1e-5),
    "modified Newton 0.5, sparse, to 1e-5": _setting(0.5, "EigenSparse", 1e-5),
    "full Newton, sparse, to 1e-5": _setting(0.0, "EigenSparse", 1e-5),
}
"""Its fastest settings for scenes of this size, of all that were tried."""


class Builder(Model):
    """A mechanism under construction: its cables, then bodies, joints and functions of time.

    Parameters
    ----------
    problem : Mechanism
        Cables, and perhaps bodies.
    start : State or None
        Where the motion starts, if not in the reference shape.
    """

    def __init__(self, problem: Mechanism, start: State | None) -> None:
        super().__init__(problem.scene, start)
        self.problem, self.symbolic = problem, self.exudyn.symbolic
        self._kept: list[Any] = []  # expression trees must exist as long as the system

    def add_body(self, name: str, mass: float, inertia: float, place: Vector, angle: float) -> Any:
        """Add a rigid body about its centre, by the angle of its x axis; return it."""
        node = self.system.AddNode(self.item.NodeRigidBody2D(referenceCoordinates=[*place, angle]))
        body = self.system.AddObject(
            self.item.ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node)
        )
        self.weigh(body)
        return node, body

    def fix(self, node: int, *coordinates: int) -> None:
        """Hold coordinates where they are."""
        for k in coordinates:
            self.tie(node, k)

    def move(self, node: int, k: int, offset: Expression) -> None:
        """Let a coordinate follow a function of time, counted from its reference."""

        def function(mbs: Any, t: Any, number: Any, given: Any) -> Any:
            return offset(t)

        self._hand_over("object", self.tie(node, k), "offsetUserFunction", function)

    def push(self, node: int, force: Expression) -> None:
        """Apply a force along x that is a function of time."""

        def function(mbs: Any, t: Any, given: Any) -> Any:
            return force(t)

        marker = self.coordinate(node, 0)
        added = self.system.AddLoad(self.item.LoadCoordinate(markerNumber=marker, load=1.0))
        self._hand_over("load", added, "loadUserFunction", function)

    def turn(self, node: int, moment: Expression) -> None:
        """Apply a moment that is a function of time."""

        def function(mbs: Any, t: Any, given: Any) -> Any:
            return self.symbolic.Vector([0.0, 0.0, moment(t)])

        marker = self.system.AddMarker(self.item.MarkerNodeRigid(nodeNumber=node))
        load_vector = self.item.LoadTorqueVector(markerNumber=marker, loadVector=[0.0, 0.0, 1.0])
        added = self.system.AddLoad(load_vector)
        self._hand_over("load", added, "loadVectorUserFunction", function)

    def _hand_over(self, kind: str, item: Any, name: str, function: Callable[..., Any]) -> None:
        utilities = import_module("exudyn.utilities")
        tree = utilities.CreateSymbolicUserFunction(self.system, function, name, item)
        self._kept.append(tree)
        put = {"object": self.system.SetObjectParameter, "load": self.system.SetLoadParameter}
        put[kind](item, name, tree)

    def join(self, a: Any, b: Any, rotation: bool = False) -> None:
        """Make two markers coincide; with their rotation, or free to turn."""
        if rotation:
            axes = [1, 1, 0, 0, 0, 1]
            joint = self.item.GenericJoint(markerNumbers=[a, b], constrainedAxes=axes)
        else:
            joint = self.item.ObjectJointRevolute2D(markerNumbers=[a, b])
        self.system.AddObject(joint)

    def at_node(self, node: int) -> Any:
        """Return a marker at a node of a cable, which turns with its slope."""
        return self.system.AddMarker(self.item.MarkerNodeRigid(nodeNumber=node))

    def at_body(self, body: int, x: float) -> Any:
        """Return a marker on the x axis of a body."""
        return self.system.AddMarker(
            self.item.MarkerBodyRigid(bodyNumber=body, localPosition=[x, 0.0, 0.0])
        )


def moving_supports(b: Builder) -> None:
    """Hold both ends of a slack cable, the right one of which moves."""
    rope, rise = b.nodes["rope"], _step(b)
    b.fix(rope[0], 0, 1)
    b.move(rope[-1], 0, lambda t: 0.15 * rise(t / 0.5) - 0.2)
    b.move(rope[-1], 1, lambda t: -0.15 * rise(t / 0.5))


def double_pendulum_bob(b: Builder) -> None:
    """Hang two cables and a disc in a row."""
    upper, lower = b.nodes["upper"], b.nodes["lower"]
    b.fix(upper[0], 0, 1)
    b.join(b.at_node(upper[-1]), b.at_node(lower[0]))
    _, bob = b.add_body("bob", 0.5, 6.25e-4, np.array([2.05, 0.0]), 0.0)
    b.join(b.at_body(bob, -0.05), b.at_node(lower[-1]), rotation=True)


def spaghetti(b: Builder) -> None:
    """Throw a free cable by a force and a moment."""
    first, rise = b.nodes["rod"][0], _step(b)

    def fraction(t: Any) -> Any:
        return rise(t / 0.5) - rise((t - 2.25) / 0.5)

    b.push(first, lambda t: 8.0 * fraction(t))
    b.turn(first, lambda t: -80.0 * fraction(t))


def elastic_slider_crank(b: Builder) -> None:
    """Hold a rod between crank and slider, whose mass is at its end."""
    rod, sym = b.nodes["rod"], b.symbolic
    b.move(rod[0], 0, lambda t: 0.15 * sym.cos(150.0 * t) - 0.15)
    b.move(rod[0], 1, lambda t: 0.15 * sym.sin(150.0 * t))
    b.fix(rod[-1], 1)
    slider = b.problem.bodies["slider"]
    assert isinstance(slider, RigidBody)
    b.add_mass(rod[-1], slider.mass)


def elastic_four_bar(b: Builder) -> None:
    """Hold a coupler between a crank that turns as prescribed and a rocker."""
    coupler, angle, sym = b.nodes["coupler"], _spin(b, -2.0 * math.pi, 0.5), b.symbolic
    b.move(coupler[0], 0, lambda t: -1.0 * sym.sin(angle(t)))
    b.move(coupler[0], 1, lambda t: sym.cos(angle(t)) - 1.0)
    rocker = b.problem.bodies["rocker"]
    start, way = rocker.positions[0], rocker.vectors[0, 0]
    mass, length = 2.5, 2.5
    place = start + 0.5 * length * way
    turned = float(np.arctan2(way[1], way[0]))
    _, bar = b.add_body("rocker", mass, mass * length**2 / 12.0, place, turned)
    foot = b.system.AddObject(b.item.ObjectGround(referencePosition=[*start, 0.0]))
    b.join(b.system.AddMarker(b.item.MarkerBodyRigid(bodyNumber=foot)), b.at_body(bar, -1.25))
    b.join(b.at_body(bar, 1.25), b.at_node(coupler[-1]))


def spin_up(b: Builder) -> None:
    """Clamp a beam to a hub whose angle is prescribed."""
    rod = b.nodes["rod"]
    node, hub = b.add_body("hub", 1.0, 1.0, np.zeros(2), 0.0)
    b.fix(node, 0, 1)
    b.move(node, 2, _spin(b, 6.0, 15.0))
    b.join(b.at_body(hub, 0.0), b.at_node(rod[0]), rotation=True)


def _step(b: Builder) -> Expression:
    """Return the quintic step as an expression."""
    sym = b.symbolic

    def step(x: Any) -> Any:
        x = sym.min(sym.max(x, 0.0), 1.0)
        return x * x * x * (10.0 + x * (6.0 * x - 15.0))

    return step


def _spin(b: Builder, speed: float, rise: float) -> Expression:
    """Return the angle of `SpinUp` as an expression."""
    sym, turn = b.symbolic, 2.0 * math.pi / rise

    def angle(t: Any) -> Any:
        x = sym.min(t, rise)
        grown = 0.5 * x * x + (sym.cos(turn * x) - 1.0) / turn**2
        return speed / rise * grown + speed * (t - x)

    return angle


def run_mechanism(
    problem: Mechanism,
    build: Callable[[Builder], None],
    start: State | None,
    watched: tuple[tuple[str, int], ...],
    newton: Setting,
    t_end: float,
    dt: float,
    outputs: int,
) -> OtherRun:
    """Simulate a mechanism with Exudyn's generalised-alpha method, by processor time.

    `build` adds bodies, joints and functions of time; positions of the `watched` nodes of cables
    are returned at equal intervals, `outputs` of them.
    """
    b = Builder(problem, start)
    build(b)
    for beam, index in watched:
        b.watch(b.nodes[beam][index])
    return b.run(newton, t_end, dt, t_end / outputs, time.process_time)
