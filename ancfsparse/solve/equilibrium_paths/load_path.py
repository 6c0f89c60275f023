"""The path of equilibria while the loads grow and fall."""

from __future__ import annotations

import time
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.checks import check_count, check_finite, check_positive
from ancfsparse.errors import EquilibriumError, InputError
from ancfsparse.messages import format_value
from ancfsparse.nonlinear import Newton
from ancfsparse.results import RunStats
from ancfsparse.results.solutions.load_path import LoadPath
from ancfsparse.scene import Scene, check_scene
from ancfsparse.solve.equilibrium_paths.arc_length import follow
from ancfsparse.solve.linearization.rigid_body_modes import check_restrained
from ancfsparse.solve.preparation.memory_estimate import (
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.solve.statics.newton_and_relaxation import NotFoundError
from ancfsparse.solve.statics.static_equilibrium import N_MATRICES, check_static_tolerance
from ancfsparse.system import System

if TYPE_CHECKING:
    from ancfsparse.results.solutions.load_path import LoadPath

# Least multiple of the loads to which a path may lead.
LEAST = 1e-6


def load_path(
    scene: Scene,
    *,
    to: float = 1.0,
    t: float = 0.0,
    points: int = 500,
    tolerance: float = 1e-9,
    branch: int = 0,
) -> LoadPath:
    """Follow the equilibria of a scene from its stress-free shape past limit points.

    All loads and gravity grow and fall together, and prescribed places move with them, so that the
    path goes on where a frame snaps through or back.  Points where the load turns are found to
    working accuracy.

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads, held by its joints against every rigid motion.
    to : float, optional
        Multiple of the loads at which the path ends [-], where it first gets there.
    t : float, optional
        Time at which functions of time are evaluated [s].
    points : int, optional
        Most points.
    tolerance : float, optional
        As in `solve_static` [-].
    branch : int, optional
        1 or -1: where the path first loses its stability without a turn of the load, as where a
        column buckles, leave it along the buckling shape, to the side where the largest
        motion of that shape is positive or negative.  0 goes straight on.

    Returns
    -------
    LoadPath
        Multiples of the loads, states, their stability, and where the load turns.  It is not
        `complete` if there were not enough points, or it led to ten times the opposite load.

    Raises
    ------
    InputError
        If an argument is invalid, there are no loads, or the factor cannot fit in memory.
    SingularSceneError
        If the joints leave a rigid motion free.
    EquilibriumError
        If the path cannot be followed any further.

    Notes
    -----
    Arc-length steps of the root mean square displacement, with corrections in the plane across
    the path (Ramm 1981).  Where the path branches, it goes straight on, unless a `branch` is asked
    for; `stable` shows that.  Where several shapes buckle at once, one of them is taken.  The
    theory is in docs/theory.md.
    """
    check_scene(scene)
    to = check_positive("to", to)
    if to < LEAST:
        raise InputError(
            f"to is a multiple of the loads, at least {LEAST:g}, got {to:g}: smaller ones are lost "
            "in rounding"
        )
    t = check_finite("t", t, "s")
    points = check_count("points", points)
    tolerance = check_static_tolerance(tolerance)
    if isinstance(branch, bool) or not isinstance(branch, int) or branch not in (-1, 0, 1):
        raise InputError(f"branch must be 1, -1 or 0, got {format_value(branch)}")
    begin = time.perf_counter()
    needed = estimate_memory(scene, points, 0, False, Newton(), matrices=N_MATRICES)
    stats = RunStats(solver="Newton along the arc length")
    with within_memory(needed):
        system = System(scene)
        check_restrained(system)
        equations = EquilibriumEquations(system, stats, t=t)
        check_factor_fits(needed, equations.seed)
        if not equations.loads:
            raise InputError("the scene has no loads, so there is no path to follow: add some")
        stats.seconds["set-up"] = time.perf_counter() - begin
        try:
            found = follow(equations, to, points, tolerance, int(branch))
        except NotFoundError as lost:
            r = equations.state(lost.state.q, lost.state.lam, lost.load).r
            worst = int(np.argmax(np.abs(np.nan_to_num(r, nan=np.inf))))
            raise EquilibriumError(
                f"the path cannot be followed any further, {lost.reason}",
                lost.load,
                abs(float(r[worst])),
                system.describe(worst),
                system.unit(worst),
                "Take a finer mesh, or add a small load that decides between branches of the path.",
            ) from None
    stats.march_seconds = time.perf_counter() - begin - stats.seconds["set-up"]
    return LoadPath(
        system,
        np.array([each.load for each in found.all]),
        np.stack([each.state.q for each in found.all]),
        np.stack([each.state.lam for each in found.all]),
        np.array([each.negative for each in found.all]),
        np.array(found.turns, dtype=int),
        np.array(found.forks, dtype=int),
        found.arrived,
        stats,
        t,
    )
