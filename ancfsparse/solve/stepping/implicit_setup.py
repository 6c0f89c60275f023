"""Set up an implicit run: seed, compiled loops, convergence criterion."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.integrators import Implicit
from ancfsparse.integrators.implicit.time_integration import make_time_loop
from ancfsparse.nonlinear import Method, ModifiedNewton, Newton
from ancfsparse.nonlinear.iteration import Costs, make_inverse, make_iteration, rotate_with_frame
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve import initial_conditions, preparation
from ancfsparse.solve.initial_conditions.consistent_state import regularize, starting_state
from ancfsparse.solve.initial_conditions.restart import (
    continues_run,
    restore_contributions,
    restore_state,
)
from ancfsparse.solve.preparation.choose_factorization import (
    make_complete_seed,
    make_seed,
    max_fill,
)
from ancfsparse.solve.preparation.choose_solver import choose_solver
from ancfsparse.solve.preparation.convergence_criterion import ConvergenceCriterion
from ancfsparse.solve.preparation.memory_estimate import NO_MEMORY, MemoryEstimate
from ancfsparse.solve.preparation.threads import divide_among_threads
from ancfsparse.solve.stepping.energy_rounding import estimate_energy_rounding
from ancfsparse.system import System
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.rigid_motion.corotated_frames import make_corotated_frame

if TYPE_CHECKING:
    from ancfsparse.abi.nodal_frames import Frame
    from ancfsparse.integrators.interface.time_loops import NewmarkLoop
    from ancfsparse.nonlinear.loop_protocols import NonlinearLoop
    from ancfsparse.seeds import Fill, Seed


# The sums for it cost a pendulum of ten elements 6 to 10 % of its instructions.
MIN_EXTRAPOLATED_UNKNOWNS = 1000  # unknowns from which accelerations are extrapolated
# About the cube root of rounding, where rounding and truncation errors are alike.
DIFFERENCE_STEP = 1e-6  # step of finite differences over the size of an unknown


class ImplicitSetup(NamedTuple):
    """Parts of an implicit run."""

    time_loop: NewmarkLoop
    iteration: NonlinearLoop
    seed: Seed  # the initial inverse of corrections
    criterion: ConvergenceCriterion  # of a step
    why: str  # the method, with the reason for its choice
    a: Vector  # accelerations at the start, (n_all,) [m/s2, 1/s2]
    back: preparation.SwitchToDirect | None  # if an incomplete seed was selected by "auto"


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
    """Set up an implicit run.

    The seed is of a `kind` in `FACTORIZATIONS`, and must fit in memory together with the `needed`
    rest.  From the last `state` of a run with the same integrator and step, the run continues as if
    it had not been interrupted.
    """
    seed, groups = make_seed(system, kind, solver, threads, needed, dt)
    method, why = choose_solver(
        solver, seed, system.constraints.linear, lambda: _is_linkage(system)
    )
    is_low_memory = not isinstance(seed, SparseSeed) and isinstance(solver, str)
    scale = integrator.scale * dt**2
    regularize(system, scale)
    if not restore_contributions(state, system):
        system.reset_memory()
    start, a = starting_state(system, seed, integrator, dt, state)
    criterion = ConvergenceCriterion(system, integrator, tolerance)
    rounding = estimate_energy_rounding(system, criterion.stiffness, dt)
    time_loop = make_time_loop(system, dt, integrator, start, max_energy_gain, *rounding)
    restore_contributions(state, system)  # the time loop has reset them
    measures = criterion.at(dt).by_correction
    extrapolates = measures and _extrapolates(system, integrator, method, criterion, dt)
    time_loop.weigh(criterion.mass, criterion.total, measures, extrapolates)
    if system.prescribed:
        initial_conditions.prescribe_motions_of_loop(system, time_loop, a, start.lam)
    time_loop.prepare(system.inputs(np.array([system.t0 + dt]))[0])
    weights = np.concatenate([criterion.mass, np.zeros(system.n_multipliers)])
    is_paper = tolerance == "paper" and method.is_dense
    frame = None if method.frame == "fixed" else make_corotated_frame(system)
    inverse = make_inverse(
        method, seed, None if is_paper else weights, criterion.norm, criterion.smallest_change(dt)
    )
    iteration = make_iteration(
        time_loop,
        seed,
        inverse,
        method,
        criterion.at(dt),
        iteration_costs(system, integrator, seed, frame),
        frame,
        difference_steps(system) if method.by_differences else DIFFERENCE_STEP,
        sparing=is_low_memory,
    )

    def update_costs(other: SparseSeed) -> None:
        cost = iteration_costs(system, integrator, other, frame)
        iteration.set_costs(cost.iteration, cost.factor)

    if isinstance(seed, SparseSeed):
        seed.on_renewal = update_costs
    divide_among_threads(system, threads, time_loop, iteration, inverse)
    if continues_run(state, system, integrator, dt):
        restore_state(state, system, time_loop, iteration)
    if method.by_differences:
        why += ", first inverse from finite differences"
    if groups is not None:
        limit = max_fill(system)
        why += f"; a complete one would have more than {limit:g} blocks for each of the matrix"
    if groups is None:
        return ImplicitSetup(time_loop, iteration, seed, criterion, why, a, None)

    def take_complete() -> Seed:
        complete = make_complete_seed(system, threads)
        complete.on_renewal = update_costs
        used = ModifiedNewton(seed_frame=method.frame) if is_low_memory else method
        noise = criterion.smallest_change(dt)
        inverse = make_inverse(used, complete, weights, criterion.norm, noise)
        inverse.set_threads(threads)
        cost = iteration_costs(system, integrator, complete, frame)
        rotated = rotate_with_frame(inverse, used, frame)
        iteration.take_seed(complete, rotated, True, cost.iteration, cost.factor)
        return complete

    assert not isinstance(seed, SparseSeed)
    back = preparation.SwitchToDirect(
        groups, lambda other: iteration_costs(system, integrator, other, None), seed, take_complete
    )
    return ImplicitSetup(time_loop, iteration, seed, criterion, why, a, back)


def _extrapolates(
    system: System, integrator: Implicit, method: Method, criterion: ConvergenceCriterion, dt: float
) -> bool:
    """Return whether steps may start from an extrapolated acceleration.

    Fewer corrections then leave a larger part of the allowed error: along stiff bodies that does
    work of one sign.  Newton's method needs as many corrections either way, since it converges
    quadratically.
    """
    return (
        system.n_free >= MIN_EXTRAPOLATED_UNKNOWNS
        and not system.n_multipliers
        and not integrator.keeps_energy
        and not isinstance(method, Newton)
        and criterion.inertia_leads(dt)
    )


def _is_linkage(system: System) -> bool:
    """Return whether a scene consists of rigid bodies whose joints let them move."""
    if any(body.n_elements for body in system.scene.bodies):
        return False
    if system.n_free > system.n_multipliers:
        return True
    n_redundant = initial_conditions.find_redundant_constraints(system, system.q0)[0]
    return system.n_multipliers - n_redundant < system.n_free


def difference_steps(system: System) -> Vector:
    """Return the steps of coordinates for finite differences, shape (n,).

    A millionth of an element for positions [m], a millionth for slopes [-].  Those of multipliers
    are found by `finite_difference`.
    """
    steps = np.full(system.n_free + system.n_multipliers, DIFFERENCE_STEP)
    for body, indices in zip(system.scene.bodies, system.vectors("r"), strict=True):
        steps[indices[indices < system.n_free]] = DIFFERENCE_STEP * body.shortest
    return steps


def iteration_costs(
    system: System, integrator: Implicit, seed: Seed | Fill, frame: Frame | None
) -> Costs:
    """Return the costs of an iteration and a seed by the kernels that an integrator calls.

    Contributions are assumed to take as many operations in the matrix as in the residual.
    """
    residual, tangent = (
        sum(calls * system.operations(kernel) for kernel, calls in kernels.items())
        for kernels in (integrator.residual_kernels, integrator.matrix_kernels)
    )
    others = sum(each.operations() for each in system.contributions)
    return Costs.from_counts(residual + others, tangent + others, seed, frame)
