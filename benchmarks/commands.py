"""Commands of ``python -m benchmarks``: one for each study, with the options of its run."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Annotated, Any, get_origin

import typer

from ancfsparse.cli.app import run_app
from ancfsparse.cli.options import in_options
from benchmarks.accuracy.error_budget import STUDY as ERROR_BUDGET
from benchmarks.accuracy.total_error_report import STUDY as TOTAL_ERROR
from benchmarks.accuracy.work_precision_report import STUDY as WORK_PRECISION
from benchmarks.common.study import Study
from benchmarks.contact.coupling_blocks import STUDY as CONTACT_BLOCKS
from benchmarks.contact.peers import STUDY as CONTACT_PEERS
from benchmarks.contact.reference_values import STUDY as CONTACT_REFERENCES
from benchmarks.contact.speed import STUDY as CONTACT_SPEED
from benchmarks.contact.wrapped_cylinder import STUDY as WRAPPED_CYLINDER
from benchmarks.economy.report import STUDY as ECONOMY
from benchmarks.economy.thresholds import STUDY as THRESHOLDS
from benchmarks.mechanisms.mechanisms import STUDY as MECHANISMS
from benchmarks.scaling.lattice_pairs import STUDY as LATTICE_PAIRS
from benchmarks.scaling.lattice_report import STUDY as LATTICES
from benchmarks.scaling.scaling_report import STUDY as SCALING
from benchmarks.scaling.secant_pairs import STUDY as SECANT_PAIRS
from benchmarks.stability.contact_accuracy import STUDY as CONTACT_ACCURACY
from benchmarks.stability.factorizations import STUDY as FACTORIZATIONS
from benchmarks.stability.long_runs import STUDY as LONG_RUNS
from benchmarks.stability.report import CONTACT_STUDY as CONTACT_STABILITY, STUDY as STABILITY
from benchmarks.table1.kernels import STUDY as KERNELS
from benchmarks.table1.report import STUDY as TABLE1
from benchmarks.table1.speed import STUDY as PENDULUM_SPEED
from benchmarks.table1.sweeps import STUDY as SWEEPS

GROUPS = {
    "speed": "Measure the speed of the paper's pendulum, of kernels and of sweeps.",
    "accuracy": "Measure errors on the paper's pendulum against their cost.",
    "scaling": "Measure time, memory and iterations against the size of chains, nets and lattices.",
    "contact": "Compare contact and friction with formulas, and measure their speed.",
    "stability": "Map the outcome of runs over time step, stiffness, integrator and solver.",
}

STUDIES: dict[str, Study[Any]] = {
    "table1": TABLE1,
    "speed pendulum": PENDULUM_SPEED,
    "speed kernels": KERNELS,
    "speed sweeps": SWEEPS,
    "accuracy work-precision": WORK_PRECISION,
    "accuracy total-error": TOTAL_ERROR,
    "accuracy error-budget": ERROR_BUDGET,
    "scaling sizes": SCALING,
    "scaling lattices": LATTICES,
    "scaling secant-pairs": SECANT_PAIRS,
    "scaling lattice-pairs": LATTICE_PAIRS,
    "stability map": STABILITY,
    "stability contact": CONTACT_STABILITY,
    "stability factorizations": FACTORIZATIONS,
    "stability long-runs": LONG_RUNS,
    "contact wrapped-cylinder": WRAPPED_CYLINDER,
    "contact references": CONTACT_REFERENCES,
    "contact speed": CONTACT_SPEED,
    "contact peers": CONTACT_PEERS,
    "contact accuracy": CONTACT_ACCURACY,
    "contact blocks": CONTACT_BLOCKS,
    "mechanisms": MECHANISMS,
    "economy": ECONOMY,
    "thresholds": THRESHOLDS,
}
"""Studies by the words of their command."""

Output = Annotated[Path, typer.Option(help="Folder for tables and charts.")]
Pages = Annotated[
    list[Path] | None,
    typer.Option("--page", help="Page whose tables, and charts in its gallery, to renew."),
]
SETTINGS: dict[str, Any] = {
    "no_args_is_help": True,
    "add_completion": False,
    "rich_markup_mode": None,
    "pretty_exceptions_enable": False,
}


def main(arguments: Sequence[str] | None = None) -> None:
    """Run a command, with the exit codes of `ancfsparse.cli.main`."""
    run_app(program(), "benchmarks", arguments)


def program() -> typer.Typer:
    """Return the program of all commands."""
    app = typer.Typer(
        help="Table 1 of the paper, and studies of speed, accuracy, scaling and stability, with "
        "tables and charts.",
        **SETTINGS,
    )
    groups = {name: typer.Typer(help=text, **SETTINGS) for name, text in GROUPS.items()}
    for words, study in STUDIES.items():
        group, _, name = words.rpartition(" ")
        help_text = (inspect.getdoc(study.run) or "").partition("\n\n")[0]
        (groups[group] if group else app).command(name, help=help_text)(command_of(study))
    for name, group_app in groups.items():
        app.add_typer(group_app, name=name)
    return app


def command_of(study: Study[Any]) -> Callable[..., None]:
    """Return the command of a study, whose options are the annotated arguments of its run."""

    def command(output: Path, pages: list[Path] | None, **options: Any) -> None:
        study.check(output, pages or [])
        with in_options():
            result = study.run(**options, progress=True)
        typer.echo(study.text(result))
        written = study.write(result, output)
        typer.echo("\nwritten: " + ", ".join(map(str, written)))
        for page in pages or []:
            study.fill(result, page, output)

    only = inspect.Parameter.KEYWORD_ONLY
    declared = inspect.signature(study.run, eval_str=True).parameters.values()
    options = [
        each.replace(kind=only) for each in declared if get_origin(each.annotation) is Annotated
    ]
    options.append(inspect.Parameter("output", only, default=Path("results"), annotation=Output))
    options.append(inspect.Parameter("pages", only, default=None, annotation=Pages))
    command.__signature__ = inspect.Signature(options)  # type: ignore[attr-defined]
    return command
