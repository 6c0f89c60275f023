"""Runs that are interrupted or killed: what is in their file are states of the whole run."""

import multiprocessing
import os
import signal
import tempfile
import time
from functools import cache
from pathlib import Path

import h5py
import numpy as np

import ancfsparse as ancf
from ancfsparse.results.files import load
from tests.soak.report import Report

STEPS, DT = 40_000, 5e-4
# Longest time that a child may take [s].
PATIENCE = 120.0


def pendulum():
    scene = ancf.Scene()
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    rod = scene.add_beam("thin", (0, 0), (2, 0), 20, section, material)
    scene.pin(rod.start)
    return scene


def job(path, pipe):
    """Run to a file; tell how far the run came if it is interrupted."""
    signal.signal(signal.SIGINT, signal.default_int_handler)
    scene = pendulum()
    pipe.send("ready")
    try:
        ancf.simulate(scene, STEPS * DT, DT, save_every=10, output=path)
    except KeyboardInterrupt as stop:
        carried = getattr(stop, "trajectory", None)
        pipe.send(None if carried is None else len(carried.t))
    else:
        pipe.send("finished")


@cache
def whole():
    """Give times and coordinates of every step of the run that nothing interrupts."""
    run = ancf.simulate(pendulum(), STEPS * DT, DT)
    return run.t, run.q


def run(seed, index):
    rng = np.random.default_rng([seed, index])
    how = signal.Signals(int(rng.choice([signal.SIGINT, signal.SIGKILL])))
    t, q = whole()
    wait = float(rng.uniform(0.0, 1.0))
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.h5")
        reported, word = interrupt(path, how, wait)
        tried = f"{how.name} after {wait:.2f} s, which came to {word}"
        if reported is None:
            return Report("hung", [f"the run did not end {PATIENCE:g} s after {how.name}"], tried)
        try:
            kept = load(path, pendulum())
            states, times = kept.q[:], kept.t
        except ancf.AncfError as refused:
            # No state is written before HDF5 has begun the file.
            early = not path.exists() or path.stat().st_size < 10_000 or not h5py.is_hdf5(path)
            finds = [] if early else [f"its file cannot be read: {refused}"]
            ancf.simulate(pendulum(), DT, DT, output=path)
            return Report("no state yet" if early else "lost", finds, tried)
    finds = []
    n, steps = len(times), np.rint(times / DT).astype(int)
    every_tenth = np.array_equal(steps[:-1], np.arange(0, 10 * (n - 1), 10))  # and the last one
    if not (every_tenth and np.allclose(times, t[steps]) and np.array_equal(states, q[steps])):
        finds.append(f"the {n} states in its file are not those of the whole run")
    if how == signal.SIGINT and isinstance(reported, int) and reported != n:
        finds.append(f"the interruption carries {reported} states and the file has {n}")
    if how == signal.SIGINT and word == "an interruption" and not isinstance(reported, int):
        finds.append("the interruption carries no trajectory")
    return Report(word, finds, tried)


def interrupt(path, how, wait):
    """Run in a child, send it a signal; give what it says and a word for it."""
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    child = context.Process(target=job, args=(path, there), daemon=True)
    child.start()
    there.close()
    try:
        here.recv()
        time.sleep(wait)
        os.kill(child.pid, how)
        reported = here.recv() if here.poll(PATIENCE) else None
    except EOFError:
        reported = "killed"
    child.join(PATIENCE)
    if child.is_alive():
        child.kill()
        child.join()
        return None, "a hang"
    words = {"killed": "a kill", "finished": "the end"}
    return reported if reported is not None else "nothing", words.get(reported, "an interruption")
