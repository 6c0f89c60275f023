"""The process that trials run in, so that one that hangs or crashes is a find and not the end."""

import contextlib
import faulthandler
import multiprocessing
import os
import signal
import tempfile
import time
import traceback
import warnings
from pathlib import Path

from tests.soak.checkpoints import kills, trials as checkpoints
from tests.soak.contacts import trials as contacts
from tests.soak.report import Report
from tests.soak.trials import (
    accuracy,
    bodies,
    files,
    interior_points,
    interruptions,
    motions,
    nets,
    plans,
    spoiled_calls,
    statics,
    units,
)

KINDS = {
    "motions": motions.run,
    "accuracy": accuracy.run,
    "odd-calls": spoiled_calls.run,
    "units": units.run,
    "bodies": bodies.run,
    "statics": statics.run,
    "plans": plans.run,
    "contacts": contacts.run,
    "bent-ropes": contacts.run_bend,
    "meshes": nets.run,
    "files": files.run,
    "scene-files": files.run_scene,
    "interior-points": interior_points.run,
    "interruptions": interruptions.run,
    "checkpoints": checkpoints.run,
    "kills": kills.run,
}
LIMIT = 60.0  # processor time of a trial, of which a run takes seconds [s]
IDLE = 5.0  # time on the clock after which a trial hangs, over that limit


def one(kind, seed, index):
    """Make one trial; any error and any warning that comes out of it is a find.

    But for those that the package gives on purpose.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            report = KINDS[kind](seed, index)
        except Exception as raw:
            last = traceback.extract_tb(raw.__traceback__)[-1]
            text = " ".join(str(raw).split())[:200]
            where = f"{os.path.basename(last.filename)}:{last.lineno}"
            report = Report("broke", [f"raw {type(raw).__name__} at {where}: {text}"])
    foreign = [each for each in caught if not issubclass(each.category, spoiled_calls.ON_PURPOSE)]
    for each in {f"{w.category.__name__}: {w.message}": w for w in foreign}.values():
        where = f"{os.path.basename(each.filename)}:{each.lineno}"
        report.finds.append(f"{each.category.__name__} at {where}: {each.message}")
    return report


def serve(pipe, notes, limit):
    """Make the requested trials; leave a traceback in a file if one hangs or crashes."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)  # progress bars
    with open(notes, "w") as file:
        faulthandler.enable(file)
        while (trial := pipe.recv()) is not None:
            file.truncate(0)
            faulthandler.dump_traceback_later(0.9 * limit, file=file)
            report = one(*trial)
            faulthandler.cancel_dump_traceback_later()
            pipe.send(report)


class Worker:
    """Make trials in another process, which is replaced when it hangs or crashes."""

    def __init__(self, limit=LIMIT):
        self.limit = limit
        self._folder = tempfile.TemporaryDirectory()
        self._notes = os.path.join(self._folder.name, "traceback")
        self._process = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self._process is not None:
            self._pipe.send(None)
            self._process.join(LIMIT)
        self._end()
        self._folder.cleanup()

    def trial(self, kind, seed, index):
        """Make one trial; return its report and how long it took [s]."""
        if self._process is None:
            self._start()
        begin = time.monotonic()
        self._pipe.send((kind, seed, index))
        report = None
        with contextlib.suppress(EOFError):
            if self._answers():
                report = self._pipe.recv()
        if report is None:
            word = "hangs" if self._process.is_alive() else "crashes"
            self._end()
            report = Report(word, [f"{word}: {self._where()}"])
        return report, time.monotonic() - begin

    def _answers(self):
        """Wait for a report; whether it comes in time."""
        spent, begin = self._spent(), time.monotonic()
        while not self._pipe.poll(0.1 * self.limit):
            if self._spent() - spent > self.limit or time.monotonic() - begin > IDLE * self.limit:
                return False
        return True

    def _spent(self):
        """Return the time that the process has had a processor [s]."""
        stat = Path(f"/proc/{self._process.pid}/stat").read_text()
        user, system = stat.rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

    def _start(self):
        open(self._notes, "w").close()
        context = multiprocessing.get_context("spawn")
        self._pipe, there = context.Pipe()
        self._process = context.Process(target=serve, args=(there, self._notes, self.limit))
        self._process.start()
        there.close()

    def _end(self):
        if self._process is not None:
            self._process.kill()
            self._process.join()
            self._process = None

    def _where(self):
        """Return the innermost frames of its main thread, the last in the file."""
        with open(self._notes) as file:
            main = file.read().split("\n\n")[-1]
        frames = [line.strip() for line in main.splitlines() if line.strip().startswith("File")]
        return "; ".join(frames[:5]) or "no traceback"
