"""The commands ``ancfsparse study ...``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ancfsparse.errors import check_count, check_positive
from ancfsparse.studies import memory_report, scaling_report
from ancfsparse.studies.memory import memory as run_memory
from ancfsparse.studies.scaling import scaling as run_scaling

study = typer.Typer(
    help="Studies of cost and memory on long chains and large nets.", no_args_is_help=True
)

OutputOption = Annotated[Path, typer.Option(help="Folder for tables and charts.")]


@study.command()
def scaling(
    largest: Annotated[int, typer.Option(help="Elements of the longest chain.")] = 100_000,
    steps: Annotated[int, typer.Option(help="Time steps of 5e-4 s.")] = 100,
    nets: Annotated[bool, typer.Option(help="Whether to run nets.")] = True,
    largest_net: Annotated[int, typer.Option(help="Nodes along a side of the largest net.")] = 60,
    peers: Annotated[bool, typer.Option("--peers", help="Run Exudyn beside ours.")] = False,
    rounds: Annotated[int, typer.Option(help="Runs of each solver, in turn.")] = 3,
    cap: Annotated[float, typer.Option(help="Leave out runs expected to take longer [s].")] = 60.0,
    threads: Annotated[int, typer.Option(help="If more than 1, auto on so many threads too.")] = 1,
    output: OutputOption = Path("results"),
) -> None:
    """Measure cost per element and step, and memory, against size, and the roofline."""
    check_count("largest", largest)
    check_count("steps", steps)
    check_count("largest-net", largest_net, 2)
    check_count("rounds", rounds)
    check_positive("cap", cap, "s")
    check_count("threads", threads)
    result = run_scaling(
        largest, steps, largest_net if nets else 0, peers, rounds, cap, True, threads
    )
    typer.echo(scaling_report.as_text(result))
    written = scaling_report.write(result, output)
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))


@study.command()
def memory(
    chain: Annotated[int, typer.Option(help="Elements of the chain.")] = 1000,
    net: Annotated[int, typer.Option(help="Nodes along a side of the net.")] = 20,
    steps: Annotated[int, typer.Option(help="Time steps of 5e-4 s.")] = 200,
    rounds: Annotated[int, typer.Option(help="Runs of each, in turn.")] = 3,
    output: OutputOption = Path("results"),
) -> None:
    """Measure what secant pairs are worth: all updates, memory lengths, carried or not."""
    check_count("steps", steps)
    check_count("rounds", rounds)
    result = run_memory(chain, net, steps, rounds, progress=True)
    typer.echo(memory_report.as_text(result))
    written = memory_report.write(result, output)
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))
