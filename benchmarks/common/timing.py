"""Interleaved runs of several programs or settings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from tqdm import tqdm

Candidate = TypeVar("Candidate")
Result = TypeVar("Result")

OURS = "ancfsparse"
"""Name of this package in tables and charts."""


def in_turn(
    candidates: Sequence[Candidate],
    run: Callable[[Candidate], Result],
    rounds: int,
    bar: tqdm[Any] | None = None,
    goes_on: Callable[[Candidate, list[Result]], bool] = lambda candidate, entries: True,
) -> list[list[Result]]:
    """Run all in turn, round after round, so that a busy moment of the machine hits them alike.

    Returns the results of each candidate, in order.  It is run again while `goes_on`, given the
    results so far, is true; the bar moves for every run that is made or omitted.
    """
    entries: list[list[Result]] = [[] for _ in candidates]
    for _ in range(rounds):
        for candidate, samples in zip(candidates, entries, strict=True):
            if not samples or goes_on(candidate, samples):
                samples.append(run(candidate))
            if bar is not None:
                bar.update()
    return entries
