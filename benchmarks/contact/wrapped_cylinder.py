"""A cable wrapped around a rotating cylinder: normal force and friction against formulas.

This is the last system of the paper.  The surface slides along circles below the entire cable, so
friction has no axial component: the axial component of the tension is constant, and the one around
the cylinder grows by exp(mu phi).  The normal force per length is the tension times the
curvature of the cable, and friction is mu times as much.
"""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from ancfsparse.array_types import Vector
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.nonlinear import QuasiNewton
from ancfsparse.problems.contacts import DRUM_RADIUS, WIRE_RADIUS, capstan
from ancfsparse.scene.force_elements.contacts import Contact
from ancfsparse.solve import simulate
from benchmarks.common.charts import new_figure, panels, set_axes, set_legend
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table

FRICTIONS = (0.1, 0.3, 0.5)  # coefficients [-]
ANGLES = (90.0, 180.0, 540.0)  # in the plane [degrees]
HELICES = ((0.1, 720.0), (0.1, 1080.0), (0.2, 720.0), (0.2, 1080.0), (0.3, 720.0))
"""Coefficients and angles in space [-], [degrees]."""
PITCH = 0.1  # in space, at the end with the smaller tension [m]
SPEEDS = (2.0, -2.0)  # of the drum, towards the fixed end and away from it [rad/s]
TENSION = 10.0  # at the pulled end [N]
ELEMENT_ANGLE = 3.6  # of an element [degrees]
DT = 1e-3  # [s]
T_END = 0.3  # [s]
MEAN_RATIO = 1.0 / 3.0  # last part of a run for its mean tension, since waves run along the cable
N_MARKS = 25  # of a curve of the chart
REACH = DRUM_RADIUS + WIRE_RADIUS
COLOURS = {0.1: "#0072b2", 0.2: "#cc79a7", 0.3: "#009e73", 0.5: "#d55e00"}


@dataclass(frozen=True)
class Wrap:
    """A run, and the forces at its end."""

    mu: float
    angle: float  # [degrees]
    turning: float  # [rad/s]
    pitch: float  # at the pulled end, zero in the plane [m]
    ratio: float  # of the tensions of both ends [-]
    iterations: float  # per step [-]
    seconds: float  # of the run [s]
    polar_angle: Vector = field(repr=False)  # angle from the fixed end, (n,) [degrees]
    pressure: Vector = field(repr=False)  # (n,) [N/m]
    friction: Vector = field(repr=False)  # (n,) [N/m]

    @property
    def exponent(self) -> float:
        """Exponent of the ratio of tensions around the cylinder [-]."""
        return math.copysign(self.mu, self.turning) * math.radians(self.angle)

    @property
    def exact_ratio(self) -> float:
        """Exact ratio of tensions [-]."""
        around, axial = self._direction
        return math.hypot(around * math.exp(self.exponent), axial)

    @property
    def _direction(self) -> tuple[float, float]:
        """Components of the unit tangent at the pulled end, around and along the axis [-]."""
        slope = self.pitch / (2.0 * math.pi * REACH)
        return 1.0 / math.hypot(1.0, slope), slope / math.hypot(1.0, slope)

    @property
    def error(self) -> float:
        """Relative error of the ratio of tensions [-]."""
        return self.ratio / self.exact_ratio - 1.0

    @property
    def exact_pressure(self) -> Vector:
        """Normal force per length without bending, (n,) [N/m]."""
        first_around, axial = self._direction
        rest = self.exponent * (1.0 - self.polar_angle / self.angle)
        around = first_around * np.exp(rest)
        # The cable has the curvature of the circle times (around / tension)^2.
        return np.asarray(TENSION * around**2 / np.hypot(around, axial) / REACH)

    @property
    def pressure_error(self) -> float:
        """Median of the relative errors of the pressure along the arc [-]."""
        return float(np.median(np.abs(self.pressure / self.exact_pressure - 1.0)))

    @property
    def friction_error(self) -> float:
        """Median of the relative differences between friction and mu times the pressure [-]."""
        pressed = self.pressure > 0.0
        friction = self.friction[pressed] / (self.mu * self.pressure[pressed])
        return float(np.median(np.abs(friction - 1.0)))

    def record(self) -> dict[str, float]:
        """Return the entries of the CSV table."""
        names = (
            "mu",
            "angle",
            "turning",
            "pitch",
            "ratio",
            "error",
            "pressure_error",
            "friction_error",
        )
        return {name: getattr(self, name) for name in (*names, "iterations", "seconds")}


def wrapped_cylinder(progress: bool = False) -> list[Wrap]:
    """Compare a cable around a rotating cylinder with the formula of Euler and Eytelwein."""
    planar = [(mu, angle, 0.0) for mu, angle in itertools.product(FRICTIONS, ANGLES)]
    spatial = [(mu, angle, PITCH) for mu, angle in HELICES]
    cases = [(*case, turning) for case in planar + spatial for turning in SPEEDS]
    return [_run(*case) for case in bar(cases, "run", progress)]


