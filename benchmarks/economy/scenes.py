"""Scenes with open elements and meshes, for plans and for the search."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

from ancfsparse import plans
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.scene import Circle, Material, Pulse, Ramp, Rectangle, Scene

SHEARED = {"curvature": "section", "section_strain": "nodal"}
RICHEST = "thick", SHEARED
SOFT_ROD = Rectangle(0.01, 0.01), Material(1e8, 4000.0, 0.3)
STEEL = Rectangle(0.01, 0.01), Material(2.1e11, 7850.0, 0.3)
ROD = Circle(0.01), Material(1e8, 4000.0, 0.3)
FLEXIBLE = Rectangle(0.01, 0.01), Material(2e9, 1000.0, 0.3)
DOWN = (0.0, -9.81)  # gravity in the plane [m/s2]
DOWN_IN_SPACE = (0.0, 0.0, -9.81)  # [m/s2]


@dataclass(frozen=True)
class Discretization:
    """An element with options and a mesh, of which beams are made."""

    element: str
    n: int | str
    options: Mapping[str, Any] = field(default_factory=dict)

    def beam(self, scene: Scene, start: Any, end: Any, profile: Any, **more: Any) -> Any:
        """Add a beam."""
        given: dict[str, Any] = {
            "section": profile[0],
            "material": profile[1],
            **self.options,
            **more,
        }
        return scene.add_beam(self.element, start, end, self.n, **given)


Built = tuple[Scene, Quantity]


@dataclass(frozen=True)
class Case:
    """A scene and its quantity of interest."""

    build: Callable[[Discretization], Built]  # the scene and the quantity
    t_end: float | None  # [s]; None for the equilibrium
    # elements with their options in the search; the first is the reference
    elements: tuple[tuple[str, Mapping[str, str]], ...] = (("thin", {}), ("l2t2", {}))
    most: int = 64  # elements of a beam in the reference, but for thick ones
    steps: int = 12800  # steps of the reference; the search takes up to half of them
    # elements of a beam in the search
    meshes: tuple[int, ...] = (2, 3, 4, 6, 8, 12, 16, 24, 32, 48)
    is_thick_tried: bool = True  # as reference: not in slender scenes, where they lock


THIN: tuple[tuple[str, Mapping[str, str]], ...] = (("thin", {}),)
NET: tuple[tuple[str, Mapping[str, str]], ...] = (("thin", {}), ("string", {}))
LONG_MESHES = (12, 16, 24, 32, 48, 64, 96, 128)
THICK: tuple[tuple[str, Mapping[str, str]], ...] = (("thick", SHEARED), ("thin", {}))


def _pendulum(profile: Any, dim: int = 2, quantity_of: Callable[..., Quantity] = plans.position,
              length: float = 2.0, **more: Any) -> Callable[[Discretization], Built]:  # fmt: skip
    def build(of: Discretization) -> Built:
        scene = Scene(DOWN if dim == 2 else DOWN_IN_SPACE)
        axis = (0.0,) * (dim - 1)
        rod = of.beam(scene, (0.0, *axis), (length, *axis), profile, **more)
        scene.pin(rod.start)
        return scene, quantity_of(rod.end)

    return build


def _cantilever(profile: Any, load: Any, length: float = 1.0,
                quantity_of: Callable[..., Quantity] = plans.position, root: bool = False,
                gravity: Any = (0.0, 0.0)) -> Callable[[Discretization], Built]:  # fmt: skip
    def build(of: Discretization) -> Built:
        scene = Scene(gravity)
        axis = (0.0,) * (len(gravity) - 1)
        beam = of.beam(scene, (0.0, *axis), (length, *axis), profile)
        scene.clamp(beam.start)
        if load is not None:
            scene.point_force(beam.end, load)
        return scene, quantity_of(beam.start if root else beam.end)

    return build


def _chain(links: int, profile: Any = SOFT_ROD, dim: int = 2) -> Callable[[Discretization], Built]:
    def build(of: Discretization) -> Built:
        scene = Scene(DOWN if dim == 2 else DOWN_IN_SPACE)
        axis = (0.0,) * (dim - 1)
        before = None
        for k in range(links):
            rod = of.beam(scene, (0.8 * k, *axis), (0.8 * (k + 1), *axis), profile)
            if before is None:
                scene.pin(rod.start)
            else:
                scene.connect(before, rod.start)
            before = rod.end
        return scene, plans.position(rod.end)

    return build


def _line(profile: Any, load: Any = None, **more: Any) -> Callable[[Discretization], Built]:
    def build(of: Discretization) -> Built:
        scene = Scene(DOWN)
        cord = of.beam(scene, (0.0, 0.0), (1.0, 0.0), profile, **more)
        scene.pin(cord.start)
        scene.pin(cord.end)
        if load is not None:
            scene.point_force(cord.at(0.4), load)
        return scene, plans.position(cord.at(0.5))

    return build


def _shaken(of: Discretization) -> Built:
    scene = Scene(DOWN)
    rod = of.beam(scene, (0.0, 0.0), (0.0, -1.0), SOFT_ROD)
    scene.drive(rod.start, lambda t: (0.1 * (1.0 - math.cos(6.0 * t)), 0.0))
    return scene, plans.position(rod.end)


def _loaded(mass: float, stiffness: float) -> Callable[[Discretization], Built]:
    def build(of: Discretization) -> Built:
        scene = Scene(DOWN)
        rod = of.beam(scene, (0.0, 0.0), (1.0, 0.0), FLEXIBLE)
        scene.pin(rod.start)
        if mass:
            scene.add_mass(rod.end, mass)
        if stiffness:
            scene.spring(rod.end, (1.0, 1.0), stiffness=stiffness)
        return scene, plans.position(rod.end)

    return build


def _with_body(of: Discretization) -> Built:
    scene = Scene(DOWN)
    rod = of.beam(scene, (0.0, 0.0), (1.0, 0.0), FLEXIBLE)
    scene.pin(rod.start)
    body = scene.add_body(mass=0.2, inertia=1e-3, position=(1.0, 0.0))
    scene.weld(rod.end, body.origin)
    return scene, plans.position(rod.end)


def _twisted(of: Discretization) -> Built:
    scene = Scene((0.0, 0.0, 0.0))
    beam = of.beam(scene, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (Rectangle(0.1, 0.1), FLEXIBLE[1]))
    scene.clamp(beam.start)
    scene.point_moment(beam.end, Ramp((400.0, 0.0, 100.0), 0.2, smooth=True))
    scene.point_force(beam.end, Ramp((0.0, 300.0, 0.0), 0.2, smooth=True))
    return scene, plans.position(beam.end)


def _whirled(of: Discretization) -> Built:
    scene = Scene(DOWN_IN_SPACE)
    rod = of.beam(scene, (0.0, 0.0, 0.0), (1.0, 0.0, 0.0), ROD, velocity=_around)
    scene.pin(rod.start)
    return scene, plans.position(rod.end)


def _around(x: Any) -> Any:
    return x[:, [1, 0, 2]] * (-3.0, 3.0, 0.0)


def _rope(of: Discretization) -> Built:
    """Build a rope of 20 m that is shaken at its top, with short waves."""
    scene = Scene(DOWN)
    rope = of.beam(scene, (0.0, 0.0), (0.0, -20.0), (Circle(0.02), Material(1e8, 1000.0)))
    scene.drive(rope.start, lambda t: (0.3 * (t / (1.0 + t)) ** 4 * math.sin(3.0 * t), 0.0))
    return scene, plans.position(rope.end)


def _tied(lines: int) -> Callable[[Discretization], Built]:
    """Build taut lines that cross, tied and pinned at their ends, and are pulled across."""

    def build(of: Discretization) -> Built:
        scene = Scene((0.0, 0.0, 0.0))
        profile = Circle(0.002), Material(1e9, 1000.0)
        shares = [(k + 0.5) / lines for k in range(lines)]
        beams: tuple[list[Any], list[Any]] = ([], [])
        for x in shares:
            ends = ((0.0, x, 0.0), (1.0, x, 0.0)), ((x, 0.0, 0.0), (x, 1.0, 0.0))
            for side, (start, end) in zip(beams, ends, strict=True):
                side.append(of.beam(scene, start, end, profile, tension=20.0))
                scene.pin(side[-1].start)
                scene.pin(side[-1].end)
        for one, y in zip(beams[0], shares, strict=True):
            for other, x in zip(beams[1], shares, strict=True):
                scene.connect(one.at(x * one.length), other.at(y * other.length))
        line = beams[0][lines // 2]
        middle = line.at(0.5 * line.length)
        scene.point_force(middle, Ramp((0.0, 0.0, -2.0), 0.1, smooth=True))
        return scene, plans.position(middle)

    return build


def _hanging(of: Discretization) -> Built:
    """Build ten links in space that hang, and whose top moves in a circle."""
    scene = Scene(DOWN_IN_SPACE)
    before = None
    for k in range(10):
        link = of.beam(scene, (0.0, 0.0, -0.4 * k), (0.0, 0.0, -0.4 * (k + 1)), ROD)
        if before is None:
            scene.drive(link.start, _circle)
        else:
            scene.connect(before, link.start)
        before = link.end
    return scene, plans.position(link.end)


def _circle(t: float) -> tuple[float, float, float]:
    r = 0.2 * (t / (1.0 + t)) ** 3
    return r * math.cos(4.0 * t), r * math.sin(4.0 * t), 0.0


def _wave(t: float) -> tuple[float, float]:
    return 0.0, 0.3 * math.sin(8.0 * t)


CASES: dict[str, Case] = {
    "pendulum": Case(_pendulum(SOFT_ROD), 2.0),
    "pendulum, 10 s": Case(_pendulum(FLEXIBLE), 10.0),
    "steel pendulum": Case(_pendulum(STEEL), 2.0),
    "pendulum in space": Case(_pendulum(ROD, 3), 2.0, THIN),
    "whirled in space": Case(_whirled, 1.0, THIN),
    "velocity of a pendulum": Case(
        _pendulum(FLEXIBLE, quantity_of=plans.velocity), 2.0, steps=25600
    ),
    "slope of a pendulum": Case(
        _pendulum(FLEXIBLE, quantity_of=plans.slope_angle), 2.0, steps=25600
    ),
    "energy of a pendulum": Case(
        _pendulum(FLEXIBLE, quantity_of=lambda end: plans.energy("kinetic")), 2.0
    ),
    "cantilever, sudden load": Case(_cantilever(FLEXIBLE, (0.0, 0.2)), 2.0, steps=25600),
    "cantilever, pulse": Case(
        _cantilever(FLEXIBLE, Pulse((0.0, 2.0), 0.0, 0.05)), 0.5, steps=25600
    ),
    "cantilever, wave": Case(_cantilever(FLEXIBLE, _wave), 5.0),
    "moment at a clamp": Case(
        _cantilever(
            FLEXIBLE, Ramp((0.0, 0.5), 0.2, smooth=True), root=True, quantity_of=plans.section_force
        ),
        1.0,
    ),
    "short beam": Case(
        _cantilever((Rectangle(0.3, 0.3), FLEXIBLE[1]), Ramp((0.0, 1e5), 0.02, smooth=True)),
        0.05,
        THICK,
        128,
    ),
    "twisted short beam": Case(_twisted, 0.4, (("thick", SHEARED),), 96),
    "two links": Case(_chain(2), 1.5),
    "three stiff links": Case(_chain(3, FLEXIBLE), 1.5),
    "two links in space": Case(_chain(2, ROD, 3), 1.5, THIN),
    "sagging line": Case(_line((Circle(0.01), Material(1e7, 1000.0)), length=1.1), 1.0),
    "taut line": Case(
        _line(
            (Circle(0.002), Material(1e9, 1000.0)),
            Ramp((0.0, -1.0), 0.05, smooth=True),
            tension=20.0,
        ),
        0.1,
        (("thin", {}), ("string", {})),
    ),
    "shaken rod": Case(_shaken, 3.0, steps=25600),
    "mass at the end": Case(_loaded(0.5, 0.0), 2.0),
    "spring at the end": Case(_loaded(0.0, 50.0), 2.0, steps=25600),
    "body at the end": Case(_with_body, 1.0),
    "long rope": Case(_rope, 8.0, THIN, 256, 25600, LONG_MESHES, False),
    "tied net": Case(_tied(5), 0.5, NET, 80, 6400, (10, 20, 30, 40, 60), False),
    "ten links in space": Case(_hanging, 8.0, THIN, 16, 51200, (1, 2, 3, 4, 6, 8), False),
    "pendulum, 60 s": Case(_pendulum(FLEXIBLE), 60.0, THIN, 32, 102400, (2, 4, 6, 8, 12), False),
    "deflection": Case(
        _cantilever(FLEXIBLE, None, quantity_of=plans.static_deflection, gravity=DOWN), None
    ),
    "large deflection": Case(
        _cantilever(FLEXIBLE, (0.0, -5.0), quantity_of=plans.static_deflection), None
    ),
}
"""Scenes by name: soft and stiff, in the plane and in space, short and long, at rest and moving."""
