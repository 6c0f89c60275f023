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
        typer.echo(str(cli.plan_scene(scene, error, run)))
        if compare:
            for element in cli.ELEMENTS:
                typer.echo(str(cli.compare_with_paper(element, cli.ERROR)))
