"""A cable wrapped around a rotating cylinder: normal force and friction against formulas.

This is the last system of the paper.  Where the cable slides everywhere, its tension is
T exp(mu phi), and the forces per length on it are that over the radius, and mu times as much.
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
ANGLES = (90.0, 180.0, 540.0)  # [degrees]
SPEEDS = (2.0, -2.0)  # of the drum, towards the fixed end and away from it [rad/s]
TENSION = 10.0  # at the pulled end [N]
ELEMENT_ANGLE = 3.6  # of an element [degrees]
DT = 1e-3  # [s]
T_END = 0.3  # [s]
N_MEAN = 100  # last steps that the tension is a mean of: waves run along the wire
REACH = DRUM_RADIUS + WIRE_RADIUS
COLOURS = dict(zip(FRICTIONS, ("#0072b2", "#009e73", "#d55e00"), strict=True))


@dataclass(frozen=True)
class Wrap:
    """A run, and the forces at its end."""

    mu: float
    angle: float  # [degrees]
    turning: float  # [rad/s]
    ratio: float  # of the tensions of both ends [-]
    iterations: float  # per step [-]
    seconds: float  # of the run [s]
    polar_angle: Vector = field(repr=False)  # angle from the fixed end, (n,) [degrees]
    pressure: Vector = field(repr=False)  # (n,) [N/m]
    friction: Vector = field(repr=False)  # (n,) [N/m]

    @property
    def exponent(self) -> float:
        """Exponent of the exact ratio of tensions [-]."""
        return math.copysign(self.mu, self.turning) * math.radians(self.angle)

    @property
    def error(self) -> float:
        """Relative error of the ratio of tensions [-]."""
        return self.ratio / math.exp(self.exponent) - 1.0

    @property
    def exact_pressure(self) -> Vector:
        """Normal force per length without bending, (n,) [N/m]."""
        rest = self.exponent * (1.0 - self.polar_angle / self.angle)
        return np.asarray(TENSION / REACH * np.exp(rest))

    @property
    def pressure_error(self) -> float:
        """Median of the relative errors of the pressure along the arc [-]."""
        return float(np.median(np.abs(self.pressure / self.exact_pressure - 1.0)))

    @property
    def friction_error(self) -> float:
        """Largest relative difference between friction and mu times the pressure [-]."""
        return float(np.max(np.abs(self.friction / (self.mu * self.pressure) - 1.0)))

    def record(self) -> dict[str, float]:
        """Return the entries of the CSV table."""
        names = ("mu", "angle", "turning", "ratio", "error", "pressure_error", "friction_error")
        return {name: getattr(self, name) for name in (*names, "iterations", "seconds")}


def wrapped_cylinder(progress: bool = False) -> list[Wrap]:
    """Compare a cable around a rotating cylinder with the formula of Euler and Eytelwein."""
    cases = list(itertools.product(FRICTIONS, ANGLES, SPEEDS))
    return [_run(*case) for case in bar(cases, "run", progress)]


def _run(mu: float, angle: float, turning: float) -> Wrap:
    case = capstan(mu, angle, TENSION, turning, n_elements=round(angle / ELEMENT_ANGLE))
    begin = time.process_time()
    run = simulate(
        case.scene,
        T_END,
        DT,
        integrator=GeneralizedAlpha(0.5),
        solver=QuasiNewton("broyden", memory=20, max_iterations=60),
    )
    seconds = time.process_time() - begin
    tension = float(case.quantities(run)["held"][-N_MEAN:].mean())
    contacts = [each for each in case.scene.attachments if isinstance(each, Contact)]
    force = run.contact_force(contacts[1]).at(-1)  # of the arc, between both ends
    return Wrap(
        mu,
        angle,
        turning,
        tension / TENSION,
        run.stats.iterations / run.stats.steps,
        seconds,
        np.degrees(force.s / REACH),
        force.pressure,
        np.linalg.norm(force.friction, axis=1),
    )


def table(wraps: Sequence[Wrap]) -> Table:
    """Set the ratios of tensions and their errors."""
    columns = {
        "mu": lambda each: f"{each.mu:g}",
        "angle [deg]": lambda each: f"{each.angle:g}",
        "drum": lambda each: "tightens" if each.turning > 0.0 else "loosens",
        "T2/T1": lambda each: f"{each.ratio:.6g}",
        "exp(+-mu phi)": lambda each: f"{math.exp(each.exponent):.6g}",
        "error": lambda each: f"{each.error:.1e}",
        "error of pressure": lambda each: f"{each.pressure_error:.1e}",
        "iterations": lambda each: f"{each.iterations:.1f}",
    }
    return Table.of(wraps, columns, left=(2,))


def findings(wraps: Sequence[Wrap]) -> list[str]:
    """State the largest errors."""
    worst = max(wraps, key=lambda each: abs(each.error))
    along = max(wraps, key=lambda each: each.pressure_error)
    sliding = max(each.friction_error for each in wraps)
    dearest = max(wraps, key=lambda each: each.iterations)
    return [
        f"The largest error of a ratio of tensions is {abs(worst.error):.1e}, for mu = "
        f"{worst.mu:g} and {worst.angle:g} degrees",
        f"The largest median error of the pressure along an arc is {along.pressure_error:.1e}, for "
        f"mu = {along.mu:g} and {along.angle:g} degrees; the formula neglects that "
        "the wire is stretched, and its points move along the arc",
        f"Friction is mu times the pressure to {sliding:.0e}",
        f"The mean number of iterations per step is at most {dearest.iterations:.0f}, for mu = "
        f"{dearest.mu:g} and {dearest.angle:g} degrees",
    ]


def chart(wraps: Sequence[Wrap]) -> Figure:
    """Draw normal force and friction along the longest arcs, with lines for the formulas."""
    figure = new_figure(3.8, "Cable around a rotating cylinder: forces per length along the arc")
    keys: dict[str, Any] = {}
    for ax, turning in zip(panels(figure, 2, 2), SPEEDS, strict=True):
        for wrap in wraps:
            if wrap.angle < max(ANGLES) or wrap.turning != turning:
                continue
            colour, some = COLOURS[wrap.mu], slice(None, None, 12)
            (line,) = ax.plot(wrap.polar_angle, wrap.exact_pressure, "-", color=colour)
            ax.plot(wrap.polar_angle, wrap.mu * wrap.exact_pressure, "-", color=colour)
            angles = wrap.polar_angle[some]
            (normal,) = ax.plot(angles, wrap.pressure[some], "o", color=colour, markersize=4)
            (tangential,) = ax.plot(angles, wrap.friction[some], "x", color=colour, markersize=5)
            keys |= {f"mu = {wrap.mu:g}, formula": line}
        keys |= {"normal force": normal, "friction": tangential}
        title = "tightens the wire" if turning > 0.0 else "loosens the wire"
        set_axes(ax, "angle from the fixed end [degrees]", "[N/m]", log="y", title=title)
    set_legend(figure, keys, 5)
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
