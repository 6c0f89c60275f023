"""One run of the paper's pendulum, as the command line asks for it."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from typing import Any

from ancfsparse.dispatch import instruction_set
from ancfsparse.errors import InputError, check_choice
from ancfsparse.integrators import (
    HHT,
    CentralDifference,
    EnergyMomentum,
    Explicit,
    GeneralizedAlpha,
    Implicit,
    Newmark,
    RungeKuttaNystrom,
)
from ancfsparse.nonlinear import Method, ModifiedNewton, Newton, QuasiNewton
from ancfsparse.problems import pendulum
from ancfsparse.results import Trajectory
from ancfsparse.solve import simulate

INTEGRATORS = (
    *("newmark", "hht", "generalized-alpha", "energy-momentum"),
    *("central-difference", "rkn4", "rkn8"),
)
ALPHAS = {"newmark": 0.0, "hht": 0.05}
SOLVERS = ("newton", "modified-newton", "broyden", "davidon", "dfp", "bfgs", "auto")


@dataclass(frozen=True)
class PendulumRun:
    """What to run; the defaults are the paper's.

    Attributes
    ----------
    element : str
        ``"l2t2"``, ``"thin"`` or ``"thick"``.
    elements : int
        Number of elements.
    dim : int or None
        2 or 3; None takes 3 for the thick beam and 2 for the cables.
    step, time : float
        Time step, or with an accuracy the time between saved states, and simulated time [s].
    integrator : str
        One of `INTEGRATORS`.
    accuracy : float or None
        Largest error that the steps may cause [m], instead of a fixed step.
    solver : str or None
        One of `SOLVERS`; None takes Davidon's where steps are fixed and implicit, else "auto".
    memory : str
        ``"full"`` or a number of secant pairs; only the quasi-Newton methods have one.
    alpha : float or None
        Numerical damping of Newmark's method or HHT's; None takes 0 and 0.05 [-].
    rho_inf : float
        Numerical damping of generalised-alpha [-].
    tolerance : str or None
        ``"paper"``, ``"default"`` or a number [m/s2]; None takes the paper's where steps are fixed
        and implicit.
    nu : float
        Poisson's ratio [-].
    save_every : int
        Steps from one saved state to the next.
    options : dict of str to str
        Options of the element that were said.
    """

    element: str = "thin"
    elements: int = 10
    dim: int | None = None
    step: float = 5e-4
    time: float = 2.0
    integrator: str = "newmark"
    accuracy: float | None = None
    solver: str | None = None
    memory: str = "full"
    alpha: float | None = None
    rho_inf: float = 0.9
    tolerance: str | None = None
    nu: float = 0.3
    save_every: int = 1
    options: dict[str, str] = field(default_factory=dict)


def run_pendulum(wish: PendulumRun) -> tuple[Trajectory, dict[str, Any]]:
    """Simulate and sum up.

    Parameters
    ----------
    wish : PendulumRun
        What to run.

    Returns
    -------
    run : Trajectory
        The motion.
    summary : dict
        ``time`` (k,) [s], ``tip`` (k, dim) [m], ``march_seconds`` [s], ``steps``, ``iterations``,
        ``residual_evaluations``, ``factorizations``, ``energy_drift`` [-], ``estimated_error`` [m]
        of a run to an accuracy, and ``settings``, made of lists and numbers.
    """
    options: dict[str, Any] = wish.options
    problem = pendulum(wish.element, wish.elements, wish.dim, wish.nu, **options)
    alpha = ALPHAS.get(wish.integrator, 0.0) if wish.alpha is None else wish.alpha
    integrator = integrator_of(wish.integrator, alpha, wish.rho_inf)
    fixed = wish.accuracy is None and isinstance(integrator, Implicit)
    solver = wish.solver or ("davidon" if fixed else "auto")
    tolerance = wish.tolerance or ("paper" if fixed else "default")
    run = simulate(
        problem.scene,
        wish.time,
        wish.step,
        accuracy=wish.accuracy,
        integrator=integrator,
        solver=solver_of(solver, wish.memory),
        tolerance=_number_or_name("tolerance", tolerance, ("paper", "default")),
        save_every=wish.save_every,
    )
    settings = asdict(wish) | {
        "solver": solver,
        "tolerance": tolerance,
        "alpha": alpha,
    }
    settings |= settings.pop("options")
    settings["dim"] = problem.scene.dim
    settings |= {"chosen": run.stats.solver, "instruction_set": instruction_set()}
    summary = {
        "time": run.t.tolist(),
        "tip": run.position(problem.rod.end).tolist(),
        "march_seconds": run.stats.march_seconds,
        "steps": run.stats.steps,
        "iterations": run.stats.iterations,
        "residual_evaluations": run.stats.residual_evaluations,
        "factorizations": run.stats.factorizations,
        "energy_drift": run.energy.drift,
        "settings": settings,
    }
    if wish.accuracy is not None:
        summary["estimated_error"] = run.stats.error
    return run, summary


def integrator_of(name: str, alpha: float = 0.0, rho_inf: float = 0.9) -> Implicit | Explicit:
    """Return the integrator behind a name of the command line.

    Parameters
    ----------
    name : str
        One of `INTEGRATORS`.
    alpha, rho_inf : float, optional
        Damping, read by those that have one [-].
    """
    check_choice("integrator", name, INTEGRATORS)
    if name == "newmark":
        return Newmark(alpha)
    if name == "hht":
        return HHT(alpha)
    if name == "generalized-alpha":
        return GeneralizedAlpha(rho_inf)
    if name == "energy-momentum":
        return EnergyMomentum()
    if name == "central-difference":
        return CentralDifference()
    return RungeKuttaNystrom(int(name.removeprefix("rkn")))


def solver_of(name: str, memory: str = "full") -> Method | str:
    """Return the method behind a name of the command line.

    Parameters
    ----------
    name : str
        One of `SOLVERS`.
    memory : str, optional
        ``"full"`` or a number of pairs, read only by the quasi-Newton methods.
    """
    check_choice("solver", name, SOLVERS)
    if name == "auto":
        return name
    if name == "newton":
        return Newton()
    if name == "modified-newton":
        return ModifiedNewton()
    pairs = _number_or_name("memory", memory, ("full",))
    if isinstance(pairs, float):
        if not pairs.is_integer():
            raise InputError(f"memory must be 'full' or a whole number of pairs, got {memory}")
        pairs = int(pairs)
    return QuasiNewton(name, memory=pairs)


def _number_or_name(what: str, text: str, names: tuple[str, ...]) -> str | float:
    if text in names:
        return text
    try:
        return float(text)
    except ValueError:
        listing = " or ".join(repr(each) for each in names)
        raise InputError(f"{what} must be {listing} or a number, got {text!r}") from None
