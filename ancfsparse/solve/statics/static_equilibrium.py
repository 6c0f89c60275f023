"""Static equilibrium: under the whole load at once, or in steps where that does not do."""

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
from ancfsparse.nonlinear import Newton
from ancfsparse.results import Equilibrium, RunStats
from ancfsparse.scene import Scene, check_scene
from ancfsparse.seeds import DeflatedSeed, SparseSeed
from ancfsparse.solve.initial_conditions.restart import check_start
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
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.solve.statics.free_equilibria import find_hanging
from ancfsparse.solve.statics.load_stepping import find_equilibrium, find_from
from ancfsparse.system import State, System

if TYPE_CHECKING:
    from ancfsparse.results.solutions.assembly import Assembly
    from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
    from ancfsparse.solve.statics.newton_and_relaxation import StaticResult

# Shares of the loads that may be asked for.
FINEST, COARSEST = 1e-14, 1e-3
MOST_STEPS = 100_000
# Arrays of values on the pattern: stiffness, its parts at three states, work and room to spare.
MATRICES = 8


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
    """Find the static equilibrium under gravity, with loads and drives as they are at a time.

    The whole load is applied at once, or in ``load_steps``.  Where that fails, or leads to an
    unstable equilibrium, the load grows from zero in shorter steps, so that the equilibrium is
    followed; where its path ends, as in snap-through, the scene settles without inertia.

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads.  Rigid motions that no joint prevents must be restrained by loads
        that have a potential, as those of a pendulum by its weight.
    t : float, optional
        Time at which functions of time are evaluated [s]: by default that of `start`, or 0.
        Drives move from the reference shape to where they are then.
    start : State, Equilibrium or Assembly, optional
        Where to begin, under the whole load at once, in place of the reference shape: the
        equilibrium next to ``assemble(scene)``, to ``run.last``, or to that of another scene of the
        same bodies.  If no stable one is found from there, the reference shape is tried too.
    load_steps : int, optional
        Equal load steps to begin with, up to 100000.  More follow the path of the load more closely
        where there are several equilibria.
    tolerance : float, optional
        Unbalanced forces that may be left, as a share of all loads, from 1e-14 to 1e-3 [-].  What
        is below the rounding of forces counts as balanced.  One more correction follows, so the
        error of the positions is smaller yet.
    factorization : {"auto", "complete", "incomplete"}, optional
        What corrections are solved with: the factor of the stiffness, or conjugate gradients on one
        without fill and on coarse modes, whose memory is linear in the mesh.  ``"auto"`` counts how
        much the factor would fill in.
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
    UnstableEquilibriumWarning
        If the one that is found is unstable: a straight column stays straight beyond its buckling
        load.  ``stats.negative_pivots`` counts the directions in which it would leave.

    Notes
    -----
    A scene that can swing settles without inertia under the whole load; ``load_steps`` does nothing
    then.  In motions that take no force, such as the spin of a hanging rod about its axis, it stays
    as it was.  The theory is in docs/theory.md.
    """
    check_scene(scene)
    if check_count("load_steps", load_steps) > MOST_STEPS:
        raise InputError(f"load_steps must be at most {MOST_STEPS}, got {load_steps}")
    tolerance = check_positive("tolerance", tolerance)
    if not FINEST <= tolerance <= COARSEST:
        raise InputError(
            f"tolerance is the share of the loads that may stay unbalanced, from {FINEST:g} to "
            f"{COARSEST:g}, got {tolerance:g}: leave it out, or take 1e-12 for more digits"
        )
    begins = check_start(start)
    if t is None:
        t = 0.0 if begins is None else begins.t
    t = check_finite("t", t, "s")
    check_choice("factorization", factorization, FACTORIZATIONS)
    check_flag("progress", progress)
    begin = time.perf_counter()
    needed = estimate_memory(
        scene,
        1,
        0,
        False,
        Newton(),
        matrices=MATRICES,
        incomplete=factorization != "complete",
        incomplete_entry=DEFLATED_ENTRY_BYTES,
    )
    stats = RunStats(solver="Newton with extrapolated stress")
    with within_memory(needed), progress_bar("factor", progress) as bar:
        system = System(scene, begins)
        free = free_motions(system)
        balance = EquilibriumEquations(system, stats, bar.update, factorization, t)
        check_factor_fits(needed, balance.seed)
        if isinstance(balance.seed, DeflatedSeed):
            stats.solver += " and an incomplete factorization with deflation"
        stats.seconds["set-up"] = time.perf_counter() - begin

        def find(equations: EquilibriumEquations) -> StaticResult:
            if free:
                return find_hanging(equations, system.q0, tolerance, free)
            if begins is not None:
                return find_from(equations, system.q0, load_steps, tolerance)
            return find_equilibrium(equations, load_steps, tolerance)

        try:
            found = find(balance)
        except EquilibriumError as failure:
            exact = _exact_instead(balance, needed, factorization, bar.update, t)
            if exact is None:
                raise
            try:
                found = find(exact)
            except EquilibriumError:
                raise failure from None
            stats.solver += "; then with a complete factorization (which found an equilibrium)"
    stats.march_seconds = time.perf_counter() - begin - stats.seconds["set-up"]
    stats.negative_pivots, stats.error = found.negative, found.error
    stats.sweeps, stats.products = balance.seed.inner
    if found.negative and balance.conservative:
        warnings.warn(UnstableEquilibriumWarning(found.negative), stacklevel=2)
    return Equilibrium(system, found.state.q, found.state.lam, stats, t)


def _exact_instead(
    balance: EquilibriumEquations,
    needed: MemoryEstimate,
    kind: str,
    on_factor: Callable[[], object],
    t: float,
) -> EquilibriumEquations | None:
    """Return the same equations on a complete seed, where one was not asked against and it fits."""
    if kind != "auto" or isinstance(balance.seed, SparseSeed):
        return None
    exact = EquilibriumEquations(balance.system, balance.stats, on_factor, t=t)
    try:
        check_factor_fits(replace(needed, factor=0.0, complete=0.0), exact.seed)
    except InputError:
        return None
    return exact
