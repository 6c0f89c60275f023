"""`simulate`: a run with a given step, to an accuracy, or to an error of a quantity by a plan."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ancfsparse import plans, solve
from ancfsparse.errors import InputError
from ancfsparse.integrators import Implicit
from ancfsparse.messages import format_value
from ancfsparse.nonlinear import Method
from ancfsparse.results import Equilibrium, Trajectory
from ancfsparse.scene import Point, Scene
from ancfsparse.solve.motion.arguments import DEFAULT_INTEGRATOR, check_request
from ancfsparse.system import State

if TYPE_CHECKING:
    from ancfsparse.integrators import Explicit

# Arguments for the equations of implicit steps, which other methods do not solve.
EQUATION_OPTIONS = frozenset({"solver", "factorization", "max_energy_gain", "max_halvings"})


def simulate(
    scene: Scene,
    t_end: float,
    dt: float | None = None,
    *,
    accuracy: float | None = None,
    integrator: Implicit | Explicit | str = "auto",
    solver: Method | str = "auto",
    factorization: str = "auto",
    tolerance: str | float = "default",
    max_energy_gain: float = 0.01,
    max_halvings: int | None = None,
    threads: int = 1,
    save_every: int | None = None,
    save_nodes: Sequence[Point] | None = None,
    output: str | Path | None = None,
    progress: bool = False,
    start: State | Equilibrium | str | None = None,
    quantity: Any = None,
    error: Any = None,
    checkpoint: int | str | Sequence[int] | None = None,
) -> Trajectory:
    """Integrate a scene in time, with a fixed step, to an accuracy, or to an error of a quantity.

    Each step computes coordinates and multipliers that satisfy the equations of motion and the
    position constraints together at the new time (equation 6 of the paper).

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads.
    t_end : float
        Time at the end [s], a whole number of steps after the start.
    dt : float
        Time step [s]; with ``accuracy`` the time between saved states, by default 1/200 of the run.
    accuracy : float, optional
        Tolerance for the position of a node at the saved times, for the error of time integration
        [m]; the error of the mesh adds to it.  Of a rigid body, points on its axes at the distance
        of its radius of gyration from the origin count too.  Complete motions with decreasing
        steps are compared, by the method with the least operation count, until the error of one is
        within the tolerance; ``stats.error`` is its estimate, and ``stats.solver`` names the
        method.
    integrator : Implicit, Explicit or "auto", optional
        `Newmark`, `HHT`, `GeneralizedAlpha`, `EnergyMomentum`, `CentralDifference`,
        `RungeKuttaNystrom` or `DormandPrince`.  ``"auto"`` is ``GeneralizedAlpha(0.9)``, or
        ``EnergyMomentum()`` if a rigid body, or the frame of reference, rotates by more than
        0.07 rad in the first step, which would let its energy grow; with an accuracy it is the
        cheapest of all, explicit ones included unless a solver is given.  The last three are
        explicit: they take no solver and no tolerance, and steps no longer than `stable_step`
        returns.  Only `DormandPrince` takes damping; it and `CentralDifference` take rigid bodies
        and joints with multipliers.
    solver : "auto", Newton, ModifiedNewton or QuasiNewton, optional
        Nonlinear solver of the equations of a step.
    factorization : {"auto", "complete", "incomplete"}, optional
        Linear solver of the corrections.  ``"complete"``: a complete factorization of the iteration
        matrix, whose fill-in grows with the size of a net or lattice.  ``"incomplete"``: a
        factorization without fill-in, with time and memory linear in the mesh, and a few steps of
        conjugate gradients if one sweep is not enough; for up to 500 multipliers.  ``"auto"``, with
        ``solver="auto"``: incomplete if a complete factor would have more than three times the
        blocks of the matrix (six times with multipliers), and complete from the time in the run
        when operation counts show that this costs less, or a step fails; with a given solver or
        accuracy, complete wherever that fits in memory.
    tolerance : "default", "paper" or float, optional
        Tolerance of the iteration of a step.  ``"default"``: a two-thousandth of the change of the
        accelerations in the step, which is less than a hundredth of the error of the integrator,
        and at most the residual that does work of a millionth of the kinetic energy; with
        `EnergyMomentum`, a fiftieth of that.  It is relative: independent of units, stiffness and
        gravity.  A number [m/s2]: root mean square over the scene of the residual forces over the
        masses, as estimated from the contraction, usually right within a factor of 10.  Neither is
        less than rounding, about 1e-16 max|q| / dt^2.  ``"paper"``: max|r| < 1e-6 N and max|phi| <
        1e-6 m; for long stiff chains the rounding of the forces is a lower bound for the first.
    max_energy_gain : float, optional
        Largest spurious increase of the energy during the run, relative to the largest energy
        exchanged so far between motion, strain, gravity and loads [-]; at the end, largest such
        increase in any checked step, relative to the largest kinetic energy.  The uncertainty in
        the work of a load that jumps within a step is tolerated.  ``inf`` disables the check.
    max_halvings : int, optional
        Maximum number of halvings of a step that cannot be solved, or only with a spurious increase
        of energy; each is listed in ``stats.events``.  By default 10 in scenes with contact, whose
        bodies begin to touch within steps; in others such a step ends the run.  Before that, other
        solvers than `Newton` repeat the last steps by Newton's method, which may avoid the failed
        step.  Only for implicit integrators with a fixed step.
    threads : int, optional
        Threads for systems of 16 000 unconstrained coordinates or more; smaller ones use one, and
        so do runs in a forked process, which has no other threads than the one that forked it
        (``stats.threads`` is the number used).  Runs with the same number repeat bit for
        bit.  More threads than the machine has are of no use.
    save_every : int, optional
        Steps from one saved state to the next, by default 1, and with a quantity as in `Plan.run`;
        the last state is always saved.
    save_nodes : sequence of Point, optional
        Save only position, velocity and acceleration of these points, such as ``[rod.end]``.
    output : str or Path, optional
        Write the states to this HDF5 file during the run, instead of keeping them in memory; the
        file of an earlier run is replaced, any other is not.  `ancfsparse.load` opens it later.
    progress : bool, optional
        Whether to show a progress bar.
    start : State, Equilibrium or "equilibrium", optional
        Initial state: ``run.last`` of an earlier run or file, at its time, or the result of
        `solve_static`, at rest at t = 0; ``"equilibrium"`` calls that.  Loads, joints, sections and
        materials may have changed since, the bodies and their stress-free shapes may not.  By
        default the motion starts at t = 0 from the stress-free shape with the initial velocities of
        the beams.

        If scene, integrator and ``dt`` are those of the earlier run, the second run continues with
        its accelerations, including those of the integrator, its multipliers, energy watch and load
        history.  Both together then equal one run: bit for bit with explicit integrators and with
        `Newton`, and within ``tolerance`` with solvers that keep a seed, because seeds and pairs
        are not carried over.  In all other cases positions and velocities are projected on the
        constraints, and the start is made consistent as at t = 0.
    quantity : Quantity or sequence of Quantity, optional
        Quantity of interest, such as ``ancf.position(rod.end)``, with an ``error``: mesh and step
        are selected as by `ancf.plan`, and the trajectory has the plan in ``plan``.  The plan may
        also choose equilibria, sums of modes or explicit steps, unless an integrator is given, or
        one of solver, factorization, max_energy_gain and max_halvings, which need
        ``GeneralizedAlpha(0.9)``.
    error : float, str or sequence of them, optional
        Largest error of the quantity, in its unit or such as ``"1 %"``, see `ancf.plan`.
    checkpoint : int, str or sequence of int, optional
        Write the full state next to the ``output``, so that `ancfsparse.resume` continues a run
        that was killed or interrupted: every number of steps, every time such as ``"30 s"``,
        ``"5 min"`` or ``"2 h"``, or after the steps in a list.  The matrix is factored again after
        a checkpoint.  The run therefore equals one that is resumed there to the last bit, on one
        thread, and one with other checkpoints within ``tolerance``; ``stats.checkpoints`` lists the
        steps, for a run that repeats it.  Not with an accuracy or an error.

    Returns
    -------
    Trajectory
        The saved states, beginning with the initial one, and counts in ``stats``.

    Raises
    ------
    InputError
        If an argument is invalid, or the run cannot fit in memory or on the disk.
    LoadError
        If a load that is a function of time raises an error or returns no load; it carries the
        trajectory up to the last step before.
    OutputError
        If the disk is full before the end; it carries the trajectory, as does everything that ends
        a run from outside, such as a KeyboardInterrupt: all accepted steps and their counts.
    StepError
        If a step cannot be solved; it carries the trajectory up to that step.
    AccuracyError
        If the error does not decrease to the accuracy.
    InstabilityError
        If the energy of an explicit run increases because its step has become too long.
    EnergyIncreaseError
        If the energy increases spuriously, as the trapezoidal rule permits with long steps; it
        carries the trajectory too.

    Runs to an accuracy shorten steps and begin again before they raise the last errors.  Any error
    carries the best complete motion, or the available part of the first.

    Notes
    -----
    A step that does not converge is attempted again with a new seed, then with full damped Newton,
    then from a start without the last acceleration; ``stats.recoveries`` counts these.  A difficult
    step whose solution would increase the energy is solved again by Newton, and from that start.
    Then it is halved, if allowed; otherwise the solution with the smallest increase is accepted
    tentatively, and the next regular check of the energy decides; a run that is stopped then ends
    before that step.  A solution whose energy only increases, in a motion that has lost some, is
    compared with others.  No step is accepted without convergence.
    """
    options: dict[str, Any] = {
        "solver": solver,
        "factorization": factorization,
        "max_energy_gain": max_energy_gain,
        "max_halvings": max_halvings,
        "threads": threads,
        "save_nodes": save_nodes,
        "output": output,
        "progress": progress,
    }
    every = 1 if save_every is None else save_every
    if quantity is None and error is None:
        options |= {"accuracy": accuracy, "integrator": integrator, "tolerance": tolerance}
        options["checkpoint"] = checkpoint
        return solve.simulate(scene, t_end, dt, save_every=every, start=start, **options)
    if quantity is None or error is None:
        given, missing = ("error", "quantity") if quantity is None else ("quantity", "error")
        raise InputError(
            f"simulate was given {given}=... but no {missing}: give both, as in "
            "quantity=ancf.position(rod.end), error=1e-3"
        )
    _check_free("accuracy", accuracy, accuracy is None)
    _check_free("start", start, start is None or isinstance(start, str))
    _check_free("checkpoint", checkpoint, checkpoint is None)
    _check_free("tolerance", tolerance, isinstance(tolerance, str) and tolerance == "default")
    check_request(
        scene,
        t_end,
        t_end if dt is None else dt,
        accuracy=None,
        integrator=integrator,
        tolerance="default",
        save_every=every,
        start=None,
        **options,
    )
    options["save_every"] = save_every
    options = {name: value for name, value in options.items() if not _is_default(name, value)}
    if integrator == "auto" and not EQUATION_OPTIONS.isdisjoint(options):
        integrator = DEFAULT_INTEGRATOR
    word = start if isinstance(start, str) else None
    selected = plans.plan(scene, t_end, quantity, error, dt=dt, integrator=integrator, start=word)
    return selected.run(**options)


def _is_default(name: str, value: object) -> bool:
    """Return True if an argument has its default, and the plan sets it or needs none."""
    default = (simulate.__kwdefaults__ or {})[name]
    return type(value) is type(default) and bool(value == default)


def _check_free(name: str, value: object, is_free: bool) -> None:
    """Refuse an argument that the plan of a run determines."""
    if not is_free:
        raise InputError(
            f"simulate was given an error, so a plan sets {name} by itself: leave "
            f"{name}={format_value(value)} out, or leave quantity and error out"
        )
