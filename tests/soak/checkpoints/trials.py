"""Random runs with checkpoints: a run that is resumed equals the whole one to the last bit.

While the run writes, its files are copied at random times, each in the middle of a write, as a kill
would leave them.  Each copy is resumed, and compared with the run that went on.
"""

import shutil
import tempfile
import warnings
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

import numpy as np

import ancfsparse as ancf
from ancfsparse.results.data import recoverable_file
from ancfsparse.results.data.checkpoint_file import checkpoint_of
from ancfsparse.results.data.recoverable_file import journal_of
from tests.soak import scenes
from tests.soak.contacts import scenes as touching
from tests.soak.report import Report
from tests.soak.trials import bodies

DRAWS = {"beams": scenes.draw, "bodies": bodies.draw_hung, "contacts": touching.draw}
COPIES = 2  # of the files of each run
# Statistics that differ between equal runs: times, and whether the pattern has changed back to the
# one without touching elements, with which a process begins.
OTHERS = "march_seconds", "seconds", "threads", "pattern_changes"
LETTERS = 200  # of a value in a sentence
EXPLICIT_STEPS = 400  # of explicit runs, at most


def run(seed, index):
    """Run a random scene by a random integrator and solver, and resume copies of its files."""
    rng = np.random.default_rng([seed, index])
    kind = str(rng.choice(list(DRAWS)))
    drawn = DRAWS[kind](rng)
    options = {"integrator": scenes.draw_integrator(rng), "solver": scenes.draw_solver(rng)}
    options["max_halvings"] = getattr(drawn, "max_halvings", 0)
    steps, dt = drawn.steps, drawn.dt
    if getattr(drawn, "is_explicit", False) or rng.random() < 0.15:
        explicit = getattr(drawn, "explicit", None)
        options = {
            "integrator": explicit or rng.choice([ancf.CentralDifference(), ancf.DormandPrince()])
        }
        if explicit is None:
            try:
                dt = 0.2 * ancf.stable_step(drawn.scene, options["integrator"])
            except ancf.AncfError as refused:
                return Report(f"refused ({type(refused).__name__})", [], kind)
        steps = min(steps, EXPLICIT_STEPS)
    elif rng.random() < 0.2 and options["solver"] == "auto":
        options["factorization"] = "incomplete"
    options["save_every"] = int(rng.choice([1, 1, 2, 7]))
    options["checkpoint"] = int(rng.integers(1, max(2, steps // 2)))
    if rng.random() < 0.2:
        options["save_nodes"] = [drawn.beams[0].node(0)]
    tried = f"{kind}, {options}, {drawn.words}"
    return attempt(drawn.scene, steps * dt, dt, options, rng, tried)


def attempt(scene, t_end, dt, options, rng, tried=""):
    """Run a scene to a file, and resume copies of it."""
    with tempfile.TemporaryDirectory() as folder:
        path, copies = Path(folder, "run.h5"), [Path(folder, f"{k}.h5") for k in range(COPIES)]
        with copy_while_writing(path, copies, rng):
            whole = outcome_of(lambda: ancf.simulate(scene, t_end, dt, output=path, **options))
        finds, resumed = [], 0
        for copy in copies:
            if not copy.exists():
                continue
            if not checkpoint_of(copy).exists():  # from before the first checkpoint
                continue
            again = outcome_of(lambda at=copy: ancf.resume(at, scene))
            resumed += 1
            finds += differences(whole, again)
        if not finds and whole[0] == "finished" and checkpoint_of(path).exists():
            finds.append("a finished run has left its checkpoint")
        return Report(f"{whole[0]}, {resumed} resumed", finds, tried)


def outcome_of(call):
    """Return how a run ends: a word, its states and statistics, and the text of an error."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            path, word, text = call(), "finished", ""
        except (ancf.StepError, ancf.LoadError) as stop:
            path, word, text = stop.trajectory, type(stop).__name__, str(stop)
        except ancf.AncfError as refused:
            return type(refused).__name__, None, None, str(refused)
    tables = {name: getattr(path, name) for name in ("t", "q", "v", "a", "lam")}
    # With save_nodes only some coordinates are stored.
    states = {name: np.array(getattr(each, "values", each)[:]) for name, each in tables.items()}
    states["internal"] = path.internal
    stats = {name: each for name, each in asdict(path.stats).items() if name not in OTHERS}
    return word, states, stats, text


def differences(whole, again):
    """Return the differences of two outcomes in sentences."""
    if whole[0] != again[0] or whole[3] != again[3]:
        return [f"the run ended with {whole[0]} {whole[3]}, and resumed with {again[0]} {again[3]}"]
    if whole[1] is None:
        return []
    finds = []
    for name, one in whole[1].items():
        other = again[1][name]
        if one.shape != other.shape:
            finds.append(f"{name} has shape {one.shape}, and resumed {other.shape}")
        elif not np.array_equal(one, other):
            row = int(np.flatnonzero((one != other).reshape(len(one), -1).any(axis=1))[0])
            finds.append(f"{name} differs from row {row} on, by {np.max(np.abs(one - other)):.3g}")
    finds += [
        f"{name} is {str(one)[:LETTERS]}, and resumed {str(again[2][name])[:LETTERS]}"
        for name, one in whole[2].items()
        if repr(one) != repr(again[2][name])
    ]
    return finds


@contextmanager
def copy_while_writing(path, copies, rng):
    """Copy a file and its journal at random writes, half way through them, evenly over the run."""
    write, count = recoverable_file._write_all, 0

    def copying(file, data):
        nonlocal count
        count += 1
        part = memoryview(data)
        if rng.random() < len(copies) / count:
            size = int(rng.integers(0, len(data) + 1))
            write(file, part[:size])
            part = part[size:]
            copy = copies[int(rng.integers(len(copies)))]
            shutil.copy(path, copy)
            for beside in (journal_of, checkpoint_of):
                beside(copy).unlink(missing_ok=True)
                if beside(path).exists():
                    shutil.copy(beside(path), beside(copy))
        write(file, part)

    recoverable_file._write_all = copying
    try:
        yield
    finally:
        recoverable_file._write_all = write
