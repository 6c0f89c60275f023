"""Static equilibrium by Newton with load steps."""

from __future__ import annotations

import time

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from ancfsparse.checks import check_count, check_positive
from ancfsparse.errors import EquilibriumFailure, SingularSceneError
from ancfsparse.results import Equilibrium, RunStats
from ancfsparse.scene import Scene
from ancfsparse.solve.freedom import MOST, free_motions
from ancfsparse.system import System

Vector = NDArray[np.float64]

MAX_ITERATIONS = 30
SMALLEST_STEP = 1.0 / 4096.0


def solve_static(scene: Scene, *, load_steps: int = 10, tolerance: float = 1e-12) -> Equilibrium:
    """Find the static equilibrium under gravity and the loads at t = 0.

    The load grows from zero to its full size; a load step at which Newton does not converge is
    halved.

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads, held by its joints against every rigid motion.
    load_steps : int, optional
        Load steps to begin with.
    tolerance : float, optional
        Largest last correction, beside the largest coordinate of the scene.

    Returns
    -------
    Equilibrium
        Positions, reactions, multipliers and counts.

    Raises
    ------
    SingularSceneError
        If the joints leave a rigid motion free; it is named.
    EquilibriumFailure
        If no equilibrium is found even with small load steps.

    Notes
    -----
    What is found balances the forces; whether it is stable is not examined, and a straight beam
    stays straight beyond its buckling load.  Mechanisms that only their load stiffens, such as a
    hanging chain of hinged cables, count as not held.
    """
    check_count("load_steps", load_steps)
    check_positive("tolerance", tolerance)
    system = System(scene)
    free = free_motions(system)
    if free:
        count = f"{len(free)}{' or more' * (len(free) == MOST)}"
        raise SingularSceneError(
            f"the scene is not held: {count} rigid motion(s) are free, first the {free[0]}; "
            "add a pin or a clamp, or let it settle in time with simulate if only its load holds it"
        )
    clock = time.perf_counter()
    stats = RunStats(solver="Newton with load steps")
    q, lam = system.q0.copy(), np.zeros(system.n_multipliers)
    done, step = 0.0, 1.0 / load_steps
    while done < 1.0:
        target = min(1.0, done + step)
        if 1.0 - target < 1e-9:
            target = 1.0
        found = _equilibrium(system, q, lam, target, tolerance, stats)
        if isinstance(found, str):
            step *= 0.5
            if step < SMALLEST_STEP:
                raise _failure(system, q, lam, target, found)
            continue
        q, lam = found
        done = target
        stats.steps += 1
    stats.march_seconds = time.perf_counter() - clock
    return Equilibrium(system, q, lam, stats)


def _equilibrium(
    system: System, q: Vector, lam: Vector, load: float, tolerance: float, stats: RunStats
) -> tuple[Vector, Vector] | str:
    """Return the state at a share of the load, or why it was not found."""
    q, lam = q.copy(), lam.copy()
    pattern, n = system.pattern, system.n_free
    amplitudes = load * system.loads.amplitudes(np.zeros(1))[0]
    size = np.max(np.abs(system.q0))
    for _ in range(MAX_ITERATIONS):
        r, phi = _residual(system, q, lam, load, amplitudes)
        stats.residual_evaluations += 1
        values = system.assembly.matrix(0.0, 1.0, q, lam, amplitudes)
        lower = sp.csc_matrix((values, pattern.indices, pattern.indptr), shape=(pattern.n,) * 2)
        whole = lower + sp.tril(lower, -1).T
        try:
            correction = splu(whole.tocsc()).solve(np.concatenate([r[:n], phi]))
        except RuntimeError as singular:
            return f"the stiffness is singular ({singular})"
        stats.factorizations += 1
        stats.solves += 1
        stats.iterations += 1
        if not np.all(np.isfinite(correction)):
            return "the stiffness is singular"
        q[:n] -= correction[:n]
        lam -= correction[n:]
        largest = np.max(np.abs(correction[:n]))
        if largest > 1e3 * size:
            return "a correction went beyond a thousand times the size of the scene"
        if largest <= tolerance * size:
            return q, lam
    return f"no convergence in {MAX_ITERATIONS} iterations"


def _residual(
    system: System, q: Vector, lam: Vector, load: float, amplitudes: Vector
) -> tuple[Vector, Vector]:
    rest = np.zeros(system.n_all)
    r, phi = system.assembly.residual(q, rest, rest, lam, load * system.dead_load, amplitudes)
    return np.asarray(r), np.asarray(phi)


def _failure(
    system: System, q: Vector, lam: Vector, load: float, reason: str
) -> EquilibriumFailure:
    """Name the largest unbalanced force of the last state found, under the load that failed."""
    r, _ = _residual(system, q, lam, load, load * system.loads.amplitudes(np.zeros(1))[0])
    worst = int(np.argmax(np.abs(r[: system.n_free])))
    return EquilibriumFailure(
        reason, load, abs(float(r[worst])), system.describe(worst), system.unit(worst)
    )
