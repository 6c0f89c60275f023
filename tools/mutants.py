"""Change hot code and the generator in small wrong ways, one after the other, and see tests fail.

`tools/mutants.toml` lists the changes.  A mutant is caught if one of its tests fails, and survives
if all pass: then a test is missing, or the change has no effect, and its entry explains why under
``equivalent``.  Files are changed in place and put back, so leave the working tree alone meanwhile.
Compiled modules are rebuilt for each mutant, which takes most of the time: an hour in all.
"""

from __future__ import annotations

import argparse
import signal
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
LIST = Path(__file__).with_suffix(".toml")
TESTS_FAILED = 1  # exit code of pytest
LONGEST = 600.0  # of the tests of a mutant [s]; one that hangs is caught

CAUGHT, SURVIVED, EQUIVALENT = "caught", "SURVIVED", "no effect"
STALE, BROKEN = "STALE", "BROKEN"


@dataclass(frozen=True)
class Mutant:
    """A wrong change.

    Attributes
    ----------
    file : str
        Changed file, from the root of the repository.
    old, new : str
        The text, which is there once, and what takes its place.
    tests : list of str
        Arguments of pytest: the narrowest tests that should fail.
    equivalent : str
        Why no test can fail, if none can.
    """

    file: str
    old: str
    new: str
    tests: list[str]
    equivalent: str = ""

    def __str__(self) -> str:
        """Show the change on one line."""
        return f"{self.file}: {' '.join(self.old.split())} -> {' '.join(self.new.split())}"


def read(path: Path = LIST) -> list[Mutant]:
    """Read a list of mutants."""
    return [Mutant(**entry) for entry in tomllib.loads(path.read_text(encoding="utf-8"))["mutant"]]


def verdict(mutant: Mutant, root: Path = ROOT) -> str:
    """Change the file, run the tests, put the file back."""
    path = root / mutant.file
    original = path.read_text(encoding="utf-8")
    if original.count(mutant.old) != 1 or mutant.old == mutant.new:
        return STALE
    try:
        path.write_text(original.replace(mutant.old, mutant.new), encoding="utf-8")
        if path.suffix != ".py" and _run(["-c", "import ancfsparse"], root) != 0:
            return BROKEN
        code = _run(["-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", *mutant.tests], root)
    finally:
        path.write_text(original, encoding="utf-8")
    if code == 0:
        return EQUIVALENT if mutant.equivalent else SURVIVED
    # A crash of the interpreter, below zero, is caught; pytest that cannot begin is a wrong entry.
    return CAUGHT if code == TESTS_FAILED or code < 0 else BROKEN


def _run(arguments: Sequence[str], root: Path) -> int:
    try:
        return subprocess.run(
            [sys.executable, *arguments], cwd=root, capture_output=True, timeout=LONGEST
        ).returncode
    except subprocess.TimeoutExpired:
        return TESTS_FAILED


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return 1 if a mutant survived or could not be made, else 0."""
    parser = argparse.ArgumentParser(prog="tools/mutants.py", description=__doc__.splitlines()[0])
    parser.add_argument("part", nargs="*", help="only mutants of files whose name contains this")
    parser.add_argument("--list", type=Path, default=LIST, help="default: tools/mutants.toml")
    parser.add_argument("--root", type=Path, default=ROOT, help="default: this repository")
    options = parser.parse_args(arguments)
    mutants = [
        each for each in read(options.list)
        if not options.part or any(part in each.file for part in options.part)
    ]  # fmt: skip
    for each in (signal.SIGINT, signal.SIGTERM):  # so that the file is put back
        signal.signal(each, lambda number, frame: sys.exit(128 + number))
    counts: Counter[str] = Counter()
    for mutant in mutants:
        found = verdict(mutant, options.root)
        counts[found] += 1
        reason = f" ({mutant.equivalent})" if found == EQUIVALENT else ""
        print(f"{found:<10}{mutant}{reason}", flush=True)
    effective = counts[CAUGHT] + counts[SURVIVED]
    share = f"{100 * counts[CAUGHT] / effective:.0f} %" if effective else "none"
    print(f"caught {counts[CAUGHT]} of {effective}: {share}; {counts[EQUIVALENT]} without effect")
    return int(counts[CAUGHT] + counts[EQUIVALENT] < len(mutants))


if __name__ == "__main__":
    sys.exit(main())
