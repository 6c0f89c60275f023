"""The present state of a motion that is advanced step by step, and results of it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.integrators.interface.time_grid import TimeGrid
from ancfsparse.results import RunStats, Trajectory, export
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.results.solutions.solution import SingleState
from ancfsparse.scene import Point
from ancfsparse.scene.joints.joint import check_point
from ancfsparse.solve.motion.fixed_step_run import FixedStepRun
from ancfsparse.system.coordinates.state import StateHistory

if TYPE_CHECKING:
    from ancfsparse.results.export import LiveView
    from ancfsparse.results.fields.contact_table import ContactTable
    from ancfsparse.results.fields.rigid_body_motion import BodyMotion
    from ancfsparse.scene.bodies.rigid_body import RigidBody


REMEMBERED_POINTS = 1000  # finding a point takes longer than a step of ten elements


@dataclass(frozen=True)
class Punctuality:
    """Report of a simulation in real time.

    Attributes
    ----------
    steps : int
        Number of steps.
    missed : int
        Number of steps that ended late.
    latest : float
        Largest delay [s].
    """

    steps: int
    missed: int
    latest: float


class StepCall:
    """A function that a simulation calls with itself after every few steps."""

    def __init__(self, follow: Callable[[Any], object], every: int) -> None:
        self.follow, self.every = follow, every


class PresentState(SingleState):
    """Results of the present state of a run, without a time axis."""

    _calls: list[StepCall | LiveView]
    _next_call: int  # number of the step after which one of them is due
    _busy: AbstractContextManager[object]

    _run: FixedStepRun
    _clock: TimeGrid
    _settings: dict[str, Any]

    @property
    def steps(self) -> int:
        """Number of steps taken."""
        return self._run.steps

    @property
    def t(self) -> float:
        """Present time [s]."""
        return float(self._clock.at(self.steps))

    @property
    def q(self) -> Vector:  # type: ignore[override]  # not to be set
        """Coordinates, (n,) [m for positions, 1 for slopes]."""
        return self._run.state[0]

    @property
    def stats(self) -> RunStats:
        """Operation counts and times of all steps."""
        return self._run.count()

    @property
    def _states(self) -> StateHistory:
        q, v, a, lam = (table[None] for table in self._run.state)
        return StateHistory(q, v, a, lam, np.array([self.t]), self.system.assembly.history[None])

    def _trajectory(self) -> Trajectory:
        q, v, a, lam, t, history = self._states
        stats, settings = self.stats, self._settings
        return Trajectory(self.system, t, q, v, a, lam, stats, settings, None, history)

    @property
    def _states_of_forces(self) -> StateHistory:
        return self._trajectory()._states_of_forces

    @property
    def multipliers(self) -> Vector:
        """Lagrange multipliers of the constraints, (m,)."""
        return self._run.state[3]

    @cached_property
    def _points(self) -> Callable[[Point], tuple[Integers, Vector]]:
        return lru_cache(maxsize=REMEMBERED_POINTS)(self.system.point)

    def _point(self, node: Point) -> tuple[Integers, Vector]:
        """Return indices and weights of a point, which a controller reads in every step."""
        return self._points(check_point("a position", node))

    def position(self, node: Point) -> Vector:
        """Return the position of a point, (dim,) [m]."""
        return interpolate(self._point(node), self.q)

    def velocity(self, node: Point) -> Vector:
        """Return the velocity of a point, (dim,) [m/s]."""
        return interpolate(self._point(node), self._run.state[1])

    def acceleration(self, node: Point) -> Vector:
        """Return the acceleration of a point, (dim,) [m/s2]."""
        return interpolate(self._point(node), self._run.state[2])

    def contacts(self) -> ContactTable:
        """Return the places that touch, as `Trajectory.contacts` does."""
        return self._trajectory().contacts()

    def body(self, body: RigidBody) -> BodyMotion:
        """Return the motion of a rigid body, as `Trajectory.body` does, with arrays of one row."""
        return self._trajectory().body(body)

    def view(self, *, fps: int = 25, port: int = 0, browser: bool = False) -> LiveView:
        """Show the simulation in a browser while it is stepped.

        Parameters
        ----------
        fps : int, optional
            Frames per second by the clock, at most.  Frames take at most 10 % of the time of the
            simulation, and none while no page is open.
        port : int, optional
            Port of the server on 127.0.0.1; by default any that is free.
        browser : bool, optional
            Open the page in the browser of this computer.

        Returns
        -------
        LiveView
            It has the address of the page, `url`, and `close()`, and is a context manager.  In a
            notebook on this computer it is shown as the page.

        Raises
        ------
        InputError
            If an argument is invalid, the scene has no bodies, or the port is in use.

        Notes
        -----
        Only programs of this computer that know the address can see the page, which ends with the
        simulation.
        """
        live = export.LiveView(self, fps, port, browser=browser)
        self._add_call(live)
        return live

    def _add_call(self, call: StepCall | LiveView) -> None:
        self._calls.append(call)
        self._next_call = 0  # to be determined
