"""The commands ``ancfsparse study ...``."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ancfsparse.checks import check_choice, check_count, check_positive
from ancfsparse.errors import InputError
from ancfsparse.studies.common import paper
from ancfsparse.studies.common.files import check_targets, fill_page
from ancfsparse.studies.error_budget import report as error_budget_report
from ancfsparse.studies.error_budget.run import error_budget as run_error_budget
from ancfsparse.studies.lattices import report as lattices_report
from ancfsparse.studies.lattices.run import lattices as run_lattices
from ancfsparse.studies.long_runs import report as long_runs_report
from ancfsparse.studies.long_runs.run import long_runs as run_long_runs
from ancfsparse.studies.memory import report as memory_report
from ancfsparse.studies.memory.run import memory as run_memory
from ancfsparse.studies.scaling import report as scaling_report
from ancfsparse.studies.scaling.run import scaling as run_scaling
from ancfsparse.studies.stability import findings as stability_findings
from ancfsparse.studies.stability import report as stability_report
from ancfsparse.studies.stability.run import read as read_stability
from ancfsparse.studies.stability.run import stability as run_stability
from ancfsparse.studies.stability.scenes import SCENES
from ancfsparse.studies.total_error import report as total_error_report
from ancfsparse.studies.total_error.run import total_error as run_total_error
from ancfsparse.studies.units import run as units
from ancfsparse.studies.work_precision import report as work_precision_report
from ancfsparse.studies.work_precision.run import work_precision as run_work_precision

study = typer.Typer(
    help="Studies of cost, memory and accuracy, each with tables and a chart.", no_args_is_help=True
)

OutputOption = Annotated[Path, typer.Option(help="Folder for tables and charts.")]
PageOption = Annotated[
    Path | None, typer.Option(help="Page whose tables, and charts in gallery beside it, to renew.")
]


@study.command()
def scaling(
    largest: Annotated[int, typer.Option(help="Elements of the longest chain.")] = 100_000,
    steps: Annotated[int, typer.Option(help="Time steps of 5e-4 s.")] = 100,
    nets: Annotated[bool, typer.Option(help="Whether to run nets.")] = True,
    largest_net: Annotated[int, typer.Option(help="Nodes along a side of the largest net.")] = 60,
    peers: Annotated[bool, typer.Option("--peers", help="Run Exudyn beside ours.")] = False,
    rounds: Annotated[
        int, typer.Option(help="Runs of each solver, in turn; more of short ones.")
    ] = 3,
    cap: Annotated[float, typer.Option(help="Leave out runs expected to take longer [s].")] = 60.0,
    threads: Annotated[int, typer.Option(help="If more than 1, auto on so many threads too.")] = 1,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Measure cost per element and step, and memory, against size, and the roofline."""
    check_targets(output, page, "scaling")
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
    if page is not None:
        fill_page(page, "scaling", scaling_report.as_markdown(result), written[-1])


@study.command()
def lattices(
    largest: Annotated[int, typer.Option(help="Nodes along a side of the largest lattice.")] = 22,
    largest_net: Annotated[int, typer.Option(help="Nodes along a side of the largest net.")] = 100,
    largest_exact: Annotated[
        int, typer.Option(help="Nodes along a side of the largest lattice on exact seeds.")
    ] = 16,
    steps: Annotated[int, typer.Option(help="Time steps.")] = 20,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Measure exact and incomplete seeds on lattices and nets: time, memory and counts by size."""
    check_targets(output, page, "lattices")
    for name, size in (("largest", largest), ("largest-net", largest_net)):
        check_count(name, size, 2)
    check_count("largest-exact", largest_exact, 0)
    check_count("steps", steps)
    rows = run_lattices(largest, largest_net, largest_exact, steps, progress=True)
    typer.echo(lattices_report.as_text(rows))
    written = lattices_report.write(rows, output)
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))
    if page is not None:
        fill_page(page, "lattices", lattices_report.as_markdown(rows), written[-1])


@study.command()
def memory(
    chain: Annotated[int, typer.Option(help="Elements of the chain.")] = 1000,
    net: Annotated[int, typer.Option(help="Nodes along a side of the net.")] = 20,
    steps: Annotated[int, typer.Option(help="Time steps of 5e-4 s.")] = 200,
    rounds: Annotated[int, typer.Option(help="Runs of each, in turn.")] = 3,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Measure what secant pairs are worth: all updates, memory lengths, carried or not."""
    check_targets(output, page, "memory")
    check_count("steps", steps)
    check_count("rounds", rounds)
    result = run_memory(chain, net, steps, rounds, progress=True)
    typer.echo(memory_report.as_text(result))
    written = memory_report.write(result, output)
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))
    if page is not None:
        fill_page(page, "memory", memory_report.as_markdown(result), written[-1])


