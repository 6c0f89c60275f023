"""Equilibrium path of a scene under growing and falling loads."""

from __future__ import annotations

import time
import warnings

import numpy as np

from ancfsparse.checks import check_count, check_finite, check_positive
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results import RunStats
from ancfsparse.results.solutions.load_path import LoadPath
from ancfsparse.scene import Scene, check_scene
from ancfsparse.solve.equilibrium_paths.arc_length import follow_path
from ancfsparse.solve.linearization.matrices import check_coupling
from ancfsparse.solve.linearization.rigid_body_modes import check_restrained
from ancfsparse.solve.preparation.memory_estimate import (
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.solve.statics.assemble import find_initial_state
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.solve.statics.load_stepping import equilibrium_error
from ancfsparse.solve.statics.newton_and_relaxation import NotFoundError
from ancfsparse.solve.statics.static_equilibrium import N_MATRICES, check_static_tolerance
from ancfsparse.system import System

MIN_LOAD_FACTOR = 1e-6  # final load factor


def load_path(
    scene: Scene,
    *,
    to: float = 1.0,
    t: float = 0.0,
    points: int = 500,
    tolerance: float = 1e-9,
    branch: int = 0,
) -> LoadPath:
    """Follow the equilibrium path of a scene from its stress-free shape past limit points.

    One factor scales all loads, gravity and prescribed motions, so the path continues where a frame
    snaps through or back.  Limit points are found to working accuracy.

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads; the joints must prevent all rigid motions.
    to : float, optional
        Load factor at which the path ends, when first reached [-].
    t : float, optional
        Time at which functions of time are evaluated [s].
    points : int, optional
        Largest number of points.
    tolerance : float, optional
        As in `solve_static` [-].
    branch : int, optional
        1 or -1: at the first bifurcation, such as the buckling load of a column, follow the branch
        along the buckling shape, to the side where its largest displacement is positive or
        negative.  0 goes straight on.

    Returns
    -------
    LoadPath
        Load factors, states, their stability, and limit points.  It is not `complete` if there were
        not enough points, or the load factor reached ten times the opposite of `to`.

    Raises
    ------
    InputError
        If an argument is invalid, there are no loads, a force that couples points is not `coupled`,
        or the factor cannot fit in memory.
    SingularSceneError
        If the joints leave a rigid motion free.
    EquilibriumError
        If the path cannot be continued.

    Warns
    -----
    PenetrationWarning
        If a contact is too soft for the loads.

    Notes
    -----
    Arc-length steps of the root mean square displacement, with corrections in the plane across
    the path (Ramm 1981).  At a bifurcation it goes straight on without `branch`; `stable` shows
    that.  If several shapes buckle at once, one of them is selected.  The theory is in
    docs/theory.md.
    """
    check_scene(scene)
    to = check_positive("to", to)
    if to < MIN_LOAD_FACTOR:
        raise InputError(
            f"to is a load factor of at least {MIN_LOAD_FACTOR:g}, got {to:g}: smaller ones are "
            "lost in rounding"
        )
    t = check_finite("t", t, "s")
    points = check_count("points", points)
    tolerance = check_static_tolerance(tolerance)
    if isinstance(branch, bool) or not isinstance(branch, int) or branch not in (-1, 0, 1):
        raise InputError(f"branch must be 1, -1 or 0, got {format_value(branch)}")
    moved = find_initial_state(scene, None)[1]
    if moved:
        raise InputError(
            f"load_path begins at the reference shape, but push_out=True {moved}: take "
            "quasi_static, or place the bodies apart"
        )
    begin = time.perf_counter()
    needed = estimate_memory(scene, points, matrices=N_MATRICES)
    stats = RunStats(solver="Newton along the arc length")
    with within_memory(needed):
        system = System(scene)
        check_restrained(system)
        equations = EquilibriumEquations(system, stats, t=t)
        check_factor_fits(needed, equations.seed)
        check_coupling(system, system.q_ref, system.loads.amplitudes(np.array([t]))[0])
        if not equations.loads:
            raise InputError("the scene has no loads, so there is no path to follow: add some")
        stats.seconds["set-up"] = time.perf_counter() - begin
        try:
            with system.equilibria(system.q_ref):
                path = follow_path(equations, to, points, tolerance, int(branch))
        except NotFoundError as failure:
            raise equilibrium_error(
                equations,
                failure,
                f"the path cannot be continued, {failure.reason}",
                "Take a finer mesh, or add a small load that selects a branch of the path.",
            ) from None
    stats.march_seconds = time.perf_counter() - begin - stats.seconds["set-up"]
    loads, q = (
        np.array([point.load for point in path.points]),
        np.stack([point.state.q for point in path.points]),
    )
    for warning in system.rest_warnings(q, lambda k: f"at the load factor {loads[k]:.4g},"):
        warnings.warn(warning, stacklevel=2)
    return LoadPath(
        system,
        loads,
        q,
        np.stack([point.state.lam for point in path.points]),
        np.array([point.negative for point in path.points]),
        np.array(path.limit_points, dtype=int),
        np.array(path.bifurcations, dtype=int),
        path.is_complete,
        stats,
        t,
    )
