"""The command ``ancfsparse pendulum``: one run of the pendulum of the paper."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from typing import Annotated, Any

import typer

from ancfsparse.checks import check_choice
from ancfsparse.dispatch import instruction_set
from ancfsparse.errors import InputError, Parameter
from ancfsparse.integrators import Explicit, Implicit, names
from ancfsparse.nonlinear import Method
from ancfsparse.nonlinear.methods import BY_NAME as METHODS, UPDATES
from ancfsparse.problems import pendulum
from ancfsparse.results import Trajectory
from ancfsparse.solve import simulate

INTEGRATORS = tuple(names.BY_NAME)
AUTO = "auto"
"""The default integrator of an error-controlled run: the cheapest one."""
DAMPING_OPTIONS = {"alpha": "--alpha", "rho_inf": "--rho-inf"}
"""Options of numerical damping by parameter."""
THICK = "thick"  # the element with a Poisson's ratio
POISSON = 0.3  # its default
SOLVERS = (*METHODS, "auto")
ELEMENT_OPTIONS = ("strain", "section_strain", "curvature")


@dataclass(frozen=True)
class PendulumRun:
    """Options of the command; None where one is left out."""

    element: Annotated[str, typer.Option(help="string, l2t2, thin or thick.")] = "thin"
    elements: Annotated[int, typer.Option(help="Number of elements.")] = 10
    dim: Annotated[
        int | None, typer.Option(help="2 or 3 [default: 3 for thick, 2 for the others].")
    ] = None
    step: Annotated[
        float, typer.Option(help="Time step, or with --accuracy the interval of saved states [s].")
    ] = 5e-4
    time: Annotated[float, typer.Option(help="Final time [s], an integral number of steps.")] = 2.0
    integrator: Annotated[
        str | None,
        typer.Option(
            help=", ".join(INTEGRATORS)
            + " [default: newmark; with --accuracy the cheapest one, which is printed]."
        ),
    ] = None
    accuracy: Annotated[
        float | None,
        typer.Option(help="Largest time discretization error of a position [m]."),
    ] = None
    solver: Annotated[
        str | None,
        typer.Option(help=", ".join(SOLVERS) + " [default: davidon; auto with --accuracy]."),
    ] = None
    memory: Annotated[
        str | None,
        typer.Option(help="'full' or a number of secant pairs, for quasi-Newton [default: full]."),
    ] = None
    factorization: Annotated[
        str | None,
        typer.Option(help="auto, complete or incomplete, for the iteration matrix."),
    ] = None
    alpha: Annotated[
        float | None,
        typer.Option(help="Numerical damping of Newmark's method [0] or HHT's [0.05]."),
    ] = None
    rho_inf: Annotated[
        float | None,
        typer.Option(help="Spectral radius of generalized-alpha at infinite frequency [0.9]."),
    ] = None
    tolerance: Annotated[
        str | None,
        typer.Option(
            help="'paper': residual below 1e-6. 'default': a small fraction of a step's change. "
            "A number: largest error of the accelerations [m/s2] "
            "[default: paper; default with --accuracy]."
        ),
    ] = None
    nu: Annotated[float | None, typer.Option(help="Poisson's ratio, for thick [default: 0.3].")] = (
        None
    )
    strain: Annotated[str | None, typer.Option(help="green or biot, for thin.")] = None
    section_strain: Annotated[str | None, typer.Option(help="consistent or nodal, for thick.")] = (
        None
    )
    curvature: Annotated[str | None, typer.Option(help="axis or section, for thick.")] = None
    save_every: Annotated[int, typer.Option(help="Steps between saved states.")] = 1
    output: Annotated[
        str | None, typer.Option(metavar="FILE", help="HDF5 file for all states.")
    ] = None


def run_pendulum(request: PendulumRun) -> tuple[Trajectory, dict[str, Any]]:
    """Simulate the pendulum, and summarise the run.

    Parameters
    ----------
    request : PendulumRun
        The arguments.

    Returns
    -------
    run : Trajectory
        The motion.
    summary : dict
        ``time`` (k,) [s], ``tip`` (k, dim) [m], ``march_seconds`` [s], ``steps``, ``iterations``,
        ``residual_evaluations``, ``factorizations``, ``energy_drift`` [-], ``estimated_error`` [m]
        of a run to an accuracy, and ``settings``, made of lists and numbers.
    """
    name = request.integrator or ("newmark" if request.accuracy is None else AUTO)
    request = replace(request, integrator=name)
    integrator = AUTO if name == AUTO else make_integrator(name, request)
    fixed = request.accuracy is None and name not in (AUTO, *names.EXPLICIT)
    solver = request.solver or ("davidon" if fixed else "auto")
    memory = request.memory or "full"
    check_options(request, solver)
    values = asdict(request)
    chosen = {each: values.pop(each) for each in ELEMENT_OPTIONS}
    options: dict[str, Any] = {each: value for each, value in chosen.items() if value is not None}
    nu = POISSON if request.nu is None else request.nu
    problem = pendulum(request.element, request.elements, request.dim, nu, **options)
    tolerance = request.tolerance or ("paper" if fixed else "default")
    run = simulate(
        problem.scene,
        request.time,
        request.step,
        accuracy=request.accuracy,
        integrator=integrator,
        solver=make_solver(solver, memory),
        factorization=request.factorization or "auto",
        tolerance=_number_or_name("tolerance", tolerance, ("paper", "default")),
        save_every=request.save_every,
        output=request.output,
    )
    settings = values | {
        "solver": solver,
        "tolerance": tolerance,
        **{
            each: getattr(integrator, each)
            for each in DAMPING_OPTIONS
            if each == damping_parameter(name)
        },
        "memory": memory if solver in UPDATES else None,
        "nu": nu if request.element == THICK else None,
    }
    settings |= options
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
    if request.accuracy is not None:
        summary["estimated_error"] = run.stats.error
    return run, summary


def check_options(request: PendulumRun, solver: str) -> None:
    """Refuse an option that does not apply to the selected method.

    Parameters
    ----------
    request : PendulumRun
        The arguments.
    solver : str
        Name of the nonlinear solver.
    """
    integrator = f"--integrator {request.integrator}"
    what_solves = f"--solver {solver}" + ("" if request.solver else ", the default here")
    implicit = request.integrator not in names.EXPLICIT
    solves = "--integrator generalized-alpha"
    for option, value, taken, owners, chosen in (
        ("--solver", request.solver, implicit or request.solver == "auto", solves, integrator),
        ("--tolerance", request.tolerance, implicit, solves, integrator),
        ("--factorization", request.factorization, implicit, solves, integrator),
        *((option, getattr(request, each), damping_parameter(request.integrator) == each,
           "--integrator " + " or ".join(n for n in INTEGRATORS if damping_parameter(n) == each),
           integrator) for each, option in DAMPING_OPTIONS.items()),
        ("--memory", request.memory, solver in UPDATES, "--solver " + " or ".join(UPDATES),
         what_solves),
        ("--nu", request.nu, request.element == THICK, f"--element {THICK}",
         f"--element {request.element}"),
    ):  # fmt: skip
        if value is not None and not taken:
            raise InputError(
                f"{option} {value} does not apply to {chosen}: leave it out, or take {owners}"
            )
    dense = solver in UPDATES and request.memory in (None, "full")
    if request.factorization == "incomplete" and request.accuracy is not None:
        raise InputError(
            f"--accuracy {request.accuracy:g} estimates errors with a complete factor: leave out "
            "--factorization incomplete, or --accuracy"
        )
    if request.factorization == "incomplete" and dense:
        raise InputError(
            "--factorization incomplete approximates a sparse factor, and the full memory of "
            f"{what_solves}, starts from the full inverse: add --memory 10, or take --solver auto"
        )
    if request.accuracy is not None and dense:
        raise InputError(
            f"--accuracy {request.accuracy:g} needs a factorization that is renewed during the "
            f"motion, and --solver {solver} with full memory keeps its first one: add --memory 10, "
            "or leave --solver out"
        )


def damping_parameter(name: str | None) -> str | None:
    """Return the name of the damping parameter of an integrator, or None."""
    return names.BY_NAME[name].damping if name in names.BY_NAME else None


def make_integrator(name: str, request: PendulumRun) -> Implicit | Explicit:
    """Return an integrator by name, with the requested or default damping."""
    check_choice("integrator", name, INTEGRATORS)
    damping = damping_parameter(name)
    return names.integrator_of(name, None if damping is None else getattr(request, damping))


def make_solver(name: str, memory: str = "full") -> Method | str:
    """Return a nonlinear solver by name.

    Parameters
    ----------
    name : str
        One of `SOLVERS`.
    memory : str, optional
        ``"full"`` or a number of pairs, for quasi-Newton methods.
    """
    check_choice("solver", name, SOLVERS)
    if name == "auto":
        return name
    if name not in UPDATES:
        return METHODS[name]()
    pairs = _number_or_name("memory", memory, ("full",))
    if isinstance(pairs, float):
        if not pairs.is_integer():
            raise InputError(f"memory must be 'full' or an integral number of pairs, got {memory}")
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
