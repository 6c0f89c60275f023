"""Belt drives: tensions, creep and slip arcs, the moment at slip, and convergence in the step."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import root

from ancfsparse.array_types import Vector
from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.problems import belt_drive, belt_drive_pechstein
from ancfsparse.solve import simulate
from benchmarks.contact.references.comparison import (
    Comparison,
    compare_absolute,
    compare_relative,
    limit_above,
    limit_below,
)

LOADS = (5.0, 10.0)  # of the driven pulley [N m]
T_END = 0.3  # [s]
MEAN_START = 0.2  # from which on speeds and tensions are steady [s]
DT = 1e-4  # [s]
TENSION_TOLERANCE = 5e-3  # [-]
LOSS_TOLERANCE = 0.02  # of the loss of speed [-]
ARC_TOLERANCE = 10.0  # [degrees]
SLIP_MOMENT = 17.24492  # at which the belt slides on the entire arc [N m]
SLIP_TOLERANCE = 0.02  # of this moment [-]
SLIP_ELEMENTS = 60  # of the belt
SLIP_RATIO = 0.9  # of angular velocities at the end and before: a pulley that slips slows down
PUBLISHED_END = 2.45  # of the published run [s]
PUBLISHED_STEPS = (1e-3, 5e-5)  # [s]
PUBLISHED_TOLERANCE = 0.02  # of the tension of each element at each time [-]
DAMPED = GeneralizedAlpha(0.5)


@dataclass(frozen=True)
class BeltTheory:
    """A belt that creeps around two equal pulleys, by Euler and Eytelwein.

    A belt of the strain T/EA moves with c0 (1 + T/EA), and the driver has the speed of the tight
    span, the driven pulley the speed of the slack span.  T (1 - G/EA) - G, with G = m c0^2, presses
    on the pulleys, and grows by exp(mu phi) on the arc before the exit of either pulley.
    """

    moment: Callable[[float], float]  # on the driven pulley, of its angular velocity [N m]
    omega: float = 100.0  # of the driver [rad/s]
    friction: float = 0.3
    axial_stiffness: float = 2e4  # [N]
    mass: float = 0.1  # [kg/m]
    strain: float = 0.01  # at the start [-]
    distance: float = 0.4  # of the axes of the pulleys [m]
    radius: float = 0.1  # [m]

    def solve(self) -> tuple[float, float, float, float]:
        """Return both tensions [N], the driven pulley's speed [rad/s] and slip arc [degrees]."""
        mean = self.axial_stiffness * self.strain
        tight, slack = root(self._residuals, (1.3 * mean, 0.7 * mean), tol=1e-12).x
        omega, arc, _ = self._state(tight, slack)
        return float(tight), float(slack), omega, math.degrees(arc)

    def _state(self, tight: float, slack: float) -> tuple[float, float, tuple[float, float]]:
        """Return the speed [rad/s], the slip arc [rad] and the parts that press [N]."""
        ea = self.axial_stiffness
        feed = self.radius * self.omega / (1.0 + tight / ea)
        flow = self.mass * feed**2
        high, low = (tension * (1.0 - flow / ea) - flow for tension in (tight, slack))
        omega = feed * (1.0 + slack / ea) / self.radius
        return omega, math.log(high / low) / self.friction, (high, low)

    def _residuals(self, tensions: Vector) -> tuple[float, float]:
        """Return the residuals of the moment [N m] and of the length without stress, times EA."""
        tight, slack = tensions
        ea, r = self.axial_stiffness, self.radius
        omega, arc, (high, low) = self._state(tight, slack)
        flow = self.mass * (r * self.omega / (1.0 + tight / ea)) ** 2
        # Integral of R / (1 + T/EA) over an arc on which T - G (1 + T/EA) grows exponentially.
        growth = math.log(high / (ea + high)) - math.log(low / (ea + low))
        sliding = 2.0 * r * (1.0 - flow / ea) / self.friction * growth
        sticking = self.distance + r * (math.pi - arc)
        length = sticking * (1.0 / (1.0 + tight / ea) + 1.0 / (1.0 + slack / ea)) + sliding
        total = 2.0 * (self.distance + math.pi * r) / (1.0 + self.strain)
        return r * (high - low) - self.moment(omega), ea * (length - total)


