"""One run of the paper's pendulum, as the command line asks for it."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field, replace
from typing import Any

from ancfsparse.checks import check_choice
from ancfsparse.dispatch import instruction_set
from ancfsparse.errors import InputError, Parameter
from ancfsparse.integrators import Explicit, Implicit, names
from ancfsparse.nonlinear import Method
from ancfsparse.nonlinear.methods import BY_NAME as METHODS
from ancfsparse.nonlinear.methods import UPDATES
from ancfsparse.problems import pendulum
from ancfsparse.results import Trajectory
from ancfsparse.solve import simulate

INTEGRATORS = tuple(names.BY_NAME)
AUTO = "auto"
"""The integrator of a run to an accuracy where none is given: whichever costs least."""
DAMPINGS = {"alpha": "--alpha", "rho_inf": "--rho-inf"}
"""Options of numerical damping by the parameter that they set."""
THICK, POISSON = "thick", 0.3
"""The element that has a Poisson's ratio, and its default."""
SOLVERS = (*METHODS, "auto")


@dataclass(frozen=True)
class PendulumRun:
    """What to run; the defaults are the paper's.

    Attributes
    ----------
    element : str
        ``"string"``, ``"l2t2"``, ``"thin"`` or ``"thick"``.
    elements : int
        Number of elements.
    dim : int or None
        2 or 3; None takes 3 for the thick beam and 2 for the cables.
    step, time : float
        Time step, or with an accuracy the time between saved states, and simulated time [s].
    integrator : str or None
        One of `INTEGRATORS`; None takes Newmark's, with an accuracy whichever costs least.
    accuracy : float or None
        Largest error that the steps may cause [m], instead of a fixed step.
    solver : str or None
        One of `SOLVERS`; None takes Davidon's where steps are fixed and implicit, else "auto".
    memory : str or None
        ``"full"`` or a number of secant pairs, for the quasi-Newton methods; None takes "full".
    factorization : str or None
        ``"auto"``, ``"complete"`` or ``"incomplete"``, as in `simulate`; None takes "auto".
    alpha : float or None
        Numerical damping of Newmark's method or HHT's; None takes 0 and 0.05 [-].
    rho_inf : float or None
        Numerical damping of generalised-alpha; None takes 0.9 [-].
    tolerance : str or None
        ``"paper"``, ``"default"`` or a number [m/s2]; None takes the paper's where steps are fixed
        and implicit.
    nu : float or None
        Poisson's ratio of the thick beam; None takes 0.3 [-].
    save_every : int
        Steps from one saved state to the next.
    output : str or None
        HDF5 file for all states.
    options : dict of str to str
        Options of the element that were given.
    """

    element: str = "thin"
    elements: int = 10
    dim: int | None = None
    step: float = 5e-4
    time: float = 2.0
    integrator: str | None = None
    accuracy: float | None = None
    solver: str | None = None
    memory: str | None = None
    factorization: str | None = None
    alpha: float | None = None
    rho_inf: float | None = None
    tolerance: str | None = None
    nu: float | None = None
    save_every: int = 1
    output: str | None = None
    options: dict[str, str] = field(default_factory=dict)


