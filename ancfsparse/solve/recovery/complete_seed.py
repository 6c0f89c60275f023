"""Recovery by a complete seed, which also replaces an incomplete one that costs more."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ancfsparse.errors import InputError
from ancfsparse.nonlinear import Outcome
from ancfsparse.solve import preparation
from ancfsparse.solve.recovery.recovery import RecoverableRun, Recovery
from ancfsparse.solve.stepping.outcome_reporting import CAUSE_NAMES


class CompleteSeed(Recovery):
    """Continues with a complete in place of an incomplete factorization, if it fits in memory.

    Parameters
    ----------
    run : RecoverableRun
        A run with an incomplete seed that was selected by "auto".

    Attributes
    ----------
    interval : int
        Number of steps until the next comparison.
    """

    name = "complete seed"

    def __init__(self, run: RecoverableRun) -> None:
        super().__init__(run)
        self._comparison, self._longest = run.setup.back, run.longest_chunk
        self.interval = min(self._longest, preparation.FIRST_COMPARISON)
        self._compared = 0, self.interval  # last step before a comparison, steps to the next

    @property
    def _operations(self) -> tuple[Mapping[str, int], tuple[int, int]]:
        return self._iteration.counts, self._run.seeds[0].inner

    def applies(self, outcome: Outcome) -> bool:
        """Return whether a step with an outcome can be recovered in this way."""
        return self._comparison is not None and super().applies(outcome)

    def attempt(self, step: int, outcome: Outcome) -> Outcome:
        """Try to recover a step, and return its new outcome."""
        self.interval = self._compared[1]
        if not self._switch(step, CAUSE_NAMES[outcome]):
            return outcome
        self._record(step, self.name, outcome, self._iteration.contraction)
        return Outcome.CONVERGED

    def compare(self) -> None:
        """Switch if complete seeds had cost less since the last comparison, and another is due."""
        steps, (last, interval) = self._run.stats.steps, self._compared
        if self._comparison is None:
            return
        if steps < last + interval:  # a simulation pauses at any step
            self.interval = min(last + interval - steps, self._longest)
        elif self._comparison.is_cheaper(*self._operations):
            self.interval = interval
            self._switch(steps + 1, "which cost less")
        else:
            self.interval = min(2 * interval, self._longest)
            self._compared = steps, self.interval

    def _switch(self, step: int, why: str) -> bool:
        """Take the complete seed from a step on; return whether it fits in memory."""
        if not self._take():
            return False
        self._run.stats.solver += f"; from step {step} with a complete factorization ({why})"
        self._iteration.step = step - 1
        return True

    def _take(self) -> bool:
        assert self._comparison is not None
        complete, self._comparison = self._comparison.switch(), None
        if complete is not None:
            self._run.seeds.append(complete)
        return complete is not None

    def describe_memory(self) -> dict[str, Any]:
        """Return the memory that is not in a checkpoint."""
        since = self._comparison.since_comparison(*self._operations) if self._comparison else None
        return {"chunk": self.interval, "compared": self._compared, "since": since}

    def take_memory(self, stored: Mapping[str, Any]) -> None:
        """Set the memory that `describe_memory` has returned, of a run that has switched or not."""
        if self._comparison and stored["is_switched"] and not self._take():
            raise InputError(
                "the complete factorization that the run had switched to does not fit in the "
                "free memory: resume it where more is free"
            )
        if self._comparison:
            self._comparison.continue_comparison(stored["since"], *self._operations)
        self.interval, self._compared = stored["chunk"], tuple(stored["compared"])
