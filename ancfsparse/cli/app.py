"""The command ``ancfsparse``."""

from __future__ import annotations

import importlib.metadata
import inspect
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any, NoReturn

import typer

from ancfsparse import cli
from ancfsparse.cli.comparison import compare
from ancfsparse.cli.demo import demo
from ancfsparse.cli.files import animate, convert, info, plot, report, resume
from ancfsparse.cli.options import RunError, in_options
from ancfsparse.cli.pendulum import PendulumRun, run_pendulum
from ancfsparse.cli.scene_run import check, new, run
from ancfsparse.cli.scene_schema import schema
from ancfsparse.errors import AncfError, InputError
from ancfsparse.file_names import check_target
from ancfsparse.kernels.building import build_element

EXIT_FAILURE = 1  # a run failed
EXIT_INPUT = 2  # an argument is invalid

app = typer.Typer(
    name="ancfsparse",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
for command in (
    demo,
    run,
    resume,
    check,
    new,
    schema,
    info,
    plot,
    animate,
    convert,
    report,
    compare,
):
    app.command()(command)


@app.command()
def element(
    file: Annotated[
        Path,
        typer.Argument(help="Python file with ELEMENT = Element(...), which declares the energy."),
    ],
    out: Annotated[Path, typer.Option(help="Folder of the package.")] = Path(),
    instruction_set: Annotated[
        list[str] | None,
        typer.Option(
            help="x86_64, x86_64_v3, x86_64_v4 or, on ARM, aarch64; may be repeated "
            "[default: of this processor]."
        ),
    ] = None,
) -> None:
    """Build a user element from its energy: a package with an ELEMENT for add_beam."""
    package = build_element(file, out, instruction_set or ())
    typer.echo(
        f"written: {package}\n"
        f"with {out.absolute()} in PYTHONPATH: from {package.name} import ELEMENT"
    )


@app.command()
def plan(
    scene: Annotated[
        str, typer.Argument(help="pendulum, twisted, line, net, pull, whip or twang.")
    ] = "pendulum",
    error: Annotated[
        str | None,
        typer.Option(help="Largest error: a number [m] or a fraction such as '1 %'."),
    ] = None,
    run: Annotated[
        bool, typer.Option(help="Run the plan, and verify it with a finer model.")
    ] = True,
    compare: Annotated[
        bool, typer.Option("--compare", help="Compare the pendulum with the method of the paper.")
    ] = False,
) -> None:
    """Select element, mesh and time step of a scene for a requested error of a point."""
    with in_options():
        planned = cli.plan_scene(scene, error)
        results = [planned, planned.run(verify=True)] if run else [planned]
        typer.echo("\n".join(map(str, results)))
        if compare:
            for element in cli.ELEMENTS:
                typer.echo(str(cli.compare_with_paper(element, cli.ERROR)))


def check_writable(target: str | None) -> str | None:
    """Refuse a file in a missing folder, or with results, before the run."""
    if target is not None and target != "-":
        check_target("--json", target, ())
    return target


def _print_version(is_requested: bool) -> None:
    if is_requested:
        typer.echo(f"ancfsparse {importlib.metadata.version('ancfsparse')}")
        raise typer.Exit


@app.callback()
def _common(
    version: Annotated[
        bool,
        typer.Option(
            "--version", help="Print the version and exit.", callback=_print_version, is_eager=True
        ),
    ] = False,
) -> None:
    """Simulate cables, beams and mechanisms by the absolute nodal coordinate formulation."""


JsonOption = Annotated[
    str | None,
    typer.Option(
        "--json",
        metavar="FILE",
        help="Write one JSON object to FILE; '-' prints it.",
        callback=check_writable,
    ),
]


def pendulum(json_to: str | None, **options: Any) -> None:
    """Simulate the flexible pendulum of the paper: a rod of 2 m that falls from rest."""
    with in_options():
        run, summary = run_pendulum(PendulumRun(**options))
    if json_to is None:
        tip = ", ".join(f"{x:.9f}" for x in summary["tip"][-1])
        typer.echo(f"{run!r}\n  tip at t = {run.t[-1]:.6g} s: ({tip}) m\n  {run.energy!r}")
    else:
        write_json(summary, json_to)


# Its options are the fields of the request.
pendulum.__signature__ = inspect.Signature(  # type: ignore[attr-defined]
    [
        *inspect.signature(PendulumRun, eval_str=True).parameters.values(),
        inspect.Parameter(
            "json_to", inspect.Parameter.KEYWORD_ONLY, default=None, annotation=JsonOption
        ),
    ]
)
app.command()(pendulum)


@app.command()
def problem(
    name: Annotated[str | None, typer.Argument(help="Name of a problem, see --list.")] = None,
    at: Annotated[str, typer.Option(help="Times [s], separated by commas.")] = "1",
    pairs: Annotated[
        list[str] | None, typer.Option("--set", metavar="KEY=VALUE", help="May be repeated.")
    ] = None,
    step: Annotated[
        float | None,
        typer.Option(help="Time step [s] [default: Richardson extrapolation from two steps]."),
    ] = None,
    accuracy: Annotated[
        float | None, typer.Option(help="Largest error of a position [m], instead of --step.")
    ] = None,
    threads: Annotated[
        int,
        typer.Option(
            help="Number of threads; runs with fewer than 16 000 free coordinates use one."
        ),
    ] = 1,
    names: Annotated[
        bool, typer.Option("--list", help="List problems, keys, quantities and reference values.")
    ] = False,
    json_to: JsonOption = None,
) -> None:
    """Solve a benchmark problem of rigid bodies and joints, and print quantities at some times."""
    if names or name is None:
        typer.echo(cli.list_problems())
        return
    with in_options():
        result = cli.run_problem(name, at, pairs or [], step, accuracy, threads)
    if json_to is not None:
        write_json(result, json_to)
        return
    for quantity, values in result["quantities"].items():
        for time, value in zip(result["time"], values, strict=True):
            typer.echo(f"{quantity} at {time:g} s: {value}")


def write_json(data: dict[str, Any], target: str) -> None:
    """Write one JSON object to a file, or to stdout if the target is ``"-"``."""
    text = json.dumps(data, allow_nan=False)
    if target == "-":
        typer.echo(text)
    else:
        Path(target).write_text(text + "\n", encoding="utf-8")


def main(arguments: Sequence[str] | None = None) -> None:
    """Run the command, and report an error by one line and an exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        Arguments of the command; by default those of the process.

    Notes
    -----
    Exit codes: 0; 1 if a run, an equilibrium or a plan failed; 2 if an argument is invalid.
    """
    run_app(app, "ancfsparse", arguments)


def run_app(program: typer.Typer, name: str, arguments: Sequence[str] | None = None) -> None:
    """Run a program of commands, with the exit codes of `main`.

    Parameters
    ----------
    program : typer.Typer
        The commands.
    name : str
        Name of the program in its help and its messages.
    arguments : sequence of str, optional
        Arguments; by default those of the process.
    """
    try:
        program(args=arguments, prog_name=name)
    except (InputError, OSError) as error:
        _exit(EXIT_INPUT, name, error)
    except AncfError as error:
        _exit(EXIT_FAILURE, name, error)
    except MemoryError as error:
        _exit(EXIT_FAILURE, name, RunError(f"the memory is exhausted: {error}"))


def _exit(code: int, name: str, error: Exception) -> NoReturn:
    print(f"{name}: {error}", file=sys.stderr)
    sys.exit(code)
