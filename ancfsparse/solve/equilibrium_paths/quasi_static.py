"""Quasi-static motion: equilibria under slowly changing loads and prescribed motions."""

from __future__ import annotations

import time
import warnings
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_flag, check_positive
from ancfsparse.errors import (
    AncfError,
    MessageTemplate,
    Parameter,
    UnstableEquilibriumWarning,
)
from ancfsparse.integrators.interface.time_grid import TimeGrid, count_steps_from
from ancfsparse.results import Equilibrium, RunStats, Trajectory
from ancfsparse.scene import Scene, check_scene
from ancfsparse.solve.error_models.signal_resolution import (
    corners_between_steps,
    warn_of_unresolved_signals,
)
from ancfsparse.solve.initial_conditions.restart import restore_contributions
from ancfsparse.solve.linearization.rigid_body_modes import free_motions
from ancfsparse.solve.preparation.choose_factorization import FACTORIZATIONS
from ancfsparse.solve.preparation.memory_estimate import (
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.solve.preparation.progress_bar import progress_bar
from ancfsparse.solve.statics.assemble import find_initial_state
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.solve.statics.free_equilibria import find_free_equilibrium, perturb_unstable
from ancfsparse.solve.statics.load_stepping import find_equilibrium, find_equilibrium_near
from ancfsparse.solve.statics.newton_and_relaxation import (
    NotFoundError,
    check_passage,
    relax,
    solve_newton,
)
from ancfsparse.solve.statics.static_equilibrium import N_MATRICES, check_static_tolerance
from ancfsparse.system import State, System
from ancfsparse.system_memory import check_memory

if TYPE_CHECKING:
    from ancfsparse.solve.statics.newton_and_relaxation import StaticResult


N_SAVED = 200  # states without dt
BYTES_PER_COORDINATE = 24.0  # bytes of an equilibrium: result, row of the table, and zero rates
MIN_STEP_RATIO = 1.0 / 64.0  # part of the time between saved states
N_EXTRAPOLATED = 3  # states before the last one, for extrapolation


def quasi_static(
    scene: Scene,
    t_end: float,
    dt: float | None = None,
    *,
    start: State | Equilibrium | None = None,
    tolerance: float = 1e-9,
    factorization: str = "auto",
    progress: bool = False,
) -> Trajectory:
    """Follow the equilibria of a scene while loads and prescribed motions change slowly.

    Inertia and damping are neglected; the error is about the square of the load frequency over the
    lowest natural frequency, relative to the motion.  Each state is an equilibrium, so there is no
    error of the time step, except by friction of contacts, which depends on the path.  Where an
    equilibrium is lost between saved states, the interval is divided, up to 64 times, and also at
    the times of signals that are too short for it.  Where an equilibrium ceases to exist, as in
    snap-through, or becomes unstable, as in buckling, the scene relaxes to another one, which
    ``stats.recoveries`` counts.

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads.
    t_end : float
        Time at the end [s], a whole number of steps after the start.
    dt : float, optional
        Time between saved states [s]; by default 1/200 of the duration.
    start : State or Equilibrium, optional
        Initial state with its time; by default the equilibrium of `solve_static` at t = 0.
    tolerance : float, optional
        Largest residual over the largest loads so far and the present forces of prescribed motions,
        as in `solve_static` [-].
    factorization : {"auto", "complete", "incomplete"}, optional
        As in `solve_static`.
    progress : bool, optional
        Whether to draw a progress bar.

    Returns
    -------
    Trajectory
        The equilibria.  Velocities and accelerations are zero, and reactions, section forces and
        energies static.

    Raises
    ------
    InputError
        If an argument is invalid, or the equilibria or the factor cannot fit in memory.
    SingularSceneError
        If neither joints nor loads restrain a rigid motion.
    EquilibriumError
        If there is no equilibrium.
    LoadError
        If a load that is a function of time raises an error or returns no load.

    Errors at later times have the equilibria before in their attribute ``trajectory``.

    Warns
    -----
    PenetrationWarning
        If a contact is too soft for the loads.
    UnstableEquilibriumWarning
        If no stable equilibrium was found at some time.
    UnresolvedSignalWarning
        If the saved states miss or alias a signal.
    """
    check_scene(scene)
    begins, moved = find_initial_state(scene, start)
    grid, n = _saved_times(0.0 if begins is None else begins.t, t_end, dt)
    tolerance = check_static_tolerance(tolerance)
    check_choice("factorization", factorization, FACTORIZATIONS)
    check_flag("progress", progress)
    begin = time.perf_counter()
    needed = estimate_memory(scene, n + 1, matrices=N_MATRICES)
    stats = RunStats(solver="equilibria, Newton with extrapolated stress")
    with within_memory(needed), progress_bar("step", progress, n) as bar:
        system = System(scene, begins)
        hint = MessageTemplate("a larger {dt}", dt=Parameter("dt"))
        check_memory("the equilibria", BYTES_PER_COORDINATE * (n + 1) * system.n_all, hint)
        equations = EquilibriumEquations(system, stats, kind=factorization, t=grid.begin)
        check_factor_fits(needed, equations.seed)
        warn_of_unresolved_signals(system, grid, n, stacklevel=3)
        corners = corners_between_steps(system, grid, n)
        stats.seconds["set-up"] = time.perf_counter() - begin
        with system.equilibria(system.q_ref if begins is None else system.q0):
            restore_contributions(begins, system)
            path = _QuasiStaticPath(equations, tolerance, free_motions(system))
            times, results = [grid.begin], [path.first(begins is not None)]
            histories = [system.assembly.history]
            settings: dict[str, object] = {"t_start": None, "t_end": float(t_end), "dt": grid.dt}
            settings |= {"moved": moved} if moved else {}
            for k in range(1, n + 1):
                try:
                    for time_between in corners:
                        if grid.at(k - 1) < time_between < grid.at(k):
                            path.advance_to_corner(time_between)
                    path.advance(grid.at(k))
                except AncfError as failure:
                    run = _trajectory(system, times, results, histories, stats, settings)
                    failure.trajectory = run  # type: ignore[attr-defined]
                    raise
                times.append(grid.at(k))
                results.append(path.last)
                histories.append(system.assembly.history)
                bar.update()
    stats.steps = n
    stats.march_seconds = time.perf_counter() - begin - stats.seconds["set-up"]
    negative = max(result.negative for result in results)
    if negative and equations.conservative:
        warnings.warn(UnstableEquilibriumWarning(negative), stacklevel=2)
    run = _trajectory(system, times, results, histories, stats, settings)
    for warning in system.rest_warnings(run.q[:], lambda k: f"at t = {times[k]:.4g} s,"):
        warnings.warn(warning, stacklevel=2)
    return run


def _saved_times(begin: float, t_end: float, dt: float | None) -> tuple[TimeGrid, int]:
    """Return the times of the saved states, and the number of steps."""
    if dt is None:
        end = check_positive("t_end", t_end, "s") if begin == 0.0 else float(t_end)
        dt = (end - begin) / N_SAVED
    n = count_steps_from(begin, t_end, dt)
    return TimeGrid(begin, float(dt)), n


def _trajectory(
    system: System,
    times: list[float],
    results: list[StaticResult],
    histories: list[Vector],
    stats: RunStats,
    settings: dict[str, object],
) -> Trajectory:
    """Return the equilibria as a trajectory."""
    t = np.array(times)
    q = np.stack([result.state.q for result in results])
    lam = np.stack([result.state.lam for result in results])
    zero = np.zeros_like(q)
    history = np.stack(histories)
    return Trajectory(system, t, q, zero, zero, lam, stats, settings, internal=history)


def _extrapolation_weights(times: list[float], to: float) -> list[float]:
    """Return the weights of Lagrange's extrapolation from some times to another."""
    return [float(np.prod([(to - s) / (t - s) for s in times if s != t])) for t in times]


class _QuasiStaticPath:
    """A sequence of equilibria over time.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations.
    tolerance : float
        Largest residual over the loads [-].
    free : list of str
        The free rigid motions.

    Attributes
    ----------
    last : StaticResult
        The last equilibrium.
    """

    last: StaticResult

    def __init__(self, equations: EquilibriumEquations, tolerance: float, free: list[str]) -> None:
        self._equations, self._tolerance, self._free = equations, tolerance, free
        self._t = equations.system.t0
        self._before: list[tuple[float, StaticResult]] = []

    def first(self, from_start: bool) -> StaticResult:
        """Find the equilibrium at the start."""
        q = self._equations.system.q0
        if self._free:
            self.last = self._relaxed(q)
        elif from_start:
            self.last = find_equilibrium_near(self._equations, q, 1, self._tolerance)
        else:
            self.last = find_equilibrium(self._equations, 1, self._tolerance)
        self._equations.system.accept_equilibrium(self.last.state.q)
        return self.last

    def advance(self, t: float) -> None:
        """Follow the equilibrium to a time [s]; relax to another one where it is lost."""
        interval = step = t - self._t
        while self._t < t:
            to = t if self._t + 1.5 * step > t else self._t + step
            self._equations.system.approach_equilibrium(to - self._t)
            self._equations.move_to(to)
            try:
                result = self._continued(to)
            except NotFoundError:
                result = None
            if result is None and step > MIN_STEP_RATIO * interval:
                step *= 0.5
                continue
            self._before.append((self._t, self.last))
            if result is None:
                self._before.clear()
            self.last = self._another() if result is None else result
            self._equations.system.accept_equilibrium(self.last.state.q)
            self._t = to

    def advance_to_corner(self, t: float) -> None:
        """Follow the equilibrium to a time [s] at which the loads kink; extrapolate from there."""
        self.advance(t)
        self._before.clear()

    def _continued(self, to: float) -> StaticResult | None:
        """Return the equilibrium near the extrapolated one, None if it is unstable."""
        equations = self._equations
        known = [*self._before[-N_EXTRAPOLATED:], (self._t, self.last)]
        weights = _extrapolation_weights([t for t, _ in known], to)
        states = [result.state for _, result in known]
        q = np.sum([w * state.q for w, state in zip(weights, states, strict=True)], axis=0)
        lam = sum(w * state.lam for w, state in zip(weights, states, strict=True))
        # Not corrected, so extrapolation would let their rounding grow.
        q[equations.system.n_free :] = equations.imposed.places
        state = equations.state(q, np.asarray(lam), 1.0)
        check_passage(equations, self.last.state.q, state, 1.0)
        if self._free:
            return self._relaxed(state.q)
        result = solve_newton(equations, state, 1.0, self._tolerance)
        return result if result.negative == 0 or not equations.conservative else None

    def _another(self) -> StaticResult:
        """Return an equilibrium away from the last one, stable if one is found."""
        equations = self._equations
        equations.stats.recoveries += 1
        if self._free:
            return self._relaxed(self.last.state.q)
        result = find_equilibrium_near(equations, self.last.state.q, 1, self._tolerance)
        if result.negative == 0 or not equations.conservative:
            return result
        try:
            return relax(equations, perturb_unstable(equations, result.state), 1.0, self._tolerance)
        except NotFoundError:
            return result

    def _relaxed(self, q: Vector) -> StaticResult:
        return find_free_equilibrium(self._equations, q, self._tolerance, self._free)