def _run(mu: float, angle: float, largest_pitch: float, turning: float) -> Wrap:
    decay = min(math.copysign(mu, turning) * math.radians(angle), 0.0)
    pitch = largest_pitch * math.exp(decay)
    n_elements = round(angle / ELEMENT_ANGLE)
    case = capstan(mu, angle, TENSION, turning=turning, n_elements=n_elements, pitch=pitch)
    begin = time.process_time()
    run = simulate(
        case.scene,
        T_END,
        DT,
        integrator=GeneralizedAlpha(0.5),
        solver=QuasiNewton("broyden", memory=20, max_iterations=60),
    )
    seconds = time.process_time() - begin
    tensions = case.quantities(run)["t2"]
    tension = float(tensions[-round(MEAN_RATIO * len(tensions)) :].mean())
    contacts = [each for each in case.scene.attachments if isinstance(each, Contact)]
    contact = contacts[1]  # of the arc, between both ends
    force = run.contact_force(contact).at(-1)
    x, y = np.array([run.position(point)[-1, :2] for point in contact.points]).T
    return Wrap(
        mu,
        angle,
        turning,
        pitch,
        tension / TENSION,
        run.stats.iterations / run.stats.steps,
        seconds,
        np.degrees(np.unwrap(np.arctan2(y, -x))),
        force.pressure,
        np.linalg.norm(force.friction, axis=1),
    )


def table(wraps: Sequence[Wrap]) -> Table:
    """Set the ratios of tensions and their errors."""
    columns = {
        "mu": lambda each: f"{each.mu:g}",
        "angle [deg]": lambda each: f"{each.angle:g}",
        "cable": lambda each: "in space" if each.pitch else "planar",
        "drum": lambda each: "tightens" if each.turning > 0.0 else "loosens",
        "T2/T1": lambda each: f"{each.ratio:.6g}",
        "theory": lambda each: f"{each.exact_ratio:.6g}",
        "error": lambda each: f"{each.error:.1e}",
        "error of pressure": lambda each: f"{each.pressure_error:.1e}",
        "iterations": lambda each: f"{each.iterations:.1f}",
    }
    return Table.of(wraps, columns, left=(2, 3))


def findings(wraps: Sequence[Wrap]) -> list[str]:
    """State the largest errors, in the plane and in space."""
    lines = []
    for name, some in (
        ("planar cables", [each for each in wraps if not each.pitch]),
        ("cables in space", [each for each in wraps if each.pitch]),
    ):
        if not some:
            continue
        worst = max(some, key=lambda each: abs(each.error))
        along = max(some, key=lambda each: each.pressure_error)
        lines += [
            f"The largest error of a ratio of tensions of {name} is {abs(worst.error):.1e}, for mu "
            f"= {worst.mu:g} and {worst.angle:g} degrees",
            f"The largest median error of the pressure along {name} is {along.pressure_error:.1e}, "
            f"for mu = {along.mu:g} and {along.angle:g} degrees",
        ]
    sliding = max(each.friction_error for each in wraps)
    dearest = max(wraps, key=lambda each: each.iterations)
    return [
        *lines,
        "The largest median relative difference between friction and mu times the pressure is "
        f"{sliding:.0e}",
        f"The mean number of iterations per step is at most {dearest.iterations:.0f}, for mu = "
        f"{dearest.mu:g} and {dearest.angle:g} degrees",
    ]


def chart(wraps: Sequence[Wrap]) -> Figure:
    """Draw normal force and friction along the longest arcs, with lines for the formulas."""
    longest = {
        (each.mu, each.turning, each.pitch > 0.0): each
        for each in sorted(wraps, key=lambda each: each.angle)
    }
    shapes = sorted({is_spatial for *_, is_spatial in longest})
    figure = new_figure(
        3.0 + 2.2 * (len(shapes) - 1),
        "Cable around a rotating cylinder: forces per length along the arc",
    )
    lines: dict[str, Any] = {}
    rows = list(itertools.product(shapes, SPEEDS))
    for ax, (is_spatial, turning) in zip(panels(figure, len(rows), 2), rows, strict=True):
        some = [w for key, w in longest.items() if key[1:] == (turning, is_spatial)]
        for wrap in some:
            colour = COLOURS[wrap.mu]
            (line,) = ax.plot(wrap.polar_angle, wrap.exact_pressure, "-", color=colour)
            ax.plot(wrap.polar_angle, wrap.mu * wrap.exact_pressure, "-", color=colour)
            every = max(len(wrap.polar_angle) // N_MARKS, 1)
            marked = slice(every // 2, None, every)
            angles = wrap.polar_angle[marked]
            (normal,) = ax.plot(angles, wrap.pressure[marked], "o", color=colour, markersize=4)
            (tangential,) = ax.plot(angles, wrap.friction[marked], "x", color=colour, markersize=5)
            lines |= {f"mu = {wrap.mu:g}, formula": line}
            marks = {"normal force": normal, "friction": tangential}
        title = f"{'in space' if is_spatial else 'planar'}, the cylinder "
        title += "tightens it" if turning > 0.0 else "loosens it"
        set_axes(ax, "angle from the fixed end [degrees]", "[N/m]", log="y", title=title)
    set_legend(figure, marks | dict(sorted(lines.items())), 3)
    return figure


STUDY = Study(
    "wrapped-cylinder",
    run=wrapped_cylinder,
    tables=lambda wraps: [table(wraps)],
    rows=lambda wraps: [each.record() for each in wraps],
    record=lambda wraps: [each.record() for each in wraps],
    findings=findings,
    charts={"wrapped-cylinder": chart},
    regions={"wrapped-cylinder": table},
)
