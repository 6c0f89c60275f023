"""The motion computed by a simulation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.integrators import EnergyMomentum
from ancfsparse.results import fields, plotting
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.data.selected_columns import SelectedColumns
from ancfsparse.results.solutions.solution import Values
from ancfsparse.results.solutions.trajectory_output import TrajectoryOutput
from ancfsparse.scene import Beam, Point
from ancfsparse.system.coordinates.state import State, StateHistory
from ancfsparse.system.system import System

if TYPE_CHECKING:
    from ancfsparse.results.data.stored_tables import StoredState
    from ancfsparse.results.fields.contact_table import ContactTable
    from ancfsparse.results.fields.energy_balance import Energy
    from ancfsparse.results.fields.quantities import ValueRange
    from ancfsparse.results.fields.rigid_body_motion import BodyMotion
    from ancfsparse.scene.bodies.rigid_body import RigidBody


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(TrajectoryOutput):
    """Saved states of a run, including the initial state.

    Parameters
    ----------
    system : System
        The discrete system.
    t : ndarray, shape (k,)
        Times [s].
    q, v, a : ndarray, shape (k, n)
        Coordinates (m for positions, dimensionless for slopes), velocities and accelerations; for a
        run with ``output`` or ``save_nodes`` tables that are read like arrays.
    lam : ndarray, shape (k, m)
        Lagrange multipliers of the constraints; joints that eliminate coordinates have none.
    stats : RunStats
        Operation counts and times.
    settings : mapping, optional
        Arguments of the run.
    ending : State or StoredState, optional
        The last state with the data to continue the run, if available.
    internal : ndarray, shape (k, h), optional
        Internal variables of contacts: deflections of their bristles [m], and the energies that
        they have exchanged [J].
    """

    system: System
    t: Vector
    q: Vector
    v: Vector
    a: Vector
    lam: Vector
    stats: RunStats
    settings: Mapping[str, Any] = field(default_factory=dict)
    ending: State | StoredState | None = None
    internal: Vector = field(default_factory=lambda: np.empty((0, 0)))

    def __post_init__(self) -> None:
        """Let runs without internal variables have as many rows of none as states."""
        if not self.internal.shape[1]:
            object.__setattr__(self, "internal", np.empty((len(self.t), 0)))

    def __repr__(self) -> str:
        """Summarise the run in two lines, or three if contacts moved the initial state."""
        stats = self.stats
        return (
            f"Trajectory: {len(self.t)} states from t = {self.t[0]:.6g} s to {self.t[-1]:.6g} s, "
            f"{self.q.shape[1]} coordinates, {self.lam.shape[1]} multipliers\n  "
            + ("" if self.finished else f"unfinished: {self._aim}; ")
            + (
                f"{stats.steps} steps"
                + (f", {stats.short_steps} shorter ones" if stats.short_steps else "")
                + f", {stats.iterations_per_step:.2f} iterations per step, "
                f"{stats.factorizations} factorizations, {stats.march_seconds:.3g} s"
                if stats.steps or len(self.t) == 1
                else "interrupted, without operation counts"
            )
            + (f", {stats.method}" if stats.solver else "")
            + (f"\n  initial state: {moved}" if (moved := self.settings.get("moved")) else "")
        )

    @property
    def finished(self) -> bool:
        """True if the run reached its final time and the requested accuracy."""
        return self._ended and self._is_accurate

    @property
    def _is_accurate(self) -> bool:
        accuracy = self.settings.get("accuracy")
        return accuracy is None or self.stats.error <= accuracy

    @property
    def _ended(self) -> bool:
        t_end = self.settings.get("t_end")
        return t_end is None or bool(self.t[-1] >= t_end * (1.0 - 1e-9))

    @property
    def _aim(self) -> str:
        """Return the unfulfilled aim of an unfinished run."""
        if self._ended:
            error = f"the error is about {self.stats.error:.3g} m"
            return f"accuracy is {self.settings['accuracy']:.3g} m, {error}"
        return f"t_end is {self.settings['t_end']:.6g} s"

    @property
    def _states(self) -> StateHistory:
        return StateHistory(*(getattr(self, name) for name in StateHistory._fields))

    @cached_property
    def _states_of_forces(self) -> StateHistory:
        if self.system.is_driven and (self.system.n_multipliers or self._saves_means):
            return fields.recover_forces(self.system, self._states)
        return self._states

    @property
    def _saves_means(self) -> bool:
        """True if accelerations and multipliers are means over the step before."""
        is_mean = self.settings.get("integrator") == repr(EnergyMomentum())
        return is_mean and self.settings.get("accuracy") is None

    def _select(self, values: Values) -> Values:
        return values

    @property
    def multipliers(self) -> Vector:
        """Lagrange multipliers of the constraints, shape (k, m); the same as `lam`."""
        return self.lam

    @property
    def last(self) -> State:
        """The last state, from which ``simulate(..., start=run.last)`` continues.

        Raises
        ------
        InputError
            If only some coordinates were saved and the run was interrupted.
        """
        if self.ending is not None:
            return self.ending if isinstance(self.ending, State) else self.ending.read(self.system)
        if isinstance(self.q, SelectedColumns):
            raise InputError(
                "the run ended early and saved only some coordinates (save_nodes), so its last "
                "state is unknown: run again without save_nodes, or with an earlier t_end"
            )
        rows = (np.array(table[-1]) for table in (self.q, self.v, self.a, self.lam))
        return self.system.state(float(self.t[-1]), *rows)

    @cached_property
    def energy(self) -> Energy:
        """The energy balance, evaluated on first use."""
        lag = 0.5 * self.settings["dt"] if self._saves_means else 0.0
        return fields.evaluate_energy(self.system, self._states, lag)

    def velocity(self, node: Point) -> Vector:
        """Return the velocity of a point.

        Parameters
        ----------
        node : Point
            Any point of a body.

        Returns
        -------
        ndarray, shape (k, dim)
            Velocities [m/s].
        """
        return interpolate(self.system.point(node), self.v)

    def acceleration(self, node: Point) -> Vector:
        """Return the acceleration of a point, (k, dim) [m/s2], as `velocity` does."""
        return interpolate(self.system.point(node), self.a)

    def contacts(self, time: float | None = None) -> ContactTable:
        """Return the places that touch at a time.

        Parameters
        ----------
        time : float, optional
            Time [s]; the nearest saved state is used.  By default the last.

        Returns
        -------
        ContactTable
            A tuple of the touching places, printed as a table: where, normal force and friction
            [N], sliding speed [m/s], penetration [m].

        Raises
        ------
        InputError
            If the time is outside the run.
        """
        row = plotting.nearest_row(self.t, self.t[-1] if time is None else time)
        q, v = np.array(self.q[row]), np.array(self.v[row])
        return fields.contact_table(self.system, q, v, self.internal[row])

    def body(self, body: RigidBody) -> BodyMotion:
        """Return the motion of a rigid body.

        Parameters
        ----------
        body : RigidBody
            A rigid body of the scene, as `add_body` returned it.

        Returns
        -------
        BodyMotion
            Over time: ``centre``, ``velocity``, ``rotation``, ``quaternion``, ``angles``,
            ``angular_velocity``, ``momentum``, ``angular_momentum`` and ``kinetic_energy``.
        """
        return fields.evaluate_motion(self.system, self.q, self.v, body)

    def history(self, point: Point, what: str) -> Vector:
        """Return a quantity at a point over time.

        Parameters
        ----------
        point : Point
            A point, such as ``rod.end`` or ``rod.at(0.5)``.
        what : str
            ``"position"`` [m], ``"velocity"`` [m/s], ``"acceleration"`` [m/s2], ``"slope"`` [-] or
            ``"reaction"`` [N]; of a point of a beam or a mesh also ``"N"``, ``"Q"`` [N], ``"M"``,
            ``"T"`` [N m], ``"strain"`` [-], ``"curvature"`` [1/m], ``"pressure"`` or
            ``"friction"`` [N/m], the magnitudes for all contacts.

        Returns
        -------
        ndarray, shape (k,) or (k, components)
            The values that ``run.plot(what, point)`` plots, at the times ``run.t``.

        Raises
        ------
        InputError
            If an argument is invalid.
        """
        return fields.evaluate_history(self, point, what)

    def range(self, what: str, line: Beam) -> ValueRange:
        """Return the minimum, mean and maximum of a quantity along a beam.

        Parameters
        ----------
        what : str
            ``"N"``, ``"Q"``, ``"M"``, ``"T"``, ``"strain"``, ``"curvature"``, ``"pressure"`` or
            ``"friction"``, in the units of `history`.
        line : Beam
            A beam of the scene.

        Returns
        -------
        ValueRange
            Arc coordinates ``s`` (p,) [m], and ``min``, ``mean``, ``max`` over all saved states,
            (p,) or (p, components): the curves of ``run.plot(what, line, times="range")``.

        Raises
        ------
        InputError
            If an argument is invalid.
        """
        return fields.evaluate_range(self, what, line)

    def resample(self, times: ArrayLike) -> Trajectory:
        """Return the trajectory at other times.

        Parameters
        ----------
        times : array_like, shape (j,)
            Increasing times between the first and the last saved one [s].

        Returns
        -------
        Trajectory
            States in memory at these times; at saved times they are the saved ones.

        Raises
        ------
        InputError
            If the times are invalid or the states exceed the memory.

        Notes
        -----
        Runs with ``accuracy=`` save their states by the same interpolation between steps.
        Coordinates are cubic Hermite polynomials through the coordinates and velocities of two
        saved states, and velocities the same through velocities and accelerations.  For a motion
        that is smooth between states at a distance h, both have an error of order h^4, at most h^4
        / 384 times the fourth derivative.  Accelerations, multipliers and internal variables are
        linear, with an error of order h^2.  Where accelerations are means over steps, as with
        `EnergyMomentum`, velocities are linear too, as within its steps; so are coordinates between
        equilibria, which have no velocities.  Constraints are satisfied up to these errors.
        """
        means = self._saves_means
        states = fields.resample(self._states, times, mean_accelerations=means)
        changes: dict[str, Any] = {}
        if states.t[-1] != self.t[-1]:
            changes["ending"] = None
            if self.finished:
                changes["settings"] = {**self.settings, "t_end": float(states.t[-1])}
        return replace(self, **states._asdict(), **changes)
