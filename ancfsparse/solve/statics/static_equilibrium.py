"""Static equilibrium under the full load, or by load steps if that fails."""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import TYPE_CHECKING

from ancfsparse.checks import (
    check_choice,
    check_count,
    check_finite,
    check_flag,
    check_positive,
)
from ancfsparse.errors import (
    EquilibriumError,
    InputError,
    UnstableEquilibriumWarning,
)
from ancfsparse.results import Equilibrium, RunStats
from ancfsparse.scene import Scene, check_scene
from ancfsparse.seeds import DeflatedSeed, SparseSeed
from ancfsparse.solve.initial_conditions.restart import restore_contributions
from ancfsparse.solve.linearization.rigid_body_modes import free_motions
from ancfsparse.solve.preparation.choose_factorization import FACTORIZATIONS
from ancfsparse.solve.preparation.memory_estimate import (
    DEFLATED_ENTRY_BYTES,
    MemoryEstimate,
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.solve.preparation.progress_bar import progress_bar
from ancfsparse.solve.statics.assemble import find_initial_state
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.solve.statics.free_equilibria import find_free_equilibrium
from ancfsparse.solve.statics.load_stepping import find_equilibrium, find_equilibrium_near
from ancfsparse.system import State, System

if TYPE_CHECKING:
    from ancfsparse.results.solutions.assembly import Assembly
    from ancfsparse.solve.statics.newton_and_relaxation import StaticResult

MIN_TOLERANCE = 1e-14  # tolerance over the loads
MAX_TOLERANCE = 1e-3  # tolerance over the loads
MAX_LOAD_STEPS = 100_000  # load steps
N_MATRICES = 8  # arrays on the pattern: stiffness, parts of it at three states, work arrays


def solve_static(
    scene: Scene,
    *,
    t: float | None = None,
    start: State | Equilibrium | Assembly | None = None,
    load_steps: int = 1,
    tolerance: float = 1e-9,
    factorization: str = "auto",
    progress: bool = False,
) -> Equilibrium:
    """Find the static equilibrium under gravity, loads and prescribed motions of a time.

    The full load is applied at once, or in ``load_steps``.  If that fails, or leads to an unstable
    equilibrium, the load grows from zero in shorter steps and the equilibrium is followed; if its
    path ends, as in snap-through, the scene relaxes without inertia.  Bodies in contact stay on the
    same sides of each other and of obstacles.

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads.  Loads must restrain all rigid motions that joints leave free, as
        the weight of a pendulum or the buoyancy of a float does.
    t : float, optional
        Time at which functions of time are evaluated [s]: by default that of `start`, or 0.
        Prescribed motions go from the reference shape to their values at that time.
    start : State, Equilibrium or Assembly, optional
        Initial state under the full load in place of the reference shape, to find the equilibrium
        near ``assemble(scene)``, ``run.last``, or an equilibrium of another scene of the same
        bodies.  If no stable one is found from there, the reference shape is tried too.
    load_steps : int, optional
        Number of equal load steps at first, up to 100000.  More steps follow the equilibrium path
        more closely if there are several equilibria.
    tolerance : float, optional
        Largest residual over all loads and the forces of prescribed motions, from 1e-14 to 1e-3
        [-].  Residuals below the rounding of forces are accepted.  One more correction follows, so
        positions are more accurate.
    factorization : {"auto", "complete", "incomplete"}, optional
        Solver of corrections: the factor of the stiffness, or conjugate gradients with an
        incomplete factor and deflation modes, whose memory is linear in the mesh.  ``"auto"``
        selects by the fill-in of the factor.
    progress : bool, optional
        Whether to draw a progress bar.

    Returns
    -------
    Equilibrium
        Positions, reactions, multipliers, counts, and whether it is `stable`.

    Raises
    ------
    InputError
        If an argument is invalid, or the factor cannot fit in memory.
    SingularSceneError
        If neither joints nor loads restrain a rigid motion; it is named.
    EquilibriumError
        If no equilibrium is found.

    Warns
    -----
    PenetrationWarning
        If a contact is too soft for the loads.
    UnstableEquilibriumWarning
        If the equilibrium is unstable: a straight column stays straight beyond its buckling load.
        ``stats.negative_pivots`` counts the unstable directions.

    Notes
    -----
    A scene with free rigid motions relaxes without inertia under the full load, without
    ``load_steps``.  Motions without stiffness, such as the rotation of a hanging rod about its
    axis, do not change.  Friction of contacts opposes the displacement from `start`, or from the
    reference shape.  The theory is in docs/theory.md.
    """
    check_scene(scene)
    if check_count("load_steps", load_steps) > MAX_LOAD_STEPS:
        raise InputError(f"load_steps must be at most {MAX_LOAD_STEPS}, got {load_steps}")
    tolerance = check_static_tolerance(tolerance)
    begins, moved = find_initial_state(scene, start)
    if t is None:
        t = 0.0 if begins is None else begins.t
    t = check_finite("t", t, "s")
    check_choice("factorization", factorization, FACTORIZATIONS)
    check_flag("progress", progress)
    begin = time.perf_counter()
    needed = estimate_memory(
        scene,
        1,
        matrices=N_MATRICES,
        incomplete=factorization != "complete",
        incomplete_entry=DEFLATED_ENTRY_BYTES,
    )
    stats = RunStats(solver="Newton with extrapolated stress" + (moved and f"; start {moved}"))
    with within_memory(needed), progress_bar("factor", progress) as bar:
        system = System(scene, begins)
        free = free_motions(system)
        with system.equilibria(system.q_ref if begins is None else system.q0):
            restore_contributions(begins, system)
            equations = EquilibriumEquations(system, stats, bar.update, factorization, t)
            check_factor_fits(needed, equations.seed)
            if isinstance(equations.seed, DeflatedSeed):
                stats.solver += " and an incomplete factorization with deflation"
            stats.seconds["set-up"] = time.perf_counter() - begin

            def find(equations: EquilibriumEquations) -> StaticResult:
                if free:
                    return find_free_equilibrium(equations, system.q0, tolerance, free)
                if begins is not None:
                    return find_equilibrium_near(equations, system.q0, load_steps, tolerance)
                return find_equilibrium(equations, load_steps, tolerance)

            try:
                result = find(equations)
            except EquilibriumError as failure:
                complete = _complete_equations(equations, needed, factorization, bar.update, t)
                if complete is None:
                    raise
                try:
                    result = find(complete)
                except EquilibriumError:
                    raise failure from None
                stats.solver += "; then with a complete factorization (which found an equilibrium)"
            system.accept_equilibrium(result.state.q)
            history = system.assembly.history
            memory = system.memory_at_rest(result.state.q)
    stats.march_seconds = time.perf_counter() - begin - stats.seconds["set-up"]
    stats.negative_pivots, stats.error = result.negative, result.error
    stats.sweeps, stats.products = equations.seed.inner
    if result.negative and equations.conservative:
        warnings.warn(UnstableEquilibriumWarning(result.negative), stacklevel=2)
    for warning in system.rest_warnings(result.state.q[None], lambda _: f"at t = {t:.4g} s,"):
        warnings.warn(warning, stacklevel=2)
    return Equilibrium(system, result.state.q, result.state.lam, stats, t, history, memory)


def check_static_tolerance(tolerance: object) -> float:
    """Return a tolerance over the loads after checking it."""
    number = check_positive("tolerance", tolerance)
    if not MIN_TOLERANCE <= number <= MAX_TOLERANCE:
        raise InputError(
            "tolerance is the largest residual over the loads and driving forces, from "
            f"{MIN_TOLERANCE:g} to {MAX_TOLERANCE:g}, got {number:g}: leave it out, or take 1e-12 "
            "for more digits"
        )
    return number


def _complete_equations(
    equations: EquilibriumEquations,
    needed: MemoryEstimate,
    kind: str,
    on_factor: Callable[[], object],
    t: float,
) -> EquilibriumEquations | None:
    """Return the equations on a complete seed if "auto" had selected another and it fits."""
    if kind != "auto" or isinstance(equations.seed, SparseSeed):
        return None
    complete = EquilibriumEquations(equations.system, equations.stats, on_factor, t=t)
    try:
        check_factor_fits(replace(needed, factor=0.0, complete=0.0), complete.seed)
    except InputError:
        return None
    return complete
