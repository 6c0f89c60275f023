"""Damaged files: refused in a sentence, or read as they were written.

Files of scenes with mistakes, which users write: refused in a line, or run.
"""

import contextlib
import copy
import io
import json
import resource
import tempfile
import tomllib
import warnings
from functools import cache
from pathlib import Path

import numpy as np
import typer

import ancfsparse as ancf
from ancfsparse import problems as named
from ancfsparse.cli.app import app, run_app
from ancfsparse.cli.scene_run import STARTER
from ancfsparse.results.hdf5_reader import load
from ancfsparse.scene.storage.toml_text import toml, written_as_toml
from tests.soak.report import Report

DAMAGES = ("bits", "zeros", "words", "noise", "cut", "hole", "swap")
SCENES = (
    "pendulum", "catenary", "cable_drop", "heavy_top", "crane", "sliding_bead", "pile", "octet",
    "bricard", "moving_supports", "cantilever_on_cylinders",
)  # fmt: skip
MISTAKES = ("letters", "lines", "fragment", "value", "key", "exchange", "several values")
FRAGMENTS = (
    "1e999", "-1", "nan", "inf", "0", "1e-300", "[[", "]]", "{", "}", "=", "\"", "'''", "[" * 300,
    "9" * 500, "true", "1979-05-27T07:32:00Z", "\\u0000", "\n", "#", ".", "\ud7ff", "0x7fffffff",
)  # fmt: skip
ODD = (
    None, True, False, 0, 1, -1, 2, 3, 10**5, 10**9, 10**30, -(10**400), 0.5, 1e-300, 1e300, -1e9,
    1e99, "", " ", "rope", "rope.end", "rope.at(1e9)", "rope.node(-1)", "beam 0.start", "1 mm",
    "1e300 GPa", "10 mmm", "9**9**9 m", "nan m", "auto", "biot", "free", "x" * 10**5, "/dev/zero",
    [], [0], [0, 0], [1, 2, 3], [[0, 0], [1, 0]], ["1 m", "2 m"], [None], ["rope"], [[[[]]]],
    {}, {"kind": "Ramp", "value": 1, "end": 1}, {"kind": "Sine"}, {"kind": "Circle", "diameter": 1},
    {"kind": "Table", "csv": "/dev/zero"}, {"kind": "Point", "body": "rope", "index": 0, "xi": 0.5},
    {"own": "os.system"}, {"array": "<f8", "shape": [10**12], "base64": "AAAA"},
    {"array": "O", "shape": [1], "base64": "AAAAAAAAAAA="}, {"kind": "Sum", "parts": []},
    {"kind": "Joint", "body": "x", "number": 0}, {"kind": "Newton", "max_iterations": 10**9},
)  # fmt: skip
MEMORY = 2e9  # bytes that a scene in a file may need here


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
    elif damage == "words":  # which a checksum of sums modulo 65535 does not distinguish
        data[start : start + length] = data[start : start + length].replace(b"\xff\xff", bytes(2))
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


@cache
def good_scenes():
    """Return texts of files of scenes, TOML and JSON."""
    texts = [STARTER.read_text(encoding="utf-8")]
    texts += [written_as_toml(getattr(named, name)().scene, {"t_end": 1.0}) for name in SCENES]
    files = [(text, ".toml") for text in texts]
    files += [(json.dumps(tomllib.loads(text), indent=1), ".json") for text in texts]
    with tempfile.TemporaryDirectory() as folder:
        for name in SCENES:
            path = Path(folder, "scene.json")
            getattr(named, name)().scene.save(path)
            files.append((path.read_text(encoding="utf-8"), ".json"))
    return files


def run_scene(seed, index):
    """Check and run a file of a scene with a mistake, by the command."""
    rng = np.random.default_rng([seed, index])
    files = good_scenes()
    text, ending = files[int(rng.integers(len(files)))]
    mistake = str(rng.choice(MISTAKES))
    wrong = text_with(mistake, rng, text, ending)
    tried = f"{mistake} in {ending}"
    with (
        tempfile.TemporaryDirectory() as folder,
        limited_memory(),
        warnings.catch_warnings(),
    ):
        # Exchanged numbers can move a cable into an obstacle of a given stiffness.
        begins = ".*begins with a penetration"
        warnings.filterwarnings("ignore", begins, ancf.PenetrationWarning)
        file, output = Path(folder, f"scene{ending}"), Path(folder, "run.h5")
        file.write_bytes(wrong.encode("utf-8", "replace"))
        code, message = called("check", file)
        if code == 0:
            code, message = called("run", file, "-o", output, "--time", "0.003", "--step", "1e-3")
    finds = []
    if code not in (0, 1, 2) or (code and not message.startswith("ancfsparse: ")):
        finds.append(f"exit code {code}: {message[:200]}")
    if code == 2 and "scene." not in message:
        finds.append(f"no file in: {message[:200]}")
    return Report({0: "ran", 1: "run failed"}.get(code, "refused"), finds, tried)


@cache
def command():
    """Return the command, which takes longer to make than a small scene to run."""
    return typer.main.get_command(app)


def called(*words):
    """Return the exit code of the command, and its errors."""
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            run_app(command(), "ancfsparse", [str(word) for word in words])
        except SystemExit as end:
            return end.code or 0, err.getvalue()
    return 0, err.getvalue()


@contextlib.contextmanager
def limited_memory():
    """Limit the address space to what is in use and `MEMORY`; beyond, allocations fail."""
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    used = pages * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (int(used + MEMORY), hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


def text_with(mistake, rng, text, ending):
    """Return the text of a file with a mistake."""
    lines = text.split("\n")
    if mistake == "letters":
        letters = list(text)
        for place in rng.integers(len(letters), size=int(10 ** rng.uniform(0, 1.5))):
            letters[place] = chr(int(rng.integers(1, 300)))
        return "".join(letters)
    if mistake == "lines":
        first, other = (int(rng.integers(len(lines))) for _ in range(2))
        if rng.random() < 0.5:
            lines[first], lines[other] = lines[other], lines[first]
        else:
            lines[first:other] = []
        return "\n".join(lines)
    if mistake == "fragment":
        place, end = (int(rng.integers(len(text))) for _ in range(2))
        return text[:place] + str(rng.choice(FRAGMENTS)) + text[min(place + end % 7, len(text)) :]
    data = tomllib.loads(text) if ending == ".toml" else json.loads(text)
    for _ in range(int(rng.integers(2, 6)) if mistake == "several values" else 1):
        inner, key = chosen(rng, data)
        if mistake == "key" and isinstance(inner, dict):
            inner[f"{key}{rng.choice(list('sx_ .'))}"] = inner.pop(key)
        elif mistake == "exchange":
            there, other = chosen(rng, data)
            inner[key], there[other] = there[other], inner[key]
        else:
            inner[key] = copy.deepcopy(ODD[int(rng.integers(len(ODD)))])
    if ending == ".json":
        return json.dumps(data, indent=int(rng.integers(3)))
    return "".join(f"{toml(str(name))} = {toml(value)}\n" for name, value in data.items())


def chosen(rng, data):
    """Return a random container in nested data, and a key of it."""
    while True:
        keys = list(data) if isinstance(data, dict) else range(len(data))
        key = keys[int(rng.integers(len(keys)))]
        inner = data[key]
        if not isinstance(inner, dict | list) or not inner or rng.random() < 0.15:
            return data, key
        data = inner
