"""Time and operations of every element kernel on every instruction set."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass

from ancfsparse.dispatch import available_instruction_sets
from ancfsparse.kernels.catalog import REFERENCES, module_names
from benchmarks.common.kernel_timing import Timing, kernel_table, speed_ratios
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.study import Study
from benchmarks.common.tables import Table
from benchmarks.common.target import Target

CLOSED, GAUSS = "thick_axis_consistent", "thick_axis_consistent_gauss"

SCALAR_KERNELS = ("l2t2", "thin_planar_green", "thin_spatial_green", CLOSED)
"""Kernels whose force is also compiled for one element at a time."""

MIN_GAUSS_RATIO = 2.0  # time of the thick force by quadrature, over that in closed form
MIN_VECTOR_GAIN = 3.0  # time of one element at a time, over that of full vectors


@dataclass(frozen=True)
class KernelSpeed:
    """Timings of kernels."""

    timings: list[Timing]  # every kernel of every module on every instruction set
    # force by one lane and by full vectors [ns per element]; empty without compiler or checkout
    lanes: dict[str, tuple[float, float]]


def kernel_speed(progress: bool = False) -> KernelSpeed:
    """Time every element kernel on every instruction set of this machine."""
    timings = []
    with progress_bar((*module_names(), *REFERENCES), "element", progress) as bar:
        for name in bar:
            bar.set_description(name)
            timings += kernel_table([name])
    try:
        lanes = speed_ratios(SCALAR_KERNELS)
    except (ValueError, OSError, subprocess.CalledProcessError):
        lanes = {}  # the other numbers need neither checkout nor compiler
    return KernelSpeed(timings, lanes)


def group_by_instruction_set(result: KernelSpeed) -> Table:
    """Set a line per kernel, a column per instruction set."""
    sets = list(dict.fromkeys(each.instruction_set for each in result.timings))
    ns = {(t.name, t.kernel, t.instruction_set): t.ns_per_element for t in result.timings}
    rows = [
        [f"{t.name} {t.kernel}", f"{t.operations}"]
        + [f"{ns[t.name, t.kernel, each]:.1f}" for each in sets]
        for t in result.timings
        if t.instruction_set == sets[0]
    ]
    title = "Nanoseconds per element, gather and scatter included"
    return Table(["", "operations", *sets], rows, title=title)


def targets(result: KernelSpeed) -> list[Target]:
    """Compare quadrature with closed form, and scalar with vector kernels."""
    force = {
        (t.name, t.instruction_set): t.ns_per_element for t in result.timings if t.kernel == "force"
    }
    entries = [
        Target(
            f"thick force, Gauss / closed form, {each}",
            force[GAUSS, each] / force[CLOSED, each],
            MIN_GAUSS_RATIO,
        )
        for each in available_instruction_sets()
    ]
    return entries + [
        Target(f"{name} force, one lane / full vectors", single / full, MIN_VECTOR_GAIN)
        for name, (single, full) in result.lanes.items()
    ]


STUDY = Study(
    "kernels",
    run=kernel_speed,
    tables=lambda result: [group_by_instruction_set(result)],
    rows=lambda result: result.timings,
    targets=targets,
    notes=lambda result: (
        []
        if result.lanes
        else ["One lane against full vectors needs a checkout and a compiler: left out."]
    ),
)