PUBLISHED = BeltTheory(
    lambda omega: 2.0 * omega + 25.0,
    omega=12.0,
    friction=0.5,
    axial_stiffness=0.95 * 8000.0,
    mass=0.8288 / 0.95,
    strain=1.0 / 0.95 - 1.0,
    distance=0.1 * math.pi,
)
"""The drive of Pechstein and Gerstmayr, whose belt has the strain |r'| - 0.95."""


def compare_drives() -> list[Comparison]:
    """Compare tensions, loss of speed and slip arcs of belt drives under load with creep theory."""
    rows = []
    for load in LOADS:
        tight, slack, omega, arc = BeltTheory(lambda _, load=load: load).solve()  # type: ignore[misc]
        case = belt_drive(load=load)
        run = simulate(case.scene, T_END, DT, integrator=DAMPED, save_every=10)
        values = case.quantities(run)
        mean = {name: float(v[run.t > MEAN_START].mean()) for name, v in values.items()}
        name, loss = f"belt drive, {load:g} N m", 1.0 - omega / 100.0
        rows += [
            compare_relative(f"{name}: tight [N]", mean["tight"], tight, TENSION_TOLERANCE),
            compare_relative(f"{name}: slack [N]", mean["slack"], slack, TENSION_TOLERANCE),
            compare_relative(f"{name}: loss of speed", mean["speed_loss"], loss, LOSS_TOLERANCE),
        ]
        rows += [
            compare_absolute(
                f"{name}: slip arc of the {pulley} [degrees]",
                mean[f"slip_arc_{pulley}"],
                arc,
                ARC_TOLERANCE,
            )
            for pulley in ("driver", "driven")
        ]
    return rows


def compare_slip() -> list[Comparison]:
    """Compare moments 2 % below and above the one at which the belt slides on the entire arc."""
    rows = []
    for sign, limit in ((-1.0, limit_below), (1.0, limit_above)):
        load = (1.0 + sign * SLIP_TOLERANCE) * SLIP_MOMENT
        case = belt_drive(load=load, n_elements=SLIP_ELEMENTS)
        run = simulate(case.scene, T_END, DT, integrator=DAMPED, save_every=10)
        speed = case.quantities(run)["w2"]
        name = f"belt drive, {load:.2f} N m: speed at 0.3 s over that at 0.2 s"
        rows.append(limit(name, speed[-1] / speed[run.t > MEAN_START][0], SLIP_RATIO))
    return rows


def compare_published_drive() -> list[Comparison]:
    """Compare Pechstein and Gerstmayr's drive with short steps at all times, and with theory."""
    tensions: list[Vector] = []
    last: dict[str, float] = {}
    for dt in PUBLISHED_STEPS:
        case = belt_drive_pechstein()
        every = round(PUBLISHED_STEPS[0] / dt)
        run = simulate(case.scene, PUBLISHED_END, dt, integrator=DAMPED, save_every=every)
        values = case.quantities(run)
        tensions.append(np.asarray(values["tension"]))
        if not last:
            last = {name: float(values[name][-1]) for name in ("tight", "slack", "w2")}
    difference = np.abs(tensions[0] / tensions[1] - 1.0).max()
    tight, slack, omega, _ = PUBLISHED.solve()
    name = "Pechstein's drive, 1 ms"
    return [
        limit_above(f"{name} and 0.05 ms: tensions", difference, PUBLISHED_TOLERANCE),
        compare_relative(f"{name}: tight [N]", last["tight"], tight, TENSION_TOLERANCE),
        compare_relative(f"{name}: slack [N]", last["slack"], slack, TENSION_TOLERANCE),
        compare_relative(f"{name}: driven pulley [rad/s]", last["w2"], omega, TENSION_TOLERANCE),
    ]
