"""Set a run up, count it, and report what went wrong."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import (
    ConvergenceError,
    EnergyIncreaseError,
    Parameter,
    Sentence,
    StepError,
)
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.implicit.time_integration import make_march
from ancfsparse.nonlinear import Method, ModifiedNewton, Newton, Outcome, Rung
from ancfsparse.nonlinear.iteration import Costs, make_inverse, make_iteration, turned
from ancfsparse.results import Event, RunStats, Trajectory
from ancfsparse.seeds import Fill, IncompleteSeed, Seed, SparseSeed
from ancfsparse.solve.initial_conditions.consistent_state import regularize, starting_state
from ancfsparse.solve.initial_conditions.restart import continues, recall, recall_contributions
from ancfsparse.solve.preparation.choose_factorization import make_seed, most_fill
from ancfsparse.solve.preparation.choose_solver import choose
from ancfsparse.solve.preparation.memory_estimate import NOTHING, Memory
from ancfsparse.solve.preparation.switch_to_direct import WayBack
from ancfsparse.solve.preparation.threads import divide
from ancfsparse.solve.stepping.convergence_criterion import Criterion
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.rigid_motion.corotated_frames import frame_of

if TYPE_CHECKING:
    from ancfsparse.abi.nodal_frames import Frame
    from ancfsparse.integrators.interface.time_loops import ControlledLoop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop

Vector = NDArray[np.float64]

# Rungs of the ladder as the compiled loop numbers them.
CAUSES = {outcome: outcome.name.lower().replace("_", " ") for outcome in Outcome}
CAUSES[Outcome.WOULD_GAIN] = CAUSES[Outcome.GAINED_ENERGY]
# What a step that is taken in another way may cure.
CURABLE = (Outcome.TOO_MANY, Outcome.DIVERGED, Outcome.NOT_FINITE, Outcome.WOULD_GAIN)

# Unknowns from which accelerations are extrapolated: the sums for it cost a pendulum of ten
# elements 6 to 10 % of its instructions.
EXTRAPOLATED_FROM = 1000
# By what share of their size unknowns are moved for finite differences: about the cube root of
# rounding, where its error and that of cutting the series off are alike.
SMALL = 1e-6
# Where a run gained energy.
ON_ALL_THE_SAME = " max_energy_gain=inf goes on all the same."


class Prepared(NamedTuple):
    """What an implicit run consists of.

    Attributes
    ----------
    march, iteration
        Compiled loops of the integrator and of the nonlinear solver.
    seed : Seed
        The seed that corrections are solved with.
    criterion : Criterion
        The criterion for a solved step.
    why : str
        The method, and why this one.
    a : (n_all,) float
        Accelerations at the start [m/s2, 1/s2].
    back : WayBack or None
        Leads to an exact seed where an incomplete one was chosen.
    """

    march: ControlledLoop
    iteration: NonlinearLoop
    seed: Seed
    criterion: Criterion
    why: str
    a: Vector
    back: WayBack | None


def prepare(
    system: System,
    dt: float,
    integrator: Implicit,
    solver: Method | str,
    tolerance: str | float,
    max_energy_gain: float,
    threads: int = 1,
    needed: Memory = NOTHING,
    kind: str = "exact",
    state: State | None = None,
) -> Prepared:
    """Set an implicit run up.

    The seed is of a kind of `SEEDS`.  A factor is refused if it does not fit in memory together
    with what else is `needed`.  From the last `state` of a run with the same integrator and step,
    the run continues as if it had not been interrupted.
    """
    pattern = system.pattern
    seed, groups = make_seed(system, kind, solver, threads, needed, dt)
    method, why = choose(solver, seed, system.constraints.linear, lambda: _is_linkage(system))
    sparing = isinstance(seed, IncompleteSeed) and isinstance(solver, str)
    scale = integrator.scale * dt**2
    regularize(system, scale)
    if not recall_contributions(state, system):
        system.forget()
    start, a = starting_state(system, seed, integrator, dt, state)
    criterion = Criterion(system, integrator, tolerance)
    march = make_march(system, dt, integrator, start, max_energy_gain, criterion.noise(dt))
    recall_contributions(state, system)  # the march has begun them
    measures = criterion.at(dt).by_correction
    extrapolates = measures and _extrapolates(system, integrator, method, criterion, dt)
    march.weigh(criterion.mass, criterion.total, measures, extrapolates)
    if system.prescribed:
        from ancfsparse.solve.initial_conditions.prescribed_start import drive_march

        drive_march(system, march, a, start.lam)
    march.prepare(system.inputs(np.array([system.t0 + dt]))[0])
    weights = np.concatenate([criterion.mass, np.zeros(system.n_multipliers)])
    papers = tolerance == "paper" and method.is_dense
    frame = None if method.frame == "fixed" else frame_of(system)
    inverse = make_inverse(
        method, seed, None if papers else weights, criterion.norm, criterion.smallest_change(dt)
    )
    iteration = make_iteration(
        march,
        seed,
        inverse,
        method,
        criterion.at(dt),
        costs(system, integrator, seed, frame),
        frame,
        difference_steps(system) if method.by_differences else SMALL,
        sparing=sparing,
    )
    divide(system, threads, march, iteration, inverse)
    if continues(state, system, integrator, dt):
        recall(state, system, march, iteration)
    if method.by_differences:
        why += ", first inverse from finite differences"
    if groups is not None:
        most = most_fill(system)
        why += f"; an exact one would have more than {most:g} blocks for each of the matrix"
    if groups is None:
        return Prepared(march, iteration, seed, criterion, why, a, None)

    def take_exact() -> Seed:
        exact = SparseSeed(pattern.indptr, pattern.indices, system.n_free, threads)
        own = ModifiedNewton(seed_frame=method.frame) if sparing else method
        inverse = make_inverse(own, exact, weights, criterion.norm, criterion.smallest_change(dt))
        inverse.set_threads(threads)
        cost = costs(system, integrator, exact, frame)
        iteration.take_seed(exact, turned(inverse, own, frame), True, cost.iteration, cost.seed)
        return exact

    assert isinstance(seed, IncompleteSeed)
    back = WayBack(groups, lambda each: costs(system, integrator, each, None), seed, take_exact)
    return Prepared(march, iteration, seed, criterion, why, a, back)


def _extrapolates(
    system: System, integrator: Implicit, method: Method, criterion: Criterion, dt: float
) -> bool:
    """Whether steps may start from an acceleration extrapolated from its last changes.

    Fewer corrections then leave more of what a step may leave: along stiff bodies that does work of
    one sign.  Newton's method makes as many corrections either way:
    its errors are squares of the last.
    """
    return (
        system.n_free >= EXTRAPOLATED_FROM
        and not system.n_multipliers
        and not integrator.keeps_energy
        and not isinstance(method, Newton)
        and criterion.inertia_leads(dt)
    )


def _is_linkage(system: System) -> bool:
    """Whether a scene has rigid bodies only, and their joints let them move."""
    if any(body.n_elements for body in system.scene.bodies):
        return False
    if system.n_free > system.n_multipliers:
        return True
    from ancfsparse.solve.initial_conditions.redundant_constraints import (
        repeats,  # what few scenes need
    )

    return system.n_multipliers - repeats(system, system.q0)[0] < system.n_free


def difference_steps(system: System) -> Vector:
    """Return by how much coordinates are moved for finite differences, shape (n,).

    Positions by a millionth of an element [m], slopes by a millionth [-].  Multipliers find their
    own, see `finite_difference`.
    """
    steps = np.full(system.n_free + system.n_multipliers, SMALL)
    for body, places in zip(system.scene.bodies, system.vectors("r"), strict=True):
        steps[places[places < system.n_free]] = SMALL * body.shortest
    return steps


def costs(system: System, integrator: Implicit, seed: Seed | Fill, frame: Frame | None) -> Costs:
    """Weigh an iteration and a seed by the kernels that an integrator calls for them."""
    residual, tangent = (
        sum(times * system.operations(kernel) for kernel, times in kernels.items())
        for kernels in (integrator.residual_kernels, integrator.matrix_kernels)
    )
    return Costs.of(residual, tangent, seed, frame)


def count(stats: RunStats, iteration: NonlinearLoop, *seeds: Seed) -> None:
    """Copy counts and times of the compiled loop and its seeds."""
    counts = iteration.counts
    stats.iterations = counts["iterations"]
    stats.last_corrections = counts["last_corrections"]
    stats.residual_evaluations = counts["residual_evaluations"]
    stats.factorizations = counts["factorizations"]
    stats.indefinite = counts["indefinite"]
    stats.material_seeds = counts["material_seeds"]
    stats.rotating_seeds = counts["rotating_seeds"]
    stats.single_seeds = counts["single_seeds"]
    stats.shifted_seeds = counts["shifted_seeds"]
    stats.sweeps, stats.products = (
        sum(x) for x in zip(*(seed.inner for seed in seeds), strict=True)
    )
    stats.solves = counts["solves"]
    stats.pairs, stats.skipped_pairs = counts["pairs"], counts["skipped_pairs"]
    stats.recoveries = counts["recoveries_reseed"] + counts["recoveries_newton"]
    parts = iteration.seconds
    if parts:
        stats.seconds |= parts | {"rest": stats.march_seconds - sum(parts.values())}


def events(found: Iterable[tuple[int, int, int, float]], now: float, dt: float) -> list[Event]:
    """Return what was tried to save steps of a length, counted from those before the time `now`."""
    return [
        Event(step, now + step * dt, Rung(rung).words, CAUSES[Outcome(cause)], rate)
        for step, rung, cause, rate in found
    ]


def stopped(
    system: System,
    march: ControlledLoop,
    iteration: NonlinearLoop,
    outcome: Outcome,
    steps: int,
    now: float,
    dt: float,
    max_energy_gain: float,
    path: Trajectory | None,
    advice: str,
) -> StepError:
    """Return the error for a run that came to a time in a number of steps, and no further.

    Without a trajectory it was a run to an accuracy.
    """
    if outcome == Outcome.GAINED_ENERGY:
        gain, exchanged = march.energy_gain
        advice += ON_ALL_THE_SAME
        return EnergyIncreaseError(gain, exchanged, max_energy_gain, now, steps, dt, path, advice)
    if outcome == Outcome.HAD_GAINED:
        gain, motion, when = march.largest_gain
        advice += ON_ALL_THE_SAME
        return EnergyIncreaseError(
            gain, motion, max_energy_gain, now, steps, dt, path, advice, when
        )
    steps, now = steps + 1, now + dt
    if outcome == Outcome.WOULD_GAIN:
        gain, exchanged = march.refused_gain
        advice += ON_ALL_THE_SAME
        return EnergyIncreaseError(gain, exchanged, max_energy_gain, now, steps, dt, path, advice)
    # The place where the last iterate is furthest off.
    r, phi = march.unbalanced
    worst = int(np.argmax(np.abs(np.nan_to_num(r[: system.n_free], nan=np.inf))))
    where, size, unit = system.describe(worst), abs(float(r[worst])), system.unit(worst)
    if len(phi) and np.max(np.abs(phi)) > size:
        worst = int(np.argmax(np.abs(phi)))
        where, size, unit = system.constraints.labels[worst], abs(float(phi[worst])), "m"
    reason = f"it {outcome.sentence}, "
    if outcome == Outcome.TOO_MANY:
        reason = f"it did not converge in {iteration.max_iterations} iterations{{aside}}, "
    reason += (
        "however short it is"
        if path is None
        else "also with a new seed and with damped Newton, and from a start without acceleration"
    )
    if np.isfinite(iteration.contraction):
        reason += f"; the residual last changed by a factor of {iteration.contraction:.3g}"
    sentence = Sentence(reason, aside=Parameter("max_iterations", aside=True))
    return ConvergenceError(sentence, now, steps, dt, size, where, path, advice, unit)
