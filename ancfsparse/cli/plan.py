"""The command ``ancfsparse plan``."""

from __future__ import annotations

from typing import Annotated

import typer

from ancfsparse import cli
from ancfsparse.cli.options import in_options


def plan(
    scene: Annotated[
        str, typer.Argument(help="pendulum, twisted, line, net, pull, whip or twang.")
    ] = "pendulum",
    error: Annotated[
        str | None,
        typer.Option(help="Largest error: a number [m] or a share such as '1 %'."),
    ] = None,
    run: Annotated[bool, typer.Option(help="Run it, and once more with a finer model.")] = True,
    beside: Annotated[
        bool, typer.Option(help="Compare the pendulum with the paper's own way, refined.")
    ] = False,
) -> None:
    """Choose element, mesh and step of a scene for an error of one of its points."""
    with in_options():
        typer.echo(str(cli.plan_scene(scene, error, run)))
        if beside:
            for element in cli.ELEMENTS:
                typer.echo(str(cli.contest(element, cli.ERROR)))
