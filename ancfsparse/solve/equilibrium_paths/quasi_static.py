"""Quasi-static motion: a sequence of equilibria that follows loads and drives over time."""

from __future__ import annotations

import time
import warnings
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_choice, check_flag, check_positive
from ancfsparse.errors import (
    AncfError,
    MessageTemplate,
    Parameter,
    UnstableEquilibriumWarning,
)
from ancfsparse.integrators.interface.time_grid import TimeGrid, count_steps_from
from ancfsparse.nonlinear import Newton
from ancfsparse.results import Equilibrium, RunStats, Trajectory
from ancfsparse.scene import Scene, check_scene
from ancfsparse.solve.initial_conditions.restart import check_start
from ancfsparse.solve.linearization.rigid_body_modes import free_motions
from ancfsparse.solve.preparation.choose_factorization import FACTORIZATIONS
from ancfsparse.solve.preparation.memory_estimate import (
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.solve.preparation.progress_bar import progress_bar
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.solve.statics.free_equilibria import find_free_equilibrium, perturb_unstable
from ancfsparse.solve.statics.load_stepping import find_equilibrium, find_equilibrium_near
from ancfsparse.solve.statics.newton_and_relaxation import NotFoundError, relax, solve_newton
from ancfsparse.solve.statics.static_equilibrium import N_MATRICES, check_static_tolerance
from ancfsparse.system import State, System
from ancfsparse.system_memory import check_memory

if TYPE_CHECKING:
    from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
    from ancfsparse.solve.statics.newton_and_relaxation import StaticResult

Vector = NDArray[np.float64]

# Saved states if no time between them is given.
SAVED = 200
# Bytes for each coordinate of an equilibrium: found, in the table, and the zeros of its rates.
KEPT = 24.0
# How far the way from one saved state to the next may be divided where an equilibrium is lost.
SHORTEST = 1.0 / 64.0
# States before the last one that the next is extrapolated from.
KNOWN = 3


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
    """Follow the equilibria of a scene while loads and drives change slowly.

    Without inertia and damping.  What that neglects is about the square of the frequency of the
    loads over the lowest natural frequency, a share of the motion.  Each state is an equilibrium,
    so there is no error of the time step.  Where an equilibrium is lost from one saved state to the
    next, the way is divided, up to 64 times; where it ceases to exist, as in snap-through, or is no
    longer stable, as in buckling, the scene settles in another, and ``stats.recoveries`` counts
    that.

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads.
    t_end : float
        Time at the end [s], a whole number of steps after the start.
    dt : float, optional
        Time between saved states [s]; by default 1/200 of the whole.
    start : State or Equilibrium, optional
        Where to begin, at its time; by default the equilibrium at t = 0 that `solve_static` finds.
    tolerance : float, optional
        Unbalanced forces that may be left, as a share of the largest loads so far, as in
        `solve_static` [-].
    factorization : {"auto", "complete", "incomplete"}, optional
        As in `solve_static`.
    progress : bool, optional
        Whether to draw a progress bar.

    Returns
    -------
    Trajectory
        The equilibria.  Velocities and accelerations are zero, so that reactions, forces in
        sections and energies are those at rest.

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

    Errors on the way have the equilibria before in their attribute ``trajectory``.

    Warns
    -----
    UnstableEquilibriumWarning
        If no stable equilibrium was found at some time.
    """
    check_scene(scene)
    begins = check_start(start)
    clock, n = _steps(0.0 if begins is None else begins.t, t_end, dt)
    tolerance = check_static_tolerance(tolerance)
    check_choice("factorization", factorization, FACTORIZATIONS)
    check_flag("progress", progress)
    begin = time.perf_counter()
    needed = estimate_memory(scene, n + 1, 0, False, Newton(), matrices=N_MATRICES)
    stats = RunStats(solver="equilibria, Newton with extrapolated stress")
    with within_memory(needed), progress_bar("step", progress, n) as bar:
        system = System(scene, begins)
        wider = MessageTemplate("a larger {dt}", dt=Parameter("dt"))
        check_memory("the equilibria", KEPT * (n + 1) * system.n_all, wider)
        equations = EquilibriumEquations(system, stats, kind=factorization, t=clock.begin)
        check_factor_fits(needed, equations.seed)
        stats.seconds["set-up"] = time.perf_counter() - begin
        march = _March(equations, tolerance, free_motions(system))
        times, found = [clock.begin], [march.first(begins is not None)]
        settings: dict[str, object] = {"t_start": None, "t_end": float(t_end), "dt": clock.dt}
        for k in range(1, n + 1):
            try:
                march.go_to(clock.at(k))
            except AncfError as failure:
                path = _path(system, times, found, stats, settings)
                failure.trajectory = path  # type: ignore[attr-defined]
                raise
            times.append(clock.at(k))
            found.append(march.here)
            bar.update()
    stats.steps = n
    stats.march_seconds = time.perf_counter() - begin - stats.seconds["set-up"]
    worst = max(each.negative for each in found)
    if worst and equations.conservative:
        warnings.warn(UnstableEquilibriumWarning(worst), stacklevel=2)
    return _path(system, times, found, stats, settings)


def _steps(begin: float, t_end: float, dt: float | None) -> tuple[TimeGrid, int]:
    """Return the times of the saved states, and how many steps there are between them."""
    if dt is None:
        end = check_positive("t_end", t_end, "s") if begin == 0.0 else float(t_end)
        dt = (end - begin) / SAVED
    n = count_steps_from(begin, t_end, dt)
    return TimeGrid(begin, float(dt)), n


def _path(
    system: System,
    times: list[float],
    found: list[StaticResult],
    stats: RunStats,
    settings: dict[str, object],
) -> Trajectory:
    """Return the equilibria as a motion."""
    t = np.array(times)
    q = np.stack([each.state.q for each in found])
    lam = np.stack([each.state.lam for each in found])
    rest = np.zeros_like(q)
    return Trajectory(system, t, q, rest, rest, lam, stats, settings)


def _extrapolation(times: list[float], to: float) -> list[float]:
    """Return the weights of values at some times in the polynomial through them at another."""
    return [float(np.prod([(to - s) / (t - s) for s in times if s != t])) for t in times]


class _March:
    """Goes from one equilibrium to the next.

    Parameters
    ----------
    equations : EquilibriumEquations
        The equations of rest.
    tolerance : float
        Unbalanced share of the loads that is allowed.
    free : list of str
        The motions that joints leave free.

    Attributes
    ----------
    here : Found
        The last equilibrium.
    """

    here: StaticResult

    def __init__(self, equations: EquilibriumEquations, tolerance: float, free: list[str]) -> None:
        self._equations, self._tolerance, self._free = equations, tolerance, free
        self._t = equations.system.t0
        self._before: list[tuple[float, StaticResult]] = []

    def first(self, from_start: bool) -> StaticResult:
        """Find the equilibrium at the start."""
        q = self._equations.system.q0
        if self._free:
            self.here = self._hanging(q)
        elif from_start:
            self.here = find_equilibrium_near(self._equations, q, 1, self._tolerance)
        else:
            self.here = find_equilibrium(self._equations, 1, self._tolerance)
        return self.here

    def go_to(self, t: float) -> None:
        """Follow the equilibrium to a time [s], and settle in another where it is lost."""
        whole = step = t - self._t
        while self._t < t:
            to = t if self._t + 1.5 * step > t else self._t + step
            self._equations.move_to(to)
            try:
                found = self._near(to)
            except NotFoundError:
                found = None
            if found is None and step > SHORTEST * whole:
                step *= 0.5
                continue
            self._before.append((self._t, self.here))
            if found is None:
                self._before.clear()
            self.here = self._another() if found is None else found
            self._t = to

    def _near(self, to: float) -> StaticResult | None:
        """Return the equilibrium next to the extrapolated one, None if it is unstable."""
        equations = self._equations
        known = [*self._before[-KNOWN:], (self._t, self.here)]
        weights = _extrapolation([t for t, _ in known], to)
        q = np.sum([w * each.state.q for w, (_, each) in zip(weights, known, strict=True)], axis=0)
        lam = sum(w * each.state.lam for w, (_, each) in zip(weights, known, strict=True))
        # Corrections leave these alone, so that extrapolation would let their rounding grow.
        q[equations.system.n_free :] = equations.places
        if self._free:
            return self._hanging(q)
        state = equations.state(q, np.asarray(lam), 1.0)
        found = solve_newton(equations, state, 1.0, self._tolerance)
        return found if found.negative == 0 or not equations.conservative else None

    def _another(self) -> StaticResult:
        """Return an equilibrium that is not next to the last one, stable if one is found."""
        equations = self._equations
        equations.stats.recoveries += 1
        if self._free:
            return self._hanging(self.here.state.q)
        found = find_equilibrium_near(equations, self.here.state.q, 1, self._tolerance)
        if found.negative == 0 or not equations.conservative:
            return found
        try:
            return relax(equations, perturb_unstable(equations, found.state), 1.0, self._tolerance)
        except NotFoundError:
            return found

    def _hanging(self, q: Vector) -> StaticResult:
        return find_free_equilibrium(self._equations, q, self._tolerance, self._free)
