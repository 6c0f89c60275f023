"""Joints lower themselves: a joint that nothing else knows of is held all the same."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.kernels.catalog import element_kind
from ancfsparse.problems import pendulum
from ancfsparse.scene import Clamp, Point
from ancfsparse.scene.joints.joint import Joint
from ancfsparse.scene.kinematics.linear_forms import LINEAR
from ancfsparse.scene.records.record import PointRef, Record
from ancfsparse.system import System

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e6, 4000.0)


@dataclass(frozen=True, eq=False)
class Roller(Joint):
    """Let a node move along x alone: by numbering, or by an equation."""

    node: Point
    by_equation: bool
    name = "roller"

    def lower(self, builder):
        across = builder.position(self.node)[1:]
        if not self.by_equation:
            builder.fix(across)
            return
        for place, held in zip(across, self.node.position[1:], strict=True):
            builder.equation(f"roller at {self.node!r}", -held, (1.0, place, LINEAR))

    @property
    def nodes(self):
        return (self.node,)

    @property
    def direction(self):
        return np.array([0.0, 1.0])

    @property
    def has_multipliers(self):
        return self.by_equation


@dataclass(frozen=True, eq=False)
class RollerSpec(Record):
    """Its record."""

    node: PointRef
    by_equation: bool

    def describe(self, at, made):
        return f"{made.name} ({at(self.node)})"


def rolling(by_equation):
    scene = ancf.Scene(gravity=(0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, -1), 6, SECTION, MATERIAL)
    scene._add(Roller(rod.start, by_equation), RollerSpec(rod.start.reference, by_equation))
    return ancf.simulate(scene, 0.5, 1e-3, solver=ancf.Newton()), rod


def test_a_new_joint_needs_no_other_file():
    (free, rod), (led, other) = rolling(False), rolling(True)
    assert np.max(np.abs(free.position(rod.start)[:, 1])) == 0.0
    assert np.max(np.abs(free.position(rod.start)[:, 0])) > 0.05
    np.testing.assert_allclose(free.position(rod.end), led.position(other.end), atol=1e-7)
    forces = free.reaction(rod.start), led.reaction(other.start)
    np.testing.assert_allclose(*forces, atol=1e-5 * np.max(np.abs(forces[0])))
    assert "roller (body 0, 0)" in free.system.scene.digest()["joints"]


def test_a_point_is_not_held_twice_by_a_new_joint():
    scene, rod = pendulum("thin", 3)
    with pytest.raises(ancf.InputError, match="so the roller is redundant"):
        scene._add(Roller(rod.start, False), RollerSpec(rod.start.reference, False))


class Recorder:
    """A builder that keeps what it is told, for a node of a made-up element."""

    def __init__(self, kind, coordinates):
        self._kind, self._coordinates, self.fixed, self.equations = kind, coordinates, [], []

    def kind(self, node):
        return self._kind

    def rows(self, node):
        return self._coordinates

    def position(self, node):
        return self._coordinates[0, :3]

    def fix(self, coordinates):
        self.fixed += coordinates.tolist()

    def equation(self, label, offset, *terms, about=(), size=0.0):
        self.equations.append(terms)


def test_what_a_clamp_holds_follows_from_the_element():
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 2, SECTION, MATERIAL)
    cable = element_kind("thin", 3)
    made_up = replace(
        cable,
        name="made up",
        node_coordinates=tuple(f"{v}{c}" for v in ("r_", "r_x", "r_z") for c in "xyz"),
        section=("r_z",),
    )
    coordinates = np.arange(20, 29, dtype=np.int32)[None, :]
    held = Recorder(made_up, coordinates)
    Clamp(rod.start).lower(held)
    assert held.fixed == [20, 21, 22, 26, 27, 28]
    held = Recorder(cable, coordinates[:, :6])
    Clamp(rod.start).lower(held)
    assert (held.fixed, held.equations) == ([20, 21, 22, 24, 25], [])
    held = Recorder(cable, coordinates[:, :6])
    Clamp(rod.start, stretch="fixed").lower(held)
    assert held.fixed == list(range(20, 26))


@pytest.mark.parametrize("kind", ["pin", "clamp"])
def test_equations_keep_the_order_of_joints(kind):
    scene = ancf.Scene(gravity=(0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 1), 4, SECTION, MATERIAL)
    getattr(scene, kind)(rod.start)
    scene.rod(rod.end, (3.0, 0.0))
    scene.rod(rod.node(2), (0.0, 3.0))
    labels = System(scene).constraints.labels
    assert [label.split(" at ")[0] for label in labels] == ["clamp"] * (kind == "clamp") + [
        "rod"
    ] * 2
