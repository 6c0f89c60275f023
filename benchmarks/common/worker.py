"""Runs in separate processes, so that the peak memory of a process is that of its run.

A process reads jobs, one JSON object per line, and answers each with the record of the run.
"""

from __future__ import annotations

import json
import os
import resource
import select
import subprocess
import sys
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from types import TracebackType
from typing import Any, Self


@dataclass
class Answered:
    """A job with the answer of a process, for the rows of studies."""

    job: Any
    # as the process returned it, the last time
    record: dict[str, Any] = field(default_factory=dict)

    @property
    def note(self) -> str:
        """The reason of a missing result, or nothing."""
        return str(self.record.get("note", ""))

    @property
    def fastest(self) -> float:
        """Least time of the time loop [s]."""
        return float(self.record["seconds"])

    @property
    def microseconds(self) -> float:
        """Least time of the time loop per element and step [microseconds]."""
        return 1e6 * self.fastest / int(self.job.steps * self.job.elements)

    @property
    def bytes_per_element(self) -> float:
        """Peak memory above that of an idle process [bytes]."""
        taken = float(self.record["peak_bytes"] - self.record["base_bytes"])
        return taken / int(self.job.elements)


class Worker:
    """A process that runs jobs one by one, as a context manager.

    Parameters
    ----------
    module : str
        What it runs; as a program, this module calls `serve`.
    """

    def __init__(self, module: str) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", module],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            env=os.environ | {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"},
        )

    def __enter__(self) -> Self:
        """Return the worker."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the process."""
        if kind is not None:
            self.process.kill()
        self.process.communicate()

    def run(self, job: Any, limit: float | None = None) -> dict[str, Any]:
        """Run a job, for `limit` seconds at most; without a record, a note gives the reason."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        try:
            self.process.stdin.write(json.dumps(asdict(job)) + "\n")
            self.process.stdin.flush()
            # One answer per job and none before it, so nothing waits in the buffer of the file.
            if not select.select([self.process.stdout], [], [], limit)[0]:
                self.process.kill()
                self.process.wait()
                return {"note": f"ended after {limit:g} s"}
            answer = self.process.stdout.readline()
        except BrokenPipeError:
            answer = ""
        if not answer:
            return {"note": f"the process ended with exit code {self.process.wait()}"}
        record: dict[str, Any] = json.loads(answer)
        return record


def serve(run: Callable[[dict[str, Any]], dict[str, Any]]) -> None:
    """Answer jobs on stdin until it ends; whatever else is printed is thrown away."""
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)
    for line in sys.stdin:
        answers.write(json.dumps(run(json.loads(line))) + "\n")
        answers.flush()


def peak_memory() -> int:
    """Return the largest resident memory of this process so far [bytes].

    ``ru_maxrss`` would do, but for a child process Linux starts it at what the parent had.
    """
    status = Path("/proc/self/status")
    if status.exists():
        for line in status.read_text(encoding="utf-8").splitlines():
            if line.startswith("VmHWM:"):
                return 1024 * int(line.split()[1])
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
