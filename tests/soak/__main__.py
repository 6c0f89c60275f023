"""Random trials: scenes, contacts, spoiled calls, units, damaged files, interruptions, kills.

``make soak ARGS="--seed 3 --seconds 120"`` makes trials of all kinds in turn until the time is
over, prints what it tried and found, writes it to results/soak.json, and fails if it found
anything.  With ``--kind`` and ``--index`` it repeats one trial.
"""

import argparse
import json
import math
import sys
import time
from pathlib import Path

from tests.soak.report import Tally, table
from tests.soak.worker import KINDS, Worker, one

# Fractions of the time, relative to each other.
WEIGHTS = {
    "motions": 8,
    "accuracy": 3,
    "odd-calls": 5,
    "units": 3,
    "bodies": 3,
    "statics": 1,
    "plans": 3,
    "contacts": 3,
    "bent-ropes": 1,
    "interior-points": 1,
    "meshes": 1,
    "files": 1,
    "scene-files": 1,
    "interruptions": 1,
    "checkpoints": 3,
    "kills": 1,
}


def main():
    given = arguments()
    if given.index is not None:
        report = one(given.kind[0][0], given.seed, given.index)
        print(report.outcome, report.tried, *report.finds, sep="\n  ")
        return bool(report.finds)
    most = dict(given.kind or dict.fromkeys(KINDS, math.inf))
    tallies, finds = soak(given.seed, given.seconds, most)
    print(table(tallies, finds))
    given.json.parent.mkdir(parents=True, exist_ok=True)
    kinds = {kind: vars(tally) for kind, tally in tallies.items()}
    given.json.write_text(
        json.dumps({"seed": given.seed, "kinds": kinds, "finds": finds}, indent=1)
    )
    return bool(finds)


def soak(seed, seconds, most):
    """Make trials until the time is over: of each kind one at least, and at most `most[kind]`.

    Next is always that kind which is furthest behind its share of the time.
    """
    tallies = {kind: Tally() for kind in most}
    finds, end = [], time.monotonic() + seconds
    with Worker() as worker:
        while time.monotonic() < end or not all(tally.trials for tally in tallies.values()):
            open_kinds = [kind for kind in most if tallies[kind].trials < most[kind]]
            if not open_kinds:
                break
            kind = min(open_kinds, key=lambda each: tallies[each].seconds / WEIGHTS[each])
            tally = tallies[kind]
            report, took = worker.trial(kind, seed, tally.trials)
            trial = {"kind": kind, "seed": seed, "index": tally.trials, "tried": report.tried}
            again = f'make soak ARGS="--seed {seed} --kind {kind} --index {tally.trials}"'
            finds += [trial | {"what": what, "again": again} for what in report.finds]
            tally.add(report, took)
    return tallies, finds


def kind_and_most(text):
    kind, _, most = text.partition(":")
    if kind not in KINDS:
        raise argparse.ArgumentTypeError(f"{kind!r} is none of the kinds {', '.join(KINDS)}")
    return kind, int(most) if most else math.inf


def arguments():
    parser = argparse.ArgumentParser(prog="make soak", description=__doc__.split("\n")[0])
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=120.0)
    parser.add_argument(
        "--kind", type=kind_and_most, action="append", metavar="KIND[:MOST]",
        help=f"only this, with so many trials at most; may be repeated: {', '.join(KINDS)}",
    )  # fmt: skip
    parser.add_argument("--index", type=int, help="make this one trial of one kind again")
    parser.add_argument("--json", type=Path, default=Path("results/soak.json"))
    given = parser.parse_args()
    if given.index is not None and len(given.kind or []) != 1:
        parser.error("--index needs one --kind")
    return given


if __name__ == "__main__":
    sys.exit(main())
