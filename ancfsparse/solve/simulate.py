"""Motion in time: set up once, march compiled, hand back a trajectory."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from tqdm import tqdm

from ancfsparse.errors import (
    EnergyGain,
    InputError,
    StepFailure,
    check_count,
    check_finite,
    check_positive,
)
from ancfsparse.integrators import Explicit, Implicit, Newmark
from ancfsparse.integrators.march import make_march
from ancfsparse.nonlinear import Method, Outcome, QuasiNewton
from ancfsparse.nonlinear.iteration import (
    EPSILON,
    Costs,
    make_inverse,
    make_iteration,
    tolerance_of,
)
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.scene import Node, Scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.blocks import BlockInverse
from ancfsparse.solve.choose import choose
from ancfsparse.solve.explicit import (
    check_alone,
    count_forces,
    instability,
    prepare_explicit,
)
from ancfsparse.solve.memory import check_fits, estimate
from ancfsparse.solve.record import Record, Recorder, buffer_rows, check_nodes, check_output
from ancfsparse.solve.start import check_constraints, regularize, starting_state
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Past this a double cannot count the steps exactly.
MOST_STEPS = 2.0**53

# Steps between two looks at the clock, and rows of loads that are tabulated at once: at most
# CHUNK, and of large systems so many that about so many coordinates move.
CHUNK, COORDINATES = 2000, 4_000_000


def simulate(
    scene: Scene,
    t_end: float,
    dt: float,
    *,
    integrator: Implicit | Explicit = Newmark(),
    solver: Method | str = "auto",
    tolerance: str | float = "default",
    max_energy_gain: float = 0.01,
    save_every: int = 1,
    save_nodes: Sequence[Node] | None = None,
    output: str | Path | None = None,
    progress: bool = False,
) -> Trajectory:
    """March a scene through time with a fixed step.

    Each step finds coordinates and multipliers such that the equations of motion and the position
    constraints hold together at the new time (equation 6 of the paper).

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads; the motion starts at t = 0 from the reference shape with the
        beams' initial velocities.
    t_end : float
        End time [s], a whole number of steps.
    dt : float
        Time step [s].
    integrator : Newmark, HHT, GeneralizedAlpha, CentralDifference or RungeKuttaNystrom, optional
        The trapezoidal rule by default.  The last two are explicit: they take no solver and no
        tolerance, joints by numbering, and steps no longer than `stable_step` returns.
    solver : "auto", Newton, ModifiedNewton or QuasiNewton, optional
        How the equations of a step are solved.
    tolerance : "default", "paper" or float, optional
        ``"paper"``: max|r| < 1e-6 N and max|phi| < 1e-6 m; for long stiff chains the rounding of
        the forces is a floor under the first.  A number [m/s2]: the error in the accelerations that
        the iteration of a step may leave, as estimated from its corrections, usually right within
        a factor of 10 (Davidon 50), and never below rounding, about 1e-15 |q| / dt^2;
        ``"default"`` is 1e-3.
    max_energy_gain : float, optional
        Share of the largest energy exchanged so far between motion, strain, gravity and loads by
        which the energy may exceed what was given, before the run is stopped [-]; ``inf`` never
        stops it.
    save_every : int, optional
        Steps from one saved state to the next; the last state is saved in any case.
    save_nodes : sequence of Node, optional
        Keep only position, velocity and acceleration of these points, such as ``[rod.end]``.
    output : str or Path, optional
        Write the states to this HDF5 file while the run lasts, instead of keeping them in memory;
        a file that exists is replaced.  `ancfsparse.results.load` opens it later.
    progress : bool, optional
        Whether to draw a progress bar.

    Returns
    -------
    Trajectory
        The saved states, the one at t = 0 first, with counts in ``stats``.

    Raises
    ------
    InputError
        If something said cannot be meant, or the run cannot fit in memory.
    StepFailure
        If a step cannot be solved; it carries the trajectory so far.
    Instability
        If an explicit run gains energy because its step has become too long for the motion.
    EnergyGain
        If the motion gains energy that nothing has given it, as the trapezoidal rule lets it where
        steps are large; it carries the trajectory too.

    Notes
    -----
    A step that does not converge is tried again with a new seed, then with damped Newton; both are
    counted in ``stats.recoveries``.  No step is accepted unconverged.
    """
    n_steps = count_steps(t_end, dt)
    check_count("save_every", save_every)
    if not isinstance(integrator, Implicit | Explicit):
        raise InputError(
            "integrator must be Newmark(alpha), HHT(alpha), GeneralizedAlpha(rho_inf), "
            f"CentralDifference() or RungeKuttaNystrom(order), got {integrator!r}"
        )
    check_gain(max_energy_gain)
    check_nodes(save_nodes)
    check_output(output)
    begin = time.perf_counter()
    rows = -(-n_steps // save_every) + 1
    kept = None if save_nodes is None else len(save_nodes)
    check_fits(estimate(scene, rows, kept, output is not None, solver))
    system = System(scene)
    settings = {
        "dt": dt,
        "t_end": t_end,
        "integrator": repr(integrator),
        "solver": repr(solver),
        "tolerance": tolerance,
        "max_energy_gain": max_energy_gain,
        "save_every": save_every,
    }
    record = Record(system, rows, save_nodes, output, settings)
    iteration, nodes = None, np.ones(1)
    seed: SparseSeed | BlockInverse
    if isinstance(integrator, Explicit):
        check_alone(integrator, solver, tolerance)
        march, seed, why = prepare_explicit(system, dt, n_steps, integrator, max_energy_gain)
        nodes = integrator.tableau.c[1:]
    else:
        march, iteration, seed, why = prepare(
            system, dt, integrator, solver, tolerance, max_energy_gain
        )
    stats = RunStats(solver=why, seconds={"set-up": time.perf_counter() - begin})
    with record.open() as recorder:
        outcome = _march(
            system,
            march,
            iteration,
            seed,
            nodes,
            n_steps,
            dt,
            save_every,
            recorder,
            stats,
            progress,
        )
        if isinstance(integrator, Explicit):
            count_forces(stats, integrator)
        else:
            count(stats, iteration)
        recorder.finish(stats)
    path = record.trajectory()
    if outcome != Outcome.CONVERGED and isinstance(integrator, Explicit):
        raise instability(system, march, seed, integrator, outcome, stats.steps, dt, path)
    if outcome == Outcome.GAINED_ENERGY:
        gain, exchanged = march.energy_gain
        reached = stats.steps * dt
        raise EnergyGain(gain, exchanged, max_energy_gain, reached, stats.steps, dt, path)
    if outcome != Outcome.CONVERGED:
        raise failure(system, march, outcome, stats.steps + 1, dt, path)
    return path


def _march(
    system: System,
    march: Any,
    iteration: Any,
    seed: SparseSeed | BlockInverse,
    nodes: Vector,
    n_steps: int,
    dt: float,
    save_every: int,
    recorder: Recorder,
    stats: RunStats,
    progress: bool,
) -> Outcome:
    """Take the steps of a run, pass on its states, count steps and seconds; say how it ended."""
    chunk = max(1, min(CHUNK, COORDINATES // system.n_all))
    room = buffer_rows(system.n_all, min(n_steps, chunk) // save_every + 1)
    buffer = [np.empty((room + 1, system.n_all)) for _ in range(3)]
    buffer.append(np.empty((room + 1, system.n_multipliers)))
    q, _, a, lam = march.state  # whose velocity is that of the integrator
    recorder.append(np.zeros(1), q[None], system.v0[None], a[None], lam[None])
    outcome = Outcome.CONVERGED
    with tqdm(total=n_steps, unit="step", disable=not progress, leave=False) as bar:
        while stats.steps < n_steps and outcome == Outcome.CONVERGED:
            since = stats.steps % save_every  # steps since the last saved state
            wanted = min(chunk, n_steps - stats.steps, room * save_every - since)
            times = dt * (np.arange(wanted, dtype=np.float64)[:, None] + stats.steps + nodes)
            amplitudes = system.loads.amplitudes(times.ravel())
            clock = time.perf_counter()
            taken, code = march.advance(iteration, wanted, amplitudes, save_every, since, *buffer)
            stats.march_seconds += time.perf_counter() - clock
            if seed.error is not None:
                raise seed.error
            new = slice(1, 1 + (since + taken) // save_every)
            saved = stats.steps // save_every + np.arange(new.start, new.stop, dtype=np.float64)
            recorder.append(dt * (save_every * saved), *(table[new] for table in buffer))
            stats.steps += taken
            outcome = Outcome(code)
            bar.update(taken)
    if stats.steps % save_every:  # the last state is kept whatever its number
        recorder.append(np.array([dt * stats.steps]), *(x[None] for x in march.state))
    return outcome


def check_gain(share: float) -> None:
    """Refuse what is not a share of energy; infinity is one."""
    if share != np.inf and check_finite("max_energy_gain", share) < 0.0:
        raise InputError(
            f"max_energy_gain must not be negative, got {share:g}: 0.01 is one percent"
        )


def count_steps(t_end: float, dt: float) -> int:
    """Return the number of steps of length ``dt`` that make ``t_end``.

    Raises
    ------
    InputError
        If either is not positive or the step does not divide the time.
    """
    check_positive("t_end", t_end, "s")
    check_positive("dt", dt, "s")
    if t_end / dt > MOST_STEPS:
        raise InputError(
            f"dt = {dt:g} s makes {t_end / dt:.3g} steps of t_end = {t_end:g} s: take a larger dt"
        )
    n_steps = round(t_end / dt)
    if n_steps < 1 or abs(n_steps * dt - t_end) > 1e-9 * t_end:
        n = max(n_steps, 1)
        raise InputError(
            f"dt = {dt:g} s does not divide t_end = {t_end:g} s into whole steps "
            f"({t_end / dt:.6g} of them): try t_end = {n * dt!r} s, or dt = {t_end / n!r} s"
        )
    return n_steps


def prepare(
    system: System,
    dt: float,
    integrator: Implicit,
    solver: Method | str,
    tolerance: str | float,
    max_energy_gain: float,
) -> tuple[Any, Any, SparseSeed, str]:
    """Return the compiled march and nonlinear loop, the seed, and why this method."""
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
    straight = system.constraints.linear
    method, why = choose(solver, seed.n, seed.solve_flops, straight=straight)
    scale = integrator.scale * dt**2
    regularize(system, scale)
    check_constraints(system)
    start = starting_state(system, seed, integrator, dt)
    force_scale, size = system.force_scale(system.q0), float(np.max(np.abs(system.q0)))
    noise = 100.0 * EPSILON * force_scale * size
    march = make_march(system, dt, integrator, start, max_energy_gain, noise)
    march.prepare(system.loads.amplitudes(np.array([dt])))
    weights = np.concatenate([system.mass_diagonal, np.zeros(system.n_multipliers)])
    inverse = make_inverse(method, seed, weights, 100.0 * EPSILON * scale * force_scale)
    iteration = make_iteration(
        march,
        seed,
        inverse,
        system.pattern.indptr,
        method,
        tolerance_of(tolerance, scale, force_scale, size),
        Costs.of(system.operations("residual"), system.operations("tangent"), seed),
    )
    if isinstance(method, QuasiNewton) and method.seed == "finite-difference":
        why += ", first inverse from finite differences"
    return march, iteration, seed, why


def count(stats: RunStats, iteration: Any) -> None:
    """Copy counts and times of the compiled loop."""
    counts = iteration.counts
    stats.iterations = counts["iterations"]
    stats.last_corrections = counts["last_corrections"]
    stats.residual_evaluations = counts["residual_evaluations"]
    stats.factorizations = counts["factorizations"]
    stats.indefinite = counts["indefinite"]
    stats.solves = counts["solves"]
    stats.skipped_pairs = counts["skipped_pairs"]
    stats.recoveries = counts["recoveries_reseed"] + counts["recoveries_newton"]
    parts = iteration.seconds
    if parts:
        stats.seconds |= parts | {"rest": stats.march_seconds - sum(parts.values())}


def failure(
    system: System, march: Any, outcome: Outcome, step: int, dt: float, path: Trajectory
) -> StepFailure:
    """Name the place where the last iterate is furthest from balance."""
    r, phi = march.unbalanced
    worst = int(np.argmax(np.abs(np.nan_to_num(r[: system.n_free], nan=np.inf))))
    where, size = system.describe(worst), float(r[worst])
    if len(phi) and np.max(np.abs(phi)) > abs(size):
        worst = int(np.argmax(np.abs(phi)))
        where, size = system.constraints.labels[worst], float(phi[worst])
    reason = f"it {outcome.sentence}, also with a new seed and with damped Newton"
    return StepFailure(reason, step * dt, step, dt, size, where, path)
