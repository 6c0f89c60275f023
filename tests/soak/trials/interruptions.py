"""Runs that are interrupted or killed: their files hold states of the whole run.

A run passes states on to its file after at most 2000 steps (docs/large.md).  Its process counts
those that have been, so that a file is held to exactly these, however far the run had come.
"""

import multiprocessing
import os
import signal
import tempfile
import time
from functools import cache
from pathlib import Path

import numpy as np

import ancfsparse as ancf
from ancfsparse import problems as named
from ancfsparse.results.export.hdf5_writer import Writer
from ancfsparse.results.hdf5_reader import load
from tests.soak.report import Report

STEPS = 40_000
DT = 5e-4  # [s]
EVERY = 10  # steps between saved states
AT_ONCE = 2000  # most steps between writes
PATIENCE = 120.0  # time limit of a child [s]


def pendulum():
    return named.pendulum("thin", 20).scene


def job(path, pipe):
    """Run to a file; send the number of written states, and the end of the run."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    append = Writer.append

    def counted(writer, *rows, **where):
        append(writer, *rows, **where)
        pipe.send(("passed on", writer.rows))

    Writer.append = counted
    scene = pendulum()
    pipe.send(("ready", 0))
    try:
        ancf.simulate(scene, STEPS * DT, DT, save_every=EVERY, output=path)
    except KeyboardInterrupt as stop:
        carried = getattr(stop, "trajectory", None)
        pipe.send(("an interruption", 0 if carried is None else len(carried.t)))
    else:
        pipe.send(("the end", STEPS // EVERY + 1))


@cache
def whole():
    """Return times and coordinates of every step of the uninterrupted run."""
    run = ancf.simulate(pendulum(), STEPS * DT, DT)
    return run.t, run.q


def run(seed, index):
    rng = np.random.default_rng([seed, index])
    how = signal.Signals(int(rng.choice([signal.SIGINT, signal.SIGKILL])))
    whole()
    wait = float(rng.uniform(0.0, 1.0))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.h5")
        word, carried, passed = interrupt(path, how, wait)
        tried = f"{how.name} after {wait:.2f} s, which came to {word} after {passed} states"
        if word == "a hang":
            return Report("hung", [f"the run did not end {PATIENCE:g} s after {how.name}"], tried)
        return Report(word, judged(path, word, carried, passed), tried)


def judged(path, word, carried, passed):
    """Return the errors of the file of a run that had written these numbers of states."""
    finds, passed = [], [0, *passed]
    if max(np.diff(passed), default=0) > AT_ONCE // EVERY:
        finds.append(f"states were passed on in greater numbers than {AT_ONCE // EVERY}: {passed}")
    try:
        kept = load(path, pendulum())
        times, states = kept.t, kept.q[:]
    except ancf.AncfError as refused:
        # Nothing is promised of a run that has passed on nothing, but that another replaces it.
        ancf.simulate(pendulum(), DT, DT, output=path)
        if passed[-1]:
            finds.append(f"its file cannot be read: {refused}")
        return finds
    (t, q), n, steps = whole(), len(times), np.rint(times / DT).astype(int)
    # All in turn, and the last one.
    in_turn = np.array_equal(steps[:-1], np.arange(0, EVERY * (n - 1), EVERY))
    if not (in_turn and np.allclose(times, t[steps]) and np.array_equal(states, q[steps])):
        finds.append(f"the {n} states in its file are not those of the whole run")
    if n < passed[-1]:
        finds.append(f"{passed[-1]} states were passed on and the file has {n}")
    if word != "a kill" and carried != n:
        finds.append(f"it ended by {word} with {carried} states and the file has {n}")
    return finds


def interrupt(path, how, wait):
    """Run in a child and send it a signal; return its end, its states, and those written."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    child = context.Process(target=job, args=(path, there), daemon=True)
    child.start()
    there.close()
    word, carried, passed = "a hang", 0, []
    try:
        here.recv()
        time.sleep(wait)
        os.kill(child.pid, how)
        while word == "a hang" and here.poll(PATIENCE):
            word, carried = here.recv()
            if word == "passed on":
                passed.append(carried)
                word = "a hang"
    except EOFError:
        word = "a kill"
    child.join(PATIENCE)
    if child.is_alive():
        child.kill()
        child.join()
        word = "a hang"
    return word, carried, passed
