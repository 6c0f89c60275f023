"""Commands on files of scenes: run, check and new."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path
from typing import Annotated, Any

import typer

from ancfsparse.checks import check_choice
from ancfsparse.cli.options import RunError, option_style
from ancfsparse.errors import AncfError, InputError
from ancfsparse.file_names import check_target
from ancfsparse.integrators import names
from ancfsparse.messages import format_value
from ancfsparse.nonlinear import Method
from ancfsparse.nonlinear.methods import BY_NAME as METHODS, ModifiedNewton, Newton, QuasiNewton
from ancfsparse.plans.goal_oriented_run import simulate
from ancfsparse.problems.named import MECHANISMS
from ancfsparse.scene import Scene
from ancfsparse.scene.storage.named_parts import (
    Reader,
    argument_named_by,
    arguments_of,
    locate_errors,
)
from ancfsparse.scene.storage.scene_file import SceneFile, open_scene_file
from ancfsparse.scene.storage.toml_text import written_as_toml

NOT_IN_FILES = {"scene", "output", "progress", "quantity", "error"}
"""Arguments of `simulate` that are not data, or belong to the command."""
SETTINGS = {each.name: each for each in arguments_of(simulate) if each.name not in NOT_IN_FILES}
METHODS_OF_RUNS: list[Any] = [
    *(each.make for each in names.BY_NAME.values()), Newton, ModifiedNewton, QuasiNewton,
]  # fmt: skip
METHOD_KINDS = {kind.__name__: kind for kind in METHODS_OF_RUNS}

SceneArgument = Annotated[Path, typer.Argument(help="Scene, .toml or .json.")]


def run(
    file: SceneArgument,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", help="HDF5 file for the states.")
    ] = None,
    time: Annotated[float | None, typer.Option(help="Final time [s].")] = None,
    step: Annotated[float | None, typer.Option(help="Time step [s].")] = None,
    accuracy: Annotated[
        float | None, typer.Option(help="Largest time discretization error of a position [m].")
    ] = None,
    integrator: Annotated[str | None, typer.Option(help=", ".join(names.BY_NAME) + ".")] = None,
    solver: Annotated[str | None, typer.Option(help=", ".join(METHODS) + " or auto.")] = None,
    save_every: Annotated[int | None, typer.Option(help="Steps between saved states.")] = None,
    pairs: Annotated[
        list[str] | None,
        typer.Option(
            "--set",
            metavar="KEY=VALUE",
            help="Other settings, or data of the scene such as parts.rope.length=1.3; repeatable.",
        ),
    ] = None,
) -> None:
    """Run a scene from a file, with the settings of its table `run`, or those given here."""
    options = {
        "t_end": time,
        "dt": step,
        "accuracy": accuracy,
        "integrator": integrator,
        "solver": solver,
        "save_every": save_every,
    }
    replaced = {name: value for name, value in options.items() if value is not None}
    source = open_scene_file(file)
    for key, value in map(_pair, pairs or ()):
        if "." in key or key in source.data.keys() - SETTINGS.keys():
            _replace(source.data, key, value)
        else:
            replaced[check_choice("key of --set", key, SETTINGS)] = value
    reader, settings = read_settings(source, replaced)
    if "t_end" not in settings:
        raise InputError(f"{file} has no t_end in its table run: give it there, or --time")
    if output is not None:
        settings["output"] = output
    try:
        result = simulate(reader.scene, **settings)
        typer.echo(repr(result))
        if "save_nodes" not in settings:  # energies need all coordinates
            typer.echo(f"  {result.energy!r}")
    except InputError as error:
        if argument_named_by(error) not in settings.keys() - replaced.keys():
            raise InputError(f"{file}: {error.message(option_style)}") from error
        with source.messages(), locate_errors(("run",), settings):
            raise
    except AncfError as error:
        if hasattr(error, "trajectory"):
            error.trajectory = None  # whose attribute the message would name
        raise RunError(f"{file}: {error}") from error
    if output is not None:
        typer.echo(f"written: {output}")


def check(file: SceneArgument) -> None:
    """Check a file of a scene without running it, and print its parts."""
    source = open_scene_file(file)
    reader, settings = read_settings(source, {})
    typer.echo(str(reader.scene))
    if settings:
        typer.echo(f"run: {', '.join(f'{name} {value}' for name, value in settings.items())}")


def new(
    file: Annotated[Path, typer.Argument(help="File to write, .toml.")],
    problem: Annotated[
        str | None, typer.Option(help="Name in ancfsparse problem --list [default: a cable].")
    ] = None,
) -> None:
    """Write a scene to begin with, and comments on it, or a benchmark problem."""
    target = check_target("the file of a scene", file, (".toml",))
    if target.exists():
        raise InputError(f"{target} exists: give the name of a new file")
    text = STARTER.read_text(encoding="utf-8") if problem is None else _write_problem(problem)
    target.write_text(text, encoding="utf-8")
    typer.echo(f"written: {target}\nrun it: ancfsparse run {target} -o {target.stem}.h5")


def _write_problem(name: str) -> str:
    """Return a benchmark problem as the text of a file, with the settings of its reference."""
    case = MECHANISMS[check_choice("name of a problem", name, MECHANISMS)]
    mechanism = case.make()
    steps = max(1, round(case.time / case.dt))  # one for an equilibrium
    settings: dict[str, Any] = {"t_end": steps * case.dt, "dt": case.dt}
    settings["integrator"] = case.integrator
    if mechanism.settles:
        settings["start"] = "equilibrium"
    return written_as_toml(mechanism.scene, settings)


STARTER = files("ancfsparse.cli") / "starter.toml"


def read_settings(source: SceneFile, replaced: Mapping[str, Any]) -> tuple[Reader, dict[str, Any]]:
    """Build the scene of a file; return it with its parts, and the arguments of `simulate`.

    Parameters
    ----------
    source : SceneFile
        The file.
    replaced : mapping of str to object
        Settings of the command, as data of a file.
    """
    reader = source.read(Scene, {})
    with source.messages():
        table = source.data.get("run", {})
        with locate_errors(("run",)):
            if not isinstance(table, dict):
                raise InputError(f"run must be a table of settings, got {format_value(table)}")
        table = {name: value for name, value in table.items() if name not in replaced}
        settings = _settings(reader, table)
    settings |= _settings(reader, replaced)
    return reader, settings


def _settings(reader: Reader, table: Mapping[str, Any]) -> dict[str, Any]:
    """Return arguments of `simulate` from data."""
    known = {name: each._replace(required=False) for name, each in SETTINGS.items()}
    reader.kinds = METHOD_KINDS
    settings = reader.arguments(known, table, ("run",), "run")
    for name, by_name in (("integrator", names.BY_NAME), ("solver", METHODS)):
        value = settings.get(name, "auto")
        if isinstance(value, str) and value != "auto":
            with locate_errors(("run", name)):
                check_choice(name, value, (*by_name, "auto"))
            settings[name] = names.integrator_of(value) if name == "integrator" else _method(value)
    return settings


def _method(name: str) -> Method:
    return METHODS[name]()


def _pair(text: str) -> tuple[str, Any]:
    """Return a key and its value, which is written as in TOML, texts also without quotes."""
    key, equals, value = text.partition("=")
    if not equals:
        raise InputError(f"--set needs key=value, got {format_value(text)}")
    try:
        return key, tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return key, value


def _replace(data: dict[str, Any], key: str, value: Any) -> None:
    """Replace a value in the data of a file by the keys of its tables, separated by dots."""
    table, names = data, key.split(".")
    for number, name in enumerate(names):
        check_choice(f"key of --set {'.'.join(names[:number])}".strip(), name, table)
        if number == len(names) - 1:
            table[name] = value
        elif isinstance(table[name], dict):
            table = table[name]
        else:
            raise InputError(f"--set {key}: {'.'.join(names[: number + 1])} is not a table")
