"""Scenes with ``"auto"`` elements and meshes, chosen by a plan for the position of a point."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ancfsparse.problems.benchmarks import pendulum
from ancfsparse.scene import Beam, Circle, Material, Point, Rectangle, Scene

N_LINES = 5  # of the net in each direction
SPACING = 0.2  # of the lines [m]


class AutoScene(NamedTuple):
    """A scene and a quantity of interest.

    Attributes
    ----------
    scene : Scene
        Its beams have ``element="auto"`` and ``n_elements="auto"``.
    point : Point
        Point whose position is the quantity of interest.
    t_end : float or None
        End time [s]; None for the equilibrium.
    error : str
        Default tolerance, as in `ancfsparse.plan`, or a number [m].
    """

    scene: Scene
    point: Point
    t_end: float | None
    error: str


def open_pendulum() -> AutoScene:
    """Set up the paper's pendulum for two seconds, with a tolerance of 1 mm at its tip."""
    scene, rod = pendulum("auto", "auto")
    return AutoScene(scene, rod.end, 2.0, "1e-3")


def open_twisted() -> AutoScene:
    """Set up a short beam of rubber that is bent and twisted at its end.

    A clamped beam of 0.3 m with a section of 6 by 3 cm, 1e7 Pa and 1000 kg/m3, under a force of
    (0, -2, 1) N and a moment of 0.2 N m about its axis.
    """
    scene = Scene((0.0, 0.0, 0.0))
    rubber = Material(1e7, 1000.0, 0.3)
    rod = scene.add_beam("auto", (0, 0, 0), (0.3, 0, 0), "auto", Rectangle(0.06, 0.03), rubber)
    scene.clamp(rod.start)
    scene.point_force(rod.end, (0.0, -2.0, 1.0))
    scene.point_moment(rod.end, (0.2, 0.0, 0.0))
    return AutoScene(scene, rod.end, 0.1, "1 %")


def open_line() -> AutoScene:
    """Set up a line of 1.2 m between two pins 1 m apart, for its equilibrium."""
    scene = Scene()
    rope = Material(1e9, 1000.0)
    line = scene.add_beam("auto", (0, 0), (1, 0), "auto", Circle(0.002), rope, length=1.2)
    scene.pin(line.start)
    scene.pin(line.end)
    scene.point_force(line.at(0.4), (0.0, -0.02))
    return AutoScene(scene, line.at(0.4), None, "1e-3")


def open_net() -> AutoScene:
    """Set up a square net of taut lines under its weight, for the position of its middle.

    Five lines of 1 m each way, 2 mm thick, 1e9 Pa and 1000 kg/m3, under 20 N, tied where they
    cross and pinned at their ends, with 9.81 m/s2 across.
    """
    scene = Scene((0.0, 0.0, -9.81))
    rope, section = Material(1e9, 1000.0), Circle(0.002)
    positions = SPACING * (np.arange(N_LINES) + 0.5)
    length = N_LINES * SPACING
    along: list[Beam] = []
    across: list[Beam] = []
    for x in positions.tolist():
        ends = ((0.0, x, 0.0), (length, x, 0.0)), ((x, 0.0, 0.0), (x, length, 0.0))
        for lines, (start, end) in zip((along, across), ends, strict=True):
            lines.append(scene.add_beam("auto", start, end, "auto", section, rope, tension=20.0))
            scene.pin(lines[-1].start)
            scene.pin(lines[-1].end)
    fractions = (positions / length).tolist()
    for one, y in zip(along, fractions, strict=True):
        for other, x in zip(across, fractions, strict=True):
            scene.connect(one.at(x * one.length), other.at(y * other.length))
    middle = along[N_LINES // 2]
    return AutoScene(scene, middle.at(0.5 * middle.length), 0.2, "10 %")


def open_pull() -> AutoScene:
    """Set up a slack cable, one end of which is pulled away by 8 cm in 20 s.

    It is 1.1 m long between points 1 m apart, 5 mm thick, of 1e8 Pa and 1000 kg/m3, under gravity;
    the quantity of interest is its middle.
    """
    scene = Scene()
    rope = scene.add_beam(
        "auto", (0, 0), (1, 0), "auto", Circle(0.005), Material(1e8, 1000.0), length=1.1
    )
    scene.pin(rope.start)
    scene.drive(rope.end, lambda t: (1.0 + 0.08 * (t / 20.0) ** 2 * (3.0 - t / 10.0), 0.0))
    return AutoScene(scene, rope.at(0.55), 20.0, "5 %")


def open_whip() -> AutoScene:
    """Set up a soft rod of 1 m at the end of a link of steel of 0.2 m that swings, for its tip.

    The link is 5 cm thick, of 2e11 Pa and 7800 kg/m3, the rod 1 cm, of 1e9 Pa and 1000 kg/m3; both
    begin at rest, level.
    """
    scene = Scene()
    link = scene.add_beam("auto", (0, 0), (0.2, 0), "auto", Circle(0.05), Material(2e11, 7800.0))
    rod = scene.add_beam("auto", (0.2, 0), (1.2, 0), "auto", Circle(0.01), Material(1e9, 1000.0))
    scene.pin(link.start)
    scene.connect(link.end, rod.start)
    return AutoScene(scene, rod.end, 0.5, "1 %")


def open_twang() -> AutoScene:
    """Set up a thin cantilever under a sudden small force for two minutes, for its tip.

    It is 1 m long and 4 mm thick, of 1e9 Pa and 1000 kg/m3; the force of 50 uN moves it by 2.7 mm.
    """
    scene = Scene((0.0, 0.0))
    rod = scene.add_beam("auto", (0, 0), (1, 0), "auto", Circle(0.004), Material(1e9, 1000.0))
    scene.clamp(rod.start)
    scene.point_force(rod.end, (0.0, -5e-5))
    return AutoScene(scene, rod.end, 120.0, "1 %")


AUTO_SCENES = {
    "pendulum": open_pendulum,
    "twisted": open_twisted,
    "line": open_line,
    "net": open_net,
    "pull": open_pull,
    "whip": open_whip,
    "twang": open_twang,
}
"""Scenes by the names of the command `ancfsparse plan`."""