def run_pendulum(asked: PendulumRun) -> tuple[Trajectory, dict[str, Any]]:
    """Simulate and sum up.

    Parameters
    ----------
    asked : PendulumRun
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
    name = asked.integrator or ("newmark" if asked.accuracy is None else AUTO)
    asked = replace(asked, integrator=name)
    integrator = AUTO if name == AUTO else integrator_of(name, asked)
    fixed = asked.accuracy is None and name not in (AUTO, *names.EXPLICIT)
    solver = asked.solver or ("davidon" if fixed else "auto")
    memory = asked.memory or "full"
    check_options(asked, solver)
    options: dict[str, Any] = asked.options
    nu = POISSON if asked.nu is None else asked.nu
    problem = pendulum(asked.element, asked.elements, asked.dim, nu, **options)
    tolerance = asked.tolerance or ("paper" if fixed else "default")
    run = simulate(
        problem.scene,
        asked.time,
        asked.step,
        accuracy=asked.accuracy,
        integrator=integrator,
        solver=solver_of(solver, memory),
        factorization=asked.factorization or "auto",
        tolerance=_number_or_name("tolerance", tolerance, ("paper", "default")),
        save_every=asked.save_every,
        output=asked.output,
    )
    settings = asdict(asked) | {
        "solver": solver,
        "tolerance": tolerance,
        **{each: getattr(integrator, each) for each in DAMPINGS if each == damping_of(name)},
        "memory": memory if solver in UPDATES else None,
        "nu": nu if asked.element == THICK else None,
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
    if asked.accuracy is not None:
        summary["estimated_error"] = run.stats.error
    return run, summary


def check_options(asked: PendulumRun, solver: str) -> None:
    """Refuse an option that the chosen method does not take.

    Parameters
    ----------
    asked : PendulumRun
        The options given.
    solver : str
        What solves the steps.
    """
    integrator = f"--integrator {asked.integrator}"
    what_solves = f"--solver {solver}" + ("" if asked.solver else ", the default here")
    implicit = asked.integrator not in names.EXPLICIT
    solves = "--integrator generalized-alpha"
    for option, value, taken, owners, chosen in (
        ("--solver", asked.solver, implicit or asked.solver == "auto", solves, integrator),
        ("--tolerance", asked.tolerance, implicit, solves, integrator),
        ("--factorization", asked.factorization, implicit, solves, integrator),
        *((option, getattr(asked, each), damping_of(asked.integrator) == each,
           "--integrator " + " or ".join(n for n in INTEGRATORS if damping_of(n) == each),
           integrator) for each, option in DAMPINGS.items()),
        ("--memory", asked.memory, solver in UPDATES, "--solver " + " or ".join(UPDATES),
         what_solves),
        ("--nu", asked.nu, asked.element == THICK, f"--element {THICK}",
         f"--element {asked.element}"),
    ):  # fmt: skip
        if value is not None and not taken:
            raise InputError(
                f"{option} {value} does not apply to {chosen}: leave it out, or take {owners}"
            )
    dense = solver in UPDATES and asked.memory in (None, "full")
    if asked.factorization == "incomplete" and asked.accuracy is not None:
        raise InputError(
            f"--accuracy {asked.accuracy:g} estimates errors with a complete factor: leave out "
            "--factorization incomplete, or --accuracy"
        )
    if asked.factorization == "incomplete" and dense:
        raise InputError(
            "--factorization incomplete approximates a sparse factor, and the full memory of "
            f"{what_solves}, starts from the full inverse: add --memory 10, or take --solver auto"
        )
    if asked.accuracy is not None and dense:
        raise InputError(
            f"--accuracy {asked.accuracy:g} needs a factor that is renewed as the body moves, and "
            f"the full memory of --solver {solver} keeps its first: add --memory 10, or leave "
            "--solver out"
        )


def damping_of(name: str | None) -> str | None:
    """Return which parameter sets the numerical damping of an integrator, or None."""
    return names.BY_NAME[name].damping if name in names.BY_NAME else None


def integrator_of(name: str, asked: PendulumRun) -> Implicit | Explicit:
    """Return the integrator behind a name, with the damping that was given or its default."""
    check_choice("integrator", name, INTEGRATORS)
    damping = damping_of(name)
    return names.integrator_of(name, None if damping is None else getattr(asked, damping))


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
    if name not in UPDATES:
        return METHODS[name]()
    pairs = _number_or_name("memory", memory, ("full",))
    if isinstance(pairs, float):
        if not pairs.is_integer():
            raise InputError(f"memory must be 'full' or a whole number of pairs, got {memory}")
        pairs = int(pairs)
    return METHODS[name](memory=pairs)


def _number_or_name(what: str, text: str, names: tuple[str, ...]) -> str | float:
    if text in names:
        return text
    try:
        return float(text)
    except ValueError:
        listing = " or ".join(repr(each) for each in names)
        raise InputError(
            "{what} must be {listing} or a number, got {text!r}",
            what=Parameter(what),
            listing=listing,
            text=text,
        ) from None
