"""Runs that are killed, resumed, killed again, and at last compared with one that was not."""

import multiprocessing
import os
import signal
import tempfile
import time
from pathlib import Path

import numpy as np

import ancfsparse as ancf
from ancfsparse import problems
from ancfsparse.results.data.checkpoint_file import checkpoint_of
from ancfsparse.results.export import background_writer
from tests.soak.checkpoints.trials import differences, outcome_of
from tests.soak.report import Report
from tests.solve.simulation.scenes import crossing_cables, hanging_body

PATIENCE = 120.0  # time limit of a child [s]
MOST_KILLS = 3  # of one run


def long_cable():
    """Return a cable that is wide enough for incomplete chunks of rows in its file."""
    return problems.pendulum("thin", 300).scene


SCENES = {  # scene, steps, step [s], options
    "cable": (long_cable, 300, 1e-3, {"solver": ancf.QuasiNewton("broyden", 5, carry=True)}),
    "body": (hanging_body, 1000, 1e-3, {"save_every": 3}),
    "contact": (crossing_cables, 600, 1e-3, {"integrator": ancf.HHT(0.1)}),
    "explicit": (long_cable, 1000, 1e-7, {"integrator": ancf.CentralDifference()}),
}
SCHEDULES = 5, 20, 60, "0.05 s", "0.2 s"
THREAD_BYTES = 0, background_writer.MIN_THREAD_BYTES  # of blocks that a thread writes


def begin(name, schedule, thread_bytes, path, pipe):
    """Run a scene to a file."""
    background_writer.MIN_THREAD_BYTES = thread_bytes
    make, steps, dt, options = SCENES[name]
    pipe.send("begins")
    ancf.simulate(make(), steps * dt, dt, output=path, checkpoint=schedule, **options)
    pipe.send("ends")


def go_on(thread_bytes, path, pipe):
    """Resume a run."""
    background_writer.MIN_THREAD_BYTES = thread_bytes
    pipe.send("begins")
    ancf.resume(path)
    pipe.send("ends")


def run(seed, index):
    """Kill a run and its continuations at random times, and compare its end."""
    rng = np.random.default_rng([seed, index])
    name = str(rng.choice(list(SCENES)))
    schedule = SCHEDULES[rng.integers(len(SCHEDULES))]
    thread_bytes = int(rng.choice(THREAD_BYTES))
    make, steps, dt, options = SCENES[name]
    tried, kills, finds = f"{name}, checkpoint={schedule!r}, {thread_bytes=}", 0, []
    with tempfile.TemporaryDirectory() as folder:
        path, other = Path(folder, "run.h5"), Path(folder, "whole.h5")
        clock, is_whole = time.monotonic(), False
        while not is_whole and not finds:
            wait = float(rng.uniform(0.0, 1.0)) if kills < MOST_KILLS else PATIENCE
            # Before the first checkpoint a run can only begin again.
            job = (go_on,) if checkpoint_of(path).exists() else (begin, name, schedule)
            word = kill_after(wait, *job, thread_bytes, path)
            kills, is_whole = kills + (word == "killed"), word == "ends"
            if word not in ("killed", "ends"):
                finds.append(f"a process came to {word} after {kills} kills")
        if not finds:
            again = outcome_of(lambda: ancf.load(path, make()))
            kept = again[2]["checkpoints"]
            whole = outcome_of(
                lambda: ancf.simulate(
                    make(), steps * dt, dt, output=other, checkpoint=kept, **options
                )
            )
            finds = differences(whole, again)
        tried += f", {kills} kills, {time.monotonic() - clock:.1f} s"
    return Report(f"{kills} kills", finds, tried)


def kill_after(wait, call, *arguments):
    """Call a function in a process that is killed after a time; return how it ends."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    child = context.Process(target=call, args=(*arguments, there), daemon=True)
    child.start()
    there.close()
    word = "no begin"
    try:
        word = here.recv()
        if here.poll(wait):
            word = here.recv()
        else:
            os.kill(child.pid, signal.SIGKILL)
            word = "killed"
    except EOFError:
        word = "an error"
    child.join(PATIENCE)
    return word
