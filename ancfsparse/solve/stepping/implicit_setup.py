"""Set up an implicit run: seed, compiled loops, convergence criterion."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.integrators import Implicit
from ancfsparse.integrators.implicit.time_integration import make_march
from ancfsparse.nonlinear import Method, ModifiedNewton, Newton
from ancfsparse.nonlinear.iteration import Costs, make_inverse, make_iteration, turned
from ancfsparse.seeds import Fill, IncompleteSeed, Seed, SparseSeed
from ancfsparse.solve import initial_conditions
from ancfsparse.solve.initial_conditions.consistent_state import regularize, starting_state
from ancfsparse.solve.initial_conditions.restart import (
    continues_run,
    restore_contributions,
    restore_state,
)
from ancfsparse.solve.preparation.choose_factorization import make_seed, max_fill
from ancfsparse.solve.preparation.choose_solver import choose_solver
from ancfsparse.solve.preparation.memory_estimate import NO_MEMORY, MemoryEstimate
from ancfsparse.solve.preparation.switch_to_direct import SwitchToDirect
from ancfsparse.solve.preparation.threads import divide_among_threads
from ancfsparse.solve.stepping.convergence_criterion import ConvergenceCriterion
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.rigid_motion.corotated_frames import frame_of

if TYPE_CHECKING:
    from ancfsparse.abi.nodal_frames import Frame
    from ancfsparse.integrators.interface.time_loops import ControlledLoop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop

Vector = NDArray[np.float64]

# Unknowns from which accelerations are extrapolated: the sums for it cost a pendulum of ten
# elements 6 to 10 % of its instructions.
MIN_EXTRAPOLATED_UNKNOWNS = 1000
# By what share of their size unknowns are moved for finite differences: about the cube root of
# rounding, where its error and that of cutting the series off are alike.
DIFFERENCE_STEP = 1e-6


class ImplicitSetup(NamedTuple):
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
        Leads to a complete seed where an incomplete one was chosen.
    """

    march: ControlledLoop
    iteration: NonlinearLoop
    seed: Seed
    criterion: ConvergenceCriterion
    why: str
    a: Vector
    back: SwitchToDirect | None


def prepare_implicit(
    system: System,
    dt: float,
    integrator: Implicit,
    solver: Method | str,
    tolerance: str | float,
    max_energy_gain: float,
    threads: int = 1,
    needed: MemoryEstimate = NO_MEMORY,
    kind: str = "complete",
    state: State | None = None,
) -> ImplicitSetup:
    """Set an implicit run up.

    The seed is of a kind of `SEEDS`.  A factor is refused if it does not fit in memory together
    with what else is `needed`.  From the last `state` of a run with the same integrator and step,
    the run continues as if it had not been interrupted.
    """
    pattern = system.pattern
    seed, groups = make_seed(system, kind, solver, threads, needed, dt)
    method, why = choose_solver(
        solver, seed, system.constraints.linear, lambda: _is_linkage(system)
    )
    sparing = isinstance(seed, IncompleteSeed) and isinstance(solver, str)
    scale = integrator.scale * dt**2
    regularize(system, scale)
    if not restore_contributions(state, system):
        system.forget()
    start, a = starting_state(system, seed, integrator, dt, state)
    criterion = ConvergenceCriterion(system, integrator, tolerance)
    march = make_march(system, dt, integrator, start, max_energy_gain, criterion.noise(dt))
    restore_contributions(state, system)  # the march has begun them
    measures = criterion.at(dt).by_correction
    extrapolates = measures and _extrapolates(system, integrator, method, criterion, dt)
    march.weigh(criterion.mass, criterion.total, measures, extrapolates)
    if system.prescribed:
        initial_conditions.prescribe_motions_of_loop(system, march, a, start.lam)
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
        iteration_costs(system, integrator, seed, frame),
        frame,
        difference_steps(system) if method.by_differences else DIFFERENCE_STEP,
        sparing=sparing,
    )
    divide_among_threads(system, threads, march, iteration, inverse)
    if continues_run(state, system, integrator, dt):
        restore_state(state, system, march, iteration)
    if method.by_differences:
        why += ", first inverse from finite differences"
    if groups is not None:
        most = max_fill(system)
        why += f"; a complete one would have more than {most:g} blocks for each of the matrix"
    if groups is None:
        return ImplicitSetup(march, iteration, seed, criterion, why, a, None)

    def take_exact() -> Seed:
        exact = SparseSeed(pattern.indptr, pattern.indices, system.n_free, threads)
        own = ModifiedNewton(seed_frame=method.frame) if sparing else method
        inverse = make_inverse(own, exact, weights, criterion.norm, criterion.smallest_change(dt))
        inverse.set_threads(threads)
        cost = iteration_costs(system, integrator, exact, frame)
        iteration.take_seed(exact, turned(inverse, own, frame), True, cost.iteration, cost.seed)
        return exact

    assert isinstance(seed, IncompleteSeed)
    back = SwitchToDirect(
        groups, lambda each: iteration_costs(system, integrator, each, None), seed, take_exact
    )
    return ImplicitSetup(march, iteration, seed, criterion, why, a, back)


def _extrapolates(
    system: System, integrator: Implicit, method: Method, criterion: ConvergenceCriterion, dt: float
) -> bool:
    """Whether steps may start from an acceleration extrapolated from its last changes.

    Fewer corrections then leave more of what a step may leave: along stiff bodies that does work of
    one sign.  Newton's method makes as many corrections either way:
    its errors are squares of the last.
    """
    return (
        system.n_free >= MIN_EXTRAPOLATED_UNKNOWNS
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
    return (
        system.n_multipliers - initial_conditions.find_redundant_constraints(system, system.q0)[0]
        < system.n_free
    )


def difference_steps(system: System) -> Vector:
    """Return by how much coordinates are moved for finite differences, shape (n,).

    Positions by a millionth of an element [m], slopes by a millionth [-].  Multipliers find their
    own, see `finite_difference`.
    """
    steps = np.full(system.n_free + system.n_multipliers, DIFFERENCE_STEP)
    for body, places in zip(system.scene.bodies, system.vectors("r"), strict=True):
        steps[places[places < system.n_free]] = DIFFERENCE_STEP * body.shortest
    return steps


def iteration_costs(
    system: System, integrator: Implicit, seed: Seed | Fill, frame: Frame | None
) -> Costs:
    """Weigh an iteration and a seed by the kernels that an integrator calls for them."""
    residual, tangent = (
        sum(times * system.operations(kernel) for kernel, times in kernels.items())
        for kernels in (integrator.residual_kernels, integrator.matrix_kernels)
    )
    return Costs.of(residual, tangent, seed, frame)
