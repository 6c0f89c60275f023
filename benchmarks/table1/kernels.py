"""Nanoseconds and operations of every element kernel on every instruction set."""

from __future__ import annotations

import subprocess
from dataclasses import dataclass

from ancfsparse.dispatch import available_instruction_sets
from ancfsparse.kernels.benchmark import Timing, kernel_table, speed_ratios
from ancfsparse.kernels.catalog import REFERENCES, module_names
from benchmarks.common.progress import bar as progress_bar
from benchmarks.common.tables import Table
from benchmarks.common.target import Target

CLOSED, GAUSS = "thick_axis_consistent", "thick_axis_consistent_gauss"

LANES_COMPARED = ("l2t2", "thin_planar_green", "thin_spatial_green", CLOSED)
"""Kernels whose force is also compiled for one element at a time."""


@dataclass(frozen=True)
class KernelBench:
    """Everything `python -m benchmarks bench-kernels` measures.

    Attributes
    ----------
    timings : list of Timing
        Every kernel of every module on every instruction set.
    lanes : dict of str to (float, float)
        Force with one lane and with full vectors [ns per element]; empty outside of a checkout.
    targets : list of Target
        The target.
    """

    timings: list[Timing]
    lanes: dict[str, tuple[float, float]]
    targets: list[Target]

    def __str__(self) -> str:
        """Set the table for a terminal: a line per kernel, a column per instruction set."""
        sets = list(dict.fromkeys(each.instruction_set for each in self.timings))
        ns = {(t.name, t.kernel, t.instruction_set): t.ns_per_element for t in self.timings}
        rows = [
            [f"{t.name} {t.kernel}", f"{t.operations}"]
            + [f"{ns[t.name, t.kernel, each]:.1f}" for each in sets]
            for t in self.timings
            if t.instruction_set == sets[0]
        ]
        title = "Nanoseconds per element, gather and scatter included"
        lines = [str(Table(["", "operations", *sets], rows, title=title)), ""]
        if not self.lanes:
            lines += [
                "One lane against full vectors needs a checkout and a compiler: left out.",
                "",
            ]
        return "\n".join([*lines, *map(str, self.targets)])


def bench_kernels(progress: bool = False) -> KernelBench:
    """Time all kernels."""
    names = (*module_names(), *REFERENCES)
    timings = []
    with progress_bar(names, "element", progress) as bar:
        for name in bar:
            bar.set_description(name)
            timings += kernel_table([name])
    try:
        lanes = speed_ratios(LANES_COMPARED)
    except (ValueError, OSError, subprocess.CalledProcessError):
        lanes = {}  # no checkout, or no compiler: the other numbers stand on their own
    force = {(t.name, t.instruction_set): t.ns_per_element for t in timings if t.kernel == "force"}
    targets = [
        Target(
            f"thick force, Gauss / closed form, {each}",
            force[GAUSS, each] / force[CLOSED, each],
            2.0,
        )
        for each in available_instruction_sets()
    ]
    targets += [
        Target(f"{name} force, one lane / full vectors", single / full, 3.0)
        for name, (single, full) in lanes.items()
    ]
    return KernelBench(timings, lanes, targets)