@study.command("work-precision")
def work_precision(
    peers: Annotated[bool, typer.Option("--peers", help="Run all peers beside ours.")] = False,
    rounds: Annotated[int, typer.Option(help="Runs of each, in turn; the best counts.")] = 3,
    cap: Annotated[float, typer.Option(help="Seconds SciPy or SUNDIALS may take.")] = 8.0,
    elements: Annotated[int, typer.Option(help="Number of elements.")] = paper.ELEMENTS,
    time: Annotated[float, typer.Option(help="Simulated time [s].")] = paper.T_END,
    budget: Annotated[bool, typer.Option(help="Whether to split the error as well.")] = True,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Measure seconds against error in time, and split the error of the paper's choice."""
    check_targets(output, page, "work-precision", *["error-budget"] * budget)
    result = run_work_precision(
        elements=elements, t_end=time, with_peers=peers, rounds=rounds, cap=cap, progress=True
    )
    typer.echo(work_precision_report.as_text(result))
    written = work_precision_report.write(result, output)
    if page is not None:
        fill_page(page, "work-precision", work_precision_report.as_markdown(result), written[-1])
    if budget:
        split = run_error_budget(elements=elements, t_end=time, progress=True)
        typer.echo("\n" + error_budget_report.as_text(split))
        written += error_budget_report.write(split, output)
        if page is not None:
            fill_page(page, "error-budget", error_budget_report.as_markdown(split), written[-1])
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))


@study.command("total-error")
def total_error(
    peers: Annotated[bool, typer.Option("--peers", help="Run Exudyn and PyElastica too.")] = False,
    rounds: Annotated[int, typer.Option(help="Runs of each, in turn; the best counts.")] = 2,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Measure the whole error against its cost over elements, their number and the step."""
    check_targets(output, page, "total-error")
    result = run_total_error(with_peers=peers, rounds=rounds, progress=True)
    typer.echo(total_error_report.as_text(result))
    written = total_error_report.write(result, output)
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))
    if page is not None:
        fill_page(page, "total-error", total_error_report.as_markdown(result), written[-1])


@study.command()
def stability(
    scene: Annotated[list[str] | None, typer.Option(help="Only this scene; repeatable.")] = None,
    step: Annotated[list[float] | None, typer.Option(help="Only this time step [s].")] = None,
    stiffness: Annotated[
        list[float] | None, typer.Option(help="Only this Young's modulus [Pa].")
    ] = None,
    table: Annotated[
        Path | None,
        typer.Option("--from", help="Run nothing: tables and charts of this stability.csv."),
    ] = None,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Map which runs complete, over step, stiffness, integrator and solver; minutes."""
    check_targets(output, page, "stability", "stability-solvers")
    options = {"steps": step, "stiffnesses": stiffness}
    if table is not None:
        if scene or step or stiffness:
            raise InputError(
                f"--from {table} shows a map that is finished: leave out --scene, --step and "
                "--stiffness, or --from"
            )
        result = read_stability(table)
    else:
        result = run_stability(
            tuple(scene or SCENES),
            **{name: tuple(given) for name, given in options.items() if given},
            progress=True,
        )
    typer.echo(stability_report.as_text(result))
    written = stability_report.write(result, output)
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))
    if page is not None:
        text = stability_findings.integrator_table(result)
        fill_page(page, "stability", text, written[-2])
        text = stability_findings.solver_table(result)
        fill_page(page, "stability-solvers", text, written[-1])


@study.command("units")
def units_command(
    scene: Annotated[list[str] | None, typer.Option(help="Only this scene; repeatable.")] = None,
    output: OutputOption = Path("results"),
) -> None:
    """Run the same scenes in seven systems of units, under 1e-6 to 1e4 m/s2; a minute."""
    check_targets(output, None)
    for name in scene or ():
        check_choice("--scene", name, tuple(units.SCENES))
    runs = units.units(tuple(scene or units.SCENES), progress=True)
    typer.echo(units.as_text(runs))
    written = units.write(runs, output)
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))


@study.command("long-runs")
def long_runs(
    steps: Annotated[int, typer.Option(help="Time steps of 5e-4 s.")] = 1_000_000,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Let the pendulum fall for a million steps: memory, energy, and what fails when."""
    check_targets(output, page, "long-runs")
    result = run_long_runs(steps, progress=True)
    typer.echo(long_runs_report.table(result))
    written = long_runs_report.write(result, output)
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))
    if page is not None:
        fill_page(page, "long-runs", long_runs_report.table(result), written[-1])
