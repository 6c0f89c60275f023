"""The commands ``python -m benchmarks ...``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated, Any

import typer

from ancfsparse.checks import check_choice, check_count, check_positive
from ancfsparse.cli.app import check_writable, run_app, write_json
from ancfsparse.cli.options import in_options
from ancfsparse.errors import InputError
from benchmarks.accuracy.error_budget_report import STUDY as ERROR_BUDGET
from benchmarks.accuracy.total_error_report import STUDY as TOTAL_ERROR
from benchmarks.accuracy.work_precision_report import STUDY as WORK_PRECISION
from benchmarks.common import paper
from benchmarks.common.files import check_targets, fill_page, plain
from benchmarks.common.study import Study
from benchmarks.economy.report import STUDY as ECONOMY
from benchmarks.economy.scenes import CASES as ECONOMY_CASES
from benchmarks.mechanisms.report import STUDY as MECHANISMS
from benchmarks.scaling.lattice_pairs import STUDY as MEMORY_LATTICES
from benchmarks.scaling.lattice_report import STUDY as LATTICES
from benchmarks.scaling.scaling_report import STUDY as SCALING
from benchmarks.scaling.secant_pairs_report import STUDY as MEMORY
from benchmarks.stability.factorizations import CASES
from benchmarks.stability.factorizations import STUDY as STABILITY_SEEDS
from benchmarks.stability.long_runs_report import STUDY as LONG_RUNS
from benchmarks.stability.report import STUDY as STABILITY
from benchmarks.stability.scenes import SCENES
from benchmarks.stability.stability_map import read as read_stability
from benchmarks.table1.kernels import KernelBench
from benchmarks.table1.kernels import bench_kernels as run_bench_kernels
from benchmarks.table1.report import ON_BENCHMARKS
from benchmarks.table1.report import STUDY as TABLE1
from benchmarks.table1.speed import PaperBench
from benchmarks.table1.speed import bench_paper as run_bench_paper
from benchmarks.table1.sweeps import SweepBench
from benchmarks.table1.sweeps import bench_sweep as run_bench_sweep
from benchmarks.units.run import SCENES as UNITS_SCENES
from benchmarks.units.run import STUDY as UNITS

app = typer.Typer(
    help="Table 1 of the paper, and studies of cost, memory and accuracy with tables and charts.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)

OutputOption = Annotated[Path, typer.Option(help="Folder for tables and charts.")]
PageOption = Annotated[
    Path | None, typer.Option(help="Page whose tables, and charts in gallery beside it, to renew.")
]


SaveOption = Annotated[
    str | None,
    typer.Option(metavar="FILE", help="Write one JSON object to FILE.", callback=check_writable),
]


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command, as `ancfsparse.cli.main` does."""
    run_app(app, "benchmarks", arguments)


def report(shown: Study[Any], result: Any, output: Path, page: Path | None) -> None:
    """Print a result, write its tables and charts, and renew the regions of a page."""
    typer.echo(shown.text(result))
    written = shown.write(result, output)
    typer.echo("\nwritten: " + ", ".join(str(path) for path in written))
    if page is not None:
        shown.fill(result, page, output)


@app.command()
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
    SCALING.check(output, page)
    check_count("--largest", largest)
    check_count("--steps", steps)
    check_count("--largest-net", largest_net, 2)
    check_count("--rounds", rounds)
    check_positive("--cap", cap, "s")
    check_count("--threads", threads)
    sizes = (largest, steps, largest_net if nets else 0)
    report(SCALING, SCALING.run(*sizes, peers, rounds, cap, True, threads), output, page)


