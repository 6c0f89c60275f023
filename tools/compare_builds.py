"""Compare this build with another one: processor time per step and counts, in one run.

The other build is named by the Python of its environment, for instance that of an older commit in a
work tree of its own.  Each round starts a process of either build.  They run every case in turn, so
that a slow spell of the machine meets both; time before the second step is not counted.
"""

from __future__ import annotations

import argparse
import json
import statistics
import subprocess
import sys
import time
from collections import defaultdict
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import ancfsparse as ancf
from ancfsparse.problems import chain, net, pendulum

DT = 5e-4
CLOCK = ("first", "all")
COUNTS = ("iterations", "last_corrections", "residual_evaluations", "factorizations")
ELEMENTS = {
    "L2T2": ("l2t2", 2),
    "Thin": ("thin", 3),
    "Thick": ("thick", 3),
    "planar Thick": ("thick", 2),
}
SOLVERS: dict[str, Any] = {
    "Newton": ancf.Newton(),
    "modified Newton": ancf.ModifiedNewton(),
    **{name: ancf.QuasiNewton(name, "full") for name in ("broyden", "davidon", "dfp", "bfgs")},
}


@dataclass(frozen=True)
class Case:
    """A motion: what moves, how large it is, how it begins, and how it is computed."""

    scene: str
    size: int
    motion: str
    solver: str
    tolerance: str
    steps: int

    def __str__(self) -> str:
        """Name the case for the table and for choosing it."""
        return f"{self.scene} {self.size}, {self.motion}, {self.solver}, {self.tolerance}"

    def build(self) -> ancf.Scene:
        """Return the scene."""
        if self.scene in ELEMENTS:
            element, dim = ELEMENTS[self.scene]
            return pendulum(element, self.size, dim).scene
        if self.scene == "net":
            return net(self.size, self.motion).scene
        return chain(self.size, self.motion, "thin").scene

    def run(self) -> dict[str, float]:
        """Return processor seconds of one step with the set-up and of all, and counts per step."""
        seconds = {}
        # The first of them loads modules.
        for name, steps in (("first", 1), ("first", 1), ("all", self.steps)):
            scene, start = self.build(), time.process_time()
            run = ancf.simulate(
                scene,
                steps * DT,
                DT,
                integrator=ancf.Newmark() if self.scene in ELEMENTS else ancf.GeneralizedAlpha(0.9),
                solver=SOLVERS.get(self.solver, "auto"),
                tolerance=self.tolerance,
                save_every=steps,
            )
            seconds[name] = time.process_time() - start
        counts = {name: getattr(run.stats, name) / self.steps for name in COUNTS}
        return seconds | counts


def cases() -> list[Case]:
    """Return all cases."""
    found = []
    for tolerance in ("paper", "default"):
        for element in ELEMENTS:
            found += [Case(element, 10, "rest", name, tolerance, 4000) for name in SOLVERS]
        for motion in ("rest", "smooth"):
            for size, steps in ((100, 2000), (1000, 400), (10_000, 100)):
                found.append(Case("chain", size, motion, "auto", tolerance, steps))
            for size, steps in ((20, 200), (40, 50)):
                found.append(Case("net", size, motion, "auto", tolerance, steps))
    return found


def serve() -> None:
    """Run the cases that come in, one a line, until there are no more."""
    for line in sys.stdin:
        print(json.dumps(Case(**json.loads(line)).run()), flush=True)


def sample(
    chosen: list[Case], pythons: dict[str, str], repeats: int
) -> dict[Case, dict[str, dict[str, float]]]:
    """Run the cases in a process of each build, in turn; return the least times of each."""
    # Without the variables of Python, which could name the package of one build for both.
    command = ["-E", "-P", str(Path(__file__).resolve()), "--serve"]
    processes = {
        name: subprocess.Popen(
            [python, *command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
        for name, python in pythons.items()
    }
    found: dict[Case, dict[str, dict[str, float]]] = {case: {} for case in chosen}
    for case in chosen:
        for name, process in list(processes.items()) * repeats:
            process.stdin.write(json.dumps(asdict(case)) + "\n")
            process.stdin.flush()
            result = json.loads(process.stdout.readline())
            best = found[case].get(name, result)
            found[case][name] = result | {key: min(best[key], result[key]) for key in CLOCK}
    for process in processes.values():
        process.communicate()
    return found


def compare(
    chosen: list[Case], pythons: dict[str, str], rounds: int, repeats: int
) -> list[dict[str, Any]]:
    """Return a row per case: medians over the rounds of seconds and of their ratio, and counts."""
    seconds, ratios = defaultdict(list), defaultdict(list)
    found: dict[Case, dict[str, dict[str, float]]] = {}
    for number in range(rounds):
        names = list(pythons) if number % 2 else list(pythons)[::-1]
        found = sample(chosen, {name: pythons[name] for name in names}, repeats)
        for case, results in found.items():
            for name in pythons:
                time_of = results[name]["all"] - results[name]["first"]
                seconds[case, name].append(time_of / (case.steps - 1))
            ratios[case].append(seconds[case, "this"][-1] / seconds[case, "other"][-1])
    return [
        {
            "case": str(case),
            "steps": case.steps,
            "ratio": statistics.median(ratios[case]),
            "lowest": min(ratios[case]),
            "highest": max(ratios[case]),
        }
        | {f"{name}_seconds": statistics.median(seconds[case, name]) for name in pythons}
        | {f"{name}_{count}": found[case][name][count] for name in pythons for count in COUNTS}
        for case in chosen
    ]


def show(row: dict[str, Any]) -> str:
    """Return a line of the table."""
    counts = "  ".join(
        f"{row[f'other_{count}']:6.3f} {row[f'this_{count}']:6.3f}" for count in COUNTS
    )
    micro = f"{1e6 * row['other_seconds']:9.2f} {1e6 * row['this_seconds']:9.2f}"
    spread = f"{row['ratio']:5.3f} ({row['lowest']:.3f} to {row['highest']:.3f})"
    return f"{row['case']:45} {micro}  {spread}  {counts}"


def main() -> None:
    """Compare by the arguments of the command line, or serve as one of the processes."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("other", nargs="?", help="Python of the environment of the other build")
    parser.add_argument("--cases", nargs="*", default=[""], help="parts of names of cases")
    parser.add_argument("--rounds", type=int, default=5, help="processes of each build")
    parser.add_argument("--repeats", type=int, default=3, help="runs of a case, the fastest counts")
    parser.add_argument("--json", help="file for the rows")
    parser.add_argument("--serve", action="store_true", help=argparse.SUPPRESS)
    args = parser.parse_args()
    if args.serve:
        serve()
        return
    if args.other is None:
        parser.error("name the Python of the other build")
    for part in args.cases:
        if not any(part in str(case) for case in cases()):
            parser.error(f"no case contains {part!r}; one is named {cases()[0]!s}")
    chosen = [case for case in cases() if any(part in str(case) for part in args.cases)]
    rows = compare(chosen, {"other": args.other, "this": sys.executable}, args.rounds, args.repeats)
    print(f"{'case':45} {'us a step: other, this':>19}  this / other  {', '.join(COUNTS)} per step")
    for row in rows:
        print(show(row))
    if args.json:
        Path(args.json).write_text(json.dumps(rows, indent=1) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
