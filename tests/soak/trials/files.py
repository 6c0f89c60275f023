"""Damaged files: refused in a sentence, or read as they were written."""

import tempfile
from functools import cache
from pathlib import Path

import numpy as np

import ancfsparse as ancf
from ancfsparse import problems as named
from ancfsparse.results.hdf5_reader import load
from tests.soak.report import Report

DAMAGES = ("bits", "zeros", "noise", "cut", "hole", "swap")


def pendulum():
    return named.pendulum("thin", 3, as_constraint=True)


@cache
def good_file():
    """Return the bytes of an undamaged file, and its contents."""
    scene, rod = pendulum()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.h5")
        run = ancf.simulate(scene, 0.1, 1e-3, output=path)
        return path.read_bytes(), contents(run, rod)


def contents(run, rod):
    tables = [np.array(getattr(run, name)[:]) for name in ("t", "q", "v", "a", "lam")]
    told = repr((run.stats, run.settings))
    return [*tables, run.position(rod.end), run.energy.total, told]


def run(seed, index):
    rng = np.random.default_rng([seed, index])
    data, expected = good_file()
    damage = str(rng.choice(DAMAGES))
    damaged = bytes(damaged_by(damage, rng, bytearray(data)))
    scene, rod = pendulum()
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "run.h5")
        path.write_bytes(damaged)
        try:
            read = contents(load(path, scene), rod)
        except ancf.AncfError:
            return Report("refused", [], damage)
    if not all(np.array_equal(a, b) for a, b in zip(read, expected, strict=True)):
        return Report("other numbers", [f"a file with {damage} loads with other numbers"], damage)
    return Report("read as written", [], damage)


def damaged_by(damage, rng, data):
    n = len(data)
    start = int(rng.integers(n))
    length = int(min(n - start, 10 ** rng.uniform(0, 4)))
    if damage == "bits":
        for place in rng.integers(n, size=int(10 ** rng.uniform(0, 2))):
            data[place] ^= 1 << int(rng.integers(8))
    elif damage == "zeros":
        data[start : start + length] = bytes(length)
    elif damage == "noise":
        data[start : start + length] = rng.bytes(length)
    elif damage == "cut":
        del data[start:]
    elif damage == "hole":
        del data[start : start + length]
    else:
        other = int(rng.integers(n - length + 1))
        data[start : start + length], data[other : other + length] = (
            data[other : other + length],
            data[start : start + length],
        )
    return data
