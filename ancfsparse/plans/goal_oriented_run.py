"""`simulate`: a run with a given step, to an accuracy, or to an error of a quantity by a plan."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ancfsparse import plans, solve
from ancfsparse.errors import InputError
from ancfsparse.integrators import Explicit, Implicit
from ancfsparse.messages import format_value
from ancfsparse.nonlinear import Method
from ancfsparse.results import Equilibrium, Trajectory
from ancfsparse.scene import Point, Scene
from ancfsparse.system import State


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
    max_halvings: int = 0,
    threads: int = 1,
    save_every: int = 1,
    save_nodes: Sequence[Point] | None = None,
    output: str | Path | None = None,
    progress: bool = False,
    start: State | Equilibrium | str | None = None,
    quantity: Any = None,
    error: Any = None,
) -> Trajectory:
    """March a scene through time, with a fixed step, to an accuracy, or to an error of a quantity.

    Each step finds coordinates and multipliers such that the equations of motion and the position
    constraints hold together at the new time (equation 6 of the paper).

    Parameters
    ----------
    scene : Scene
        Beams, joints and loads.
    t_end : float
        Time at the end [s], a whole number of steps after the start.
    dt : float
        Time step [s]; with ``accuracy`` the time between saved states, by default 1/200 of the run.
    accuracy : float, optional
        Largest error of the position of a node at the saved times that the steps in time may cause
        [m]; the error of the mesh comes on top.  Of a rigid body points on its axes count too, as
        far from its origin as its mass in the root mean square.  Whole motions with ever shorter
        steps are compared, by the method of least counted cost, until the error of one is
        small enough; ``stats.error`` is its estimate, and ``stats.solver`` names the method.
    integrator : Implicit, Explicit or "auto", optional
        `Newmark`, `HHT`, `GeneralizedAlpha`, `EnergyMomentum`, `CentralDifference`,
        `RungeKuttaNystrom` or `DormandPrince`.  ``"auto"`` is ``GeneralizedAlpha(0.9)``, or
        ``EnergyMomentum()`` where a rigid body, or the frame it is in, turns by more than 0.07 rad
        in the first step, which would let its energy grow; with an accuracy it is whichever costs
        least, explicit ones included where no solver is asked for.  The last three are explicit:
        they take no solver and no tolerance, and steps no longer than `stable_step` returns.  Only
        `DormandPrince` takes damping; it and `CentralDifference` take rigid bodies and joints with
        multipliers.
    solver : "auto", Newton, ModifiedNewton or QuasiNewton, optional
        How the equations of a step are solved.
    factorization : {"auto", "complete", "incomplete"}, optional
        What corrections are solved with.  ``"complete"``: the factor of the matrix of a step, which
        fills in the more the larger a net or lattice is.  ``"incomplete"``: a factor without fill,
        whose time and memory are linear in the mesh, with a few conjugate gradients where a sweep
        is too little; with up to 500 multipliers.  ``"auto"``, with ``solver="auto"``: incomplete
        where a complete factor would have more than three times the blocks of the matrix (six times
        with multipliers), and back to complete during the run where the counts show that this costs
        less, or where a step fails; with a given solver or accuracy, complete wherever that fits.
    tolerance : "default", "paper" or float, optional
        What the iteration of a step may leave.  ``"default"``: a two-thousandth of what the step
        changes in the accelerations, which is less than a hundredth of the integrator's own error,
        and no more than what does work of a millionth of the kinetic energy; with
        `EnergyMomentum` of a fiftieth of that.  It has no scale: any units, stiffness and gravity
        are treated alike.  A number [m/s2]: what is unbalanced of the forces over the masses, root
        mean square over the scene, as estimated from the contraction, usually right within a
        factor of 10.  Neither goes below rounding, about 1e-16 |q| / dt^2.  ``"paper"``:
        max|r| < 1e-6 N and max|phi| < 1e-6 m; for long stiff chains the rounding of the forces is a
        floor under the first.
    max_energy_gain : float, optional
        Share of the largest energy exchanged so far between motion, strain, gravity and loads by
        which the energy may exceed what was given, before the run is stopped [-]; at its end the
        share of the largest kinetic energy by which it may have done so in any step that was looked
        at.  What a jump of a load within a step leaves unsure is allowed.  ``inf`` never stops it.
    max_halvings : int, optional
        How often a step that cannot be solved, or only with a gain of energy, may be halved, to be
        crossed in shorter ones; each is listed in ``stats.events``.  By default such a step ends
        the run.  Only where equations are solved with a fixed step.
    threads : int, optional
        Threads that share the work of large systems, from 16 000 free coordinates on; smaller ones
        run on one, and so do runs in a forked process, where OpenMP would wait for ever for the
        threads of its parent (`stats.threads` is what was used).  Runs with the same number repeat
        bit for bit.  More than the machine has gain nothing.
    save_every : int, optional
        Steps from one saved state to the next; the last state is saved in any case.
    save_nodes : sequence of Point, optional
        Keep only position, velocity and acceleration of these points, such as ``[rod.end]``.
    output : str or Path, optional
        Write the states to this HDF5 file while the run lasts, instead of keeping them in memory;
        the file of an earlier run is replaced, any other is not.  `ancfsparse.load` opens
        it later.
    progress : bool, optional
        Whether to draw a progress bar.
    start : State, Equilibrium or "equilibrium", optional
        Where the motion starts: ``run.last`` of an earlier run or file, at its time, or what
        `solve_static` has returned, at rest at t = 0; ``"equilibrium"`` calls that.  Loads, joints,
        sections and materials may have changed since, the bodies and their stress-free shapes may
        not.  By default the motion starts at t = 0 from the stress-free shape with the initial
        velocities of the beams.

        If scene, integrator and ``dt`` are those of the run that came there, the second run goes
        on with its accelerations, those of the integrator itself included, with its multipliers,
        energy watch and course of the loads.  Then both together are the run in one: bit for bit
        with explicit integrators and with `Newton`, and with solvers that keep a seed but for what
        ``tolerance`` leaves, because seeds and pairs are not carried over.  In all other cases the
        start is made consistent as at t = 0, after positions and velocities have been put on the
        constraints.
    quantity : Quantity or sequence of Quantity, optional
        What is asked for, such as ``ancf.position(rod.end)``, with an ``error``: mesh and step are
        chosen as `ancf.plan` does, and the trajectory has the plan in ``plan``.
    error : float, str or sequence of them, optional
        Largest error of the quantity, in its unit or such as ``"1 %"``, see `ancf.plan`.

    Returns
    -------
    Trajectory
        The saved states, the one at the start first, with counts in ``stats``.

    Raises
    ------
    InputError
        If an argument is invalid, or the run cannot fit in memory or on the disk.
    LoadError
        If a load that is a function of time raises an error or returns no load; it carries the
        trajectory up to the last step before.
    OutputError
        If the disk is full before the end; it carries the trajectory, as everything does that ends
        a run from outside, such as a KeyboardInterrupt: all accepted steps and their counts.
    StepError
        If a step cannot be solved; it carries the trajectory so far.
    AccuracyError
        If the error does not come down to the accuracy.
    InstabilityError
        If an explicit run gains energy because its step has become too long for the motion.
    EnergyIncreaseError
        If the motion gains energy that nothing has given it, as the trapezoidal rule lets it where
        steps are large; it carries the trajectory too.

    Runs to an accuracy shorten steps and begin again before they raise the last errors.  Whatever
    ends them carries the best whole motion so far, or what there is of the first.

    Notes
    -----
    A step that does not converge is tried again with a new seed, then with Newton, damped and
    whole, then from a start without the last acceleration; these are counted in
    ``stats.recoveries``.  A hard step whose solution would gain energy is solved again by Newton,
    and from that start.  Then it is halved, if that is allowed; if not, the solution that gains
    least is accepted on trial, and the next regular check of the energy decides; a run that is then
    stopped ends before that step.  One whose energy only rises, in a motion that has lost some, is
    compared with others.  No step is accepted unconverged.
    """
    if quantity is None and error is None:
        return solve.simulate(
            scene,
            t_end,
            dt,
            accuracy=accuracy,
            integrator=integrator,
            solver=solver,
            factorization=factorization,
            tolerance=tolerance,
            max_energy_gain=max_energy_gain,
            max_halvings=max_halvings,
            threads=threads,
            save_every=save_every,
            save_nodes=save_nodes,
            output=output,
            progress=progress,
            start=start,
        )
    if quantity is None or error is None:
        given, missing = ("error", "quantity") if quantity is None else ("quantity", "error")
        raise InputError(
            f"simulate was given {given}=... but no {missing}: give both, as in "
            "quantity=ancf.position(rod.end), error=1e-3"
        )
    _check_free("accuracy", accuracy, accuracy is None)
    _check_free("start", start, start is None or isinstance(start, str))
    _check_free("tolerance", tolerance, isinstance(tolerance, str) and tolerance == "default")
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
    if not isinstance(save_every, int) or save_every != 1:
        options["save_every"] = save_every
    word = start if isinstance(start, str) else None
    selected = plans.plan(scene, t_end, quantity, error, dt=dt, integrator=integrator, start=word)
    return selected.run(**options)


def _check_free(name: str, value: object, is_free: bool) -> None:
    """Refuse an argument that the plan of a run determines."""
    if not is_free:
        raise InputError(
            f"simulate was given an error, so a plan sets {name} by itself: leave "
            f"{name}={format_value(value)} out, or leave quantity and error out"
        )
