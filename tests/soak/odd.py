"""Odd calls: any argument of any public callable spoiled gives a result, or one clear sentence."""

import os
import tempfile

import numpy as np

import ancfsparse as ancf
from tests.soak.callables import calls
from tests.soak.couplings import coupling_calls
from tests.soak.mechanisms import mechanism_calls
from tests.soak.outputs import output_calls
from tests.soak.report import Report
from tests.soak.values import VALUES

# Calls in one trial, which share what is set up for them.
AT_ONCE = 40
# Letters that a sentence may have.
LONGEST = 1000


def run(seed, index):
    """Spoil one argument, sometimes two, of some callables."""
    rng = np.random.default_rng([seed, index])
    finds, refused = [], 0
    before = os.getcwd()
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        try:
            every = all_calls()
            for _ in range(AT_ONCE):
                find, was_refused = spoil(rng, every[rng.integers(len(every))])
                finds += find
                refused += was_refused
        finally:
            os.chdir(before)
    return Report("called", finds, f"{AT_ONCE} calls, {refused} refused")


def all_calls():
    """Give the calls of all kinds, which share files in the folder of work."""
    return calls() + mechanism_calls() + coupling_calls() + output_calls()


def spoil(rng, call):
    many = int(rng.choice([1, 1, 1, 2]))
    names = rng.choice(call.parameters, size=min(many, len(call.parameters)), replace=False)
    values = rng.choice(list(VALUES), size=len(names))
    words = ", ".join(f"{name}={value}" for name, value in zip(names, values, strict=True))
    odd = {str(name): VALUES[value]() for name, value in zip(names, values, strict=True)}
    try:
        call.function(**(call.given | odd))
    except ancf.AncfError as refused:
        return check_sentence(f"{call.name}({words})", str(refused)), True
    except Exception as raw:
        text = " ".join(str(raw).split())[:150]
        return [f"{call.name}({words}) raised {type(raw).__name__}: {text}"], False
    return [], False


def check_sentence(what, text):
    if "\n" in text or not 10 < len(text) < LONGEST:
        return [f"{what} was refused by no sentence: {text[:80]!r}"]
    return []
