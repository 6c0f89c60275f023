"""Values of contact and friction next to their references, with tolerances."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import typer

from ancfsparse.errors import AncfError
from benchmarks.common.progress import bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.contact.references.belts import (
    compare_drives,
    compare_published_drive,
    compare_slip,
)
from benchmarks.contact.references.capstans import (
    compare_capstans,
    compare_creep,
    compare_loads,
    compare_reversal,
    compare_stiff_capstans,
)
from benchmarks.contact.references.comparison import NO_VALUE, Check, Comparison, compare_absolute
from benchmarks.contact.references.impacts import (
    compare_explicit_falls,
    compare_falls,
    compare_restitutions,
    compare_rubbing,
)
from benchmarks.contact.references.knots import compare_knots
from benchmarks.contact.references.loose_knots import compare_loose_knots
from benchmarks.contact.references.obstacles import (
    compare_block,
    compare_cantilever,
    compare_chain,
    compare_drop,
)
from benchmarks.contact.references.penetrations import compare_penetrations
from benchmarks.contact.references.piles import (
    compare_net,
    compare_pile,
    compare_pile_steps,
    state_time_factors,
)
from benchmarks.contact.references.search_time import compare_search_times

CHECKS: dict[str, dict[str, Check]] = {
    "quick": {
        "capstan": compare_capstans,
        "capstan with bending": compare_stiff_capstans,
        "sticking and sliding": compare_loads,
        "reversed wire": compare_reversal,
        "creep": compare_creep,
        "belt drive": compare_drives,
        "full slip": compare_slip,
        "block": compare_block,
        "cable drop": compare_drop,
        "cantilever": compare_cantilever,
        "chain": compare_chain,
        "level falls": compare_falls,
        "explicit level falls": compare_explicit_falls,
        "restitution": compare_restitutions,
        "rubbing cables": compare_rubbing,
        "knots": compare_knots,
        "loose knots": compare_loose_knots,
        "default stiffness": compare_penetrations,
    },
    "long": {
        "Pechstein's drive": compare_published_drive,
        "net": compare_net,
        "pile": compare_pile,
        "pile, steps": compare_pile_steps,
        "pile, times": state_time_factors,
        "search": compare_search_times,
    },
}
"""Checks of both parts by name."""

Part = Annotated[
    Literal["quick", "long", "all"],
    typer.Option(help="Checks: those of seconds, or piles, nets and long runs, or all."),
]


@dataclass(frozen=True)
class CheckResult:
    """The comparisons of a check."""

    name: str
    comparisons: Sequence[Comparison]
    seconds: float  # processor time [s]
    failure: str = ""  # message of a run that fails


def reference_values(part: Part = "quick", progress: bool = False) -> list[CheckResult]:
    """Compare values of contact and friction with their references; minutes, all parts longer."""
    checks = [
        check for name, some in CHECKS.items() if part in (name, "all") for check in some.items()
    ]
    return [_run(*check) for check in bar(checks, "check", progress)]


def _run(name: str, check: Check) -> CheckResult:
    """Run a check; a run that fails gives a value that is not a number."""
    begin, failure = time.process_time(), ""
    try:
        comparisons = check()
    except AncfError as error:
        failure = str(error)
        comparisons = [compare_absolute(f"{name}: a run fails", NO_VALUE, NO_VALUE, 0.0)]
    return CheckResult(name, comparisons, time.process_time() - begin, failure)


def value_table(results: Sequence[CheckResult]) -> Table:
    """Set all values next to their references."""
    columns = {
        "quantity": lambda each: each.quantity,
        "found": lambda each: f"{each.value:.6g}",
        "reference": lambda each: f"{each.reference:.6g}" if each.tolerance else "",
        "tolerance": lambda each: each.tolerance,
        "met": _verdict,
    }
    return Table.of(_rows(results), columns, left=(0, 4))


def _rows(results: Sequence[CheckResult]) -> list[Comparison]:
    return [each for result in results for each in result.comparisons]


def _verdict(each: Comparison) -> str:
    if not each.tolerance:
        return ""
    return "yes" if each.is_met else "not met"


def records(results: Sequence[CheckResult]) -> list[dict[str, Any]]:
    """Return the lines of the CSV table."""
    return [
        {
            "check": result.name,
            "quantity": each.quantity,
            "value": each.value,
            "reference": each.reference,
            "tolerance": each.tolerance,
            "met": each.is_met if each.tolerance else None,
        }
        for result in results
        for each in result.comparisons
    ]


def findings(results: Sequence[CheckResult]) -> list[str]:
    """State how many values are within their tolerances, and which are not."""
    rows = [each for each in _rows(results) if each.tolerance]
    missed = [each for each in rows if not each.is_met]
    seconds = ", ".join(f"{result.name} {result.seconds:.2g} s" for result in results)
    return [
        f"{len(rows) - len(missed)} of {len(rows)} values are within their tolerances",
        *(
            f"Not met: {each.quantity}, {each.value:.6g} (reference {each.reference:.6g}, "
            f"{each.tolerance})"
            for each in missed
        ),
        *(f"{result.name} fails: {result.failure}" for result in results if result.failure),
        f"Processor times: {seconds}",
    ]


STUDY = Study(
    "contact-references",
    run=reference_values,
    tables=lambda results: [value_table(results)],
    rows=records,
    record=records,
    findings=findings,
    regions={"contact-references": value_table},
)