@app.command()
def lattices(
    largest: Annotated[int, typer.Option(help="Nodes along a side of the largest lattice.")] = 22,
    largest_net: Annotated[int, typer.Option(help="Nodes along a side of the largest net.")] = 100,
    largest_exact: Annotated[
        int, typer.Option(help="Nodes along a side of the largest lattice on complete seeds.")
    ] = 16,
    steps: Annotated[int, typer.Option(help="Time steps.")] = 20,
    threads: Annotated[int, typer.Option(help="Of the largest lattice, run once more.")] = 1,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Measure complete and incomplete seeds on lattices and nets: time, memory, counts by size."""
    LATTICES.check(output, page)
    for name, size in (("--largest", largest), ("--largest-net", largest_net)):
        check_count(name, size, 2)
    check_count("--largest-exact", largest_exact, 0)
    check_count("--steps", steps)
    check_count("--threads", threads)
    sizes = (largest, largest_net, largest_exact, steps, threads)
    report(LATTICES, LATTICES.run(*sizes, progress=True), output, page)


@app.command()
def memory(
    chain: Annotated[int, typer.Option(help="Elements of the chain.")] = 1000,
    net: Annotated[int, typer.Option(help="Nodes along a side of the net.")] = 20,
    steps: Annotated[int, typer.Option(help="Time steps of 5e-4 s.")] = 200,
    rounds: Annotated[int, typer.Option(help="Runs of each, in turn.")] = 3,
    lattice: Annotated[
        int | None,
        typer.Option(help="Instead: a lattice of so many nodes a side, on incomplete seeds."),
    ] = None,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Measure what secant pairs are worth: all updates, memory lengths, carried or not."""
    if lattice is not None:
        MEMORY_LATTICES.check(output, page)
        check_count("--lattice", lattice, 2)
        result = MEMORY_LATTICES.run(lattice, progress=True)
        report(MEMORY_LATTICES, result, output, page)
        return
    MEMORY.check(output, page)
    check_count("--steps", steps)
    check_count("--rounds", rounds)
    report(MEMORY, MEMORY.run(chain, net, steps, rounds, progress=True), output, page)


@app.command("work-precision")
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
    WORK_PRECISION.check(output, page)
    if budget:
        ERROR_BUDGET.check(output, page)
    result = WORK_PRECISION.run(
        elements=elements, t_end=time, with_peers=peers, rounds=rounds, cap=cap, progress=True
    )
    report(WORK_PRECISION, result, output, page)
    if budget:
        split = ERROR_BUDGET.run(elements=elements, t_end=time, progress=True)
        typer.echo()
        report(ERROR_BUDGET, split, output, page)


@app.command("total-error")
def total_error(
    peers: Annotated[bool, typer.Option("--peers", help="Run Exudyn and PyElastica too.")] = False,
    rounds: Annotated[int, typer.Option(help="Runs of each, in turn; the best counts.")] = 2,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Measure the whole error against its cost over elements, their number and the step."""
    TOTAL_ERROR.check(output, page)
    result = TOTAL_ERROR.run(with_peers=peers, rounds=rounds, progress=True)
    report(TOTAL_ERROR, result, output, page)


@app.command()
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
    seeds: Annotated[
        bool, typer.Option("--seeds", help="Instead: complete against incomplete seeds.")
    ] = False,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Map which runs complete, over step, stiffness, integrator and solver; minutes."""
    options = {"steps": step, "stiffnesses": stiffness}
    if seeds:
        STABILITY_SEEDS.check(output, page)
        if table is not None:
            raise InputError("--seeds runs a map of its own: leave out --from")
        map_of_seeds = STABILITY_SEEDS.run(
            tuple(scene or CASES),
            **{name: tuple(given) for name, given in options.items() if given},
            progress=True,
        )
        report(STABILITY_SEEDS, map_of_seeds, output, page)
        return
    STABILITY.check(output, page)
    if table is not None:
        if scene or step or stiffness:
            raise InputError(
                f"--from {table} shows a map that is finished: leave out --scene, --step and "
                "--stiffness, or --from"
            )
        result = read_stability(table)
    else:
        result = STABILITY.run(
            tuple(scene or SCENES),
            **{name: tuple(given) for name, given in options.items() if given},
            progress=True,
        )
    report(STABILITY, result, output, page)


@app.command("economy")
def economy_command(
    scenes: Annotated[
        list[str] | None, typer.Option("--scene", help="A scene, once for each [default: all].")
    ] = None,
    jobs: Annotated[int, typer.Option(min=1, help="Scenes at once, in processes.")] = 1,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Compare plans with the best choice by hand: errors asked for and reached, and cost."""
    ECONOMY.check(output, page)
    for name in scenes or ():
        check_choice("scene", name, ECONOMY_CASES)
    result = ECONOMY.run(scenes or tuple(ECONOMY_CASES), jobs=jobs, progress=True)
    report(ECONOMY, result, output, page)


@app.command("units")
def units_command(
    scene: Annotated[list[str] | None, typer.Option(help="Only this scene; repeatable.")] = None,
    output: OutputOption = Path("results"),
) -> None:
    """Run the same scenes in seven systems of units, under 1e-6 to 1e4 m/s2; a minute."""
    UNITS.check(output, None)
    for name in scene or ():
        check_choice("scene", name, tuple(UNITS_SCENES))
    report(UNITS, UNITS.run(tuple(scene or UNITS_SCENES), progress=True), output, None)


@app.command("long-runs")
def long_runs(
    steps: Annotated[int, typer.Option(help="Time steps of 5e-4 s.")] = 1_000_000,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Let the pendulum fall for a million steps: memory, energy, and what fails when."""
    LONG_RUNS.check(output, page)
    report(LONG_RUNS, LONG_RUNS.run(steps, progress=True), output, page)


@app.command("mechanisms")
def mechanisms_command(
    scene: Annotated[
        list[str] | None, typer.Option(help="Only this mechanism; repeatable.")
    ] = None,
    rounds: Annotated[int, typer.Option(help="Runs of each program, in turn.")] = 9,
    output: OutputOption = Path("results"),
    page: PageOption = None,
) -> None:
    """Run mechanisms of cables beside Exudyn: time against error; some minutes."""
    MECHANISMS.check(output, page)
    options = {"names": tuple(scene)} if scene else {}
    report(MECHANISMS, MECHANISMS.run(**options, rounds=rounds, progress=True), output, page)


@app.command()
def table1(
    output: Annotated[Path, typer.Option(help="Folder for table and figures.")] = Path("results"),
    time: Annotated[float, typer.Option(help="Simulated time [s].")] = paper.T_END,
    step: Annotated[float, typer.Option(help="Time step [s].")] = paper.DT,
    cap: Annotated[float, typer.Option(help="Seconds a method of SciPy may take.")] = 15.0,
    readme: Annotated[
        Path | None, typer.Option(help="Page whose table, and picture in docs/gallery, to renew.")
    ] = None,
    page: Annotated[Path | None, typer.Option(help="Page whose list of findings to renew.")] = None,
) -> None:
    """Reproduce table 1 and figures 1 and 2 of the paper beside the paper's own numbers."""
    TABLE1.check(output, readme)
    ON_BENCHMARKS.check(output, page)
    with in_options():
        table = TABLE1.run(t_end=time, dt=step, cap=cap, progress=True)
    report(TABLE1, table, output, readme)
    if page is not None:
        ON_BENCHMARKS.fill(table, page, output)


@app.command("bench-paper")
def bench_paper(
    repeats: Annotated[int, typer.Option(help="Interleaved runs of each contestant.")] = 9,
    save: SaveOption = None,
    page: Annotated[Path | None, typer.Option(help="Page whose output to renew.")] = None,
) -> None:
    """Time the paper's pendulum beside Exudyn, in turn, and against the paper's own times."""
    check_count("--repeats", repeats)
    check_targets(Path(), page, "bench-paper")
    result = run_bench_paper(repeats=repeats, progress=True)
    _report(result, save)
    if page is not None:
        fill_page(page, "bench-paper", f"```\n{result}\n```")


@app.command("bench-kernels")
def bench_kernels(save: SaveOption = None) -> None:
    """Time every element kernel on every instruction set of this machine."""
    _report(run_bench_kernels(progress=True), save)


@app.command("bench-sweep")
def bench_sweep(
    points: Annotated[int, typer.Option(help="Number of pendulums.")] = 200,
    workers: Annotated[
        int | None, typer.Option(help="Processes [default: one for each processor].")
    ] = None,
    dt: Annotated[float, typer.Option(help="Time step [s].")] = paper.DT,
    rounds: Annotated[int, typer.Option(help="Rounds, of which the least times count.")] = 3,
    save: SaveOption = None,
) -> None:
    """Time a sweep over pendulums beside a plain loop."""
    check_count("--points", points)
    check_count("--rounds", rounds)
    check_positive("--dt", dt, "s")
    if workers is not None:
        check_count("--workers", workers)
    _report(run_bench_sweep(points, workers, dt, rounds, progress=True), save)


def _report(result: KernelBench | PaperBench | SweepBench, save: str | None) -> None:
    typer.echo(str(result))
    if save is not None:
        targets = [each.record() for each in result.targets]
        write_json(plain(result) | {"targets": targets}, save)
