"""Values that a caller may give by mistake: labels, and functions that make them."""

import datetime as dt
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np
from hypothesis import strategies as st

import ancfsparse as ancf
from tests.soak.world import World


class Rude:
    """An object that cannot be written."""

    def __repr__(self):
        raise RuntimeError("no")


def itself():
    inside = [0.0]
    inside.append(inside)
    return inside


NUMBERS = (
    None, True, False, 0, -1, 1, 7, 2.5, -0.0, 0.5, float("nan"), float("inf"), float("-inf"),
    5e-324, 1e-300, 1e-30, 1e30, 1e300, 1e308, 10**20, 10**400, 1j, np.float16(0.1),
    np.float32(0.1), np.longdouble("1e400"), np.int8(3), np.uint64(2**64 - 1), np.True_,
    np.timedelta64(1, "s"), dt.datetime(2000, 1, 1), Fraction(1, 3), Decimal("0.1"),
    Decimal("sNaN"), "", "no", "auto", "full", "a\0b", "0", b"1",
)  # fmt: skip
OBJECTS = {
    "-10**5000": lambda: -(10**5000),
    "a long text": lambda: "x" * 300,
    "rude": Rude,
    "itself": itself,
    "{}": dict,
    "set": lambda: {1, 2},
    "range": lambda: range(3),
    "generator": lambda: (x for x in (0.0, 1.0)),
    "object": object,
    "class": lambda: ancf.Newton,
    "Path": lambda: Path("."),
    "no folder": lambda: Path("nowhere/run.h5"),
    "masked": lambda: np.ma.array([0.0, -9.81], mask=[0, 1]),
    "structured": lambda: np.zeros(2, dtype=[("x", float), ("y", int)]),
    "large integers": lambda: [10**400, 0],
    "a rotation": lambda: np.eye(3),
    "function": lambda: lambda *_: 1.0,
    "function of arrays": lambda: lambda x: np.asarray(x)[..., None] * np.ones(2),
    "function to None": lambda: lambda *_: None,
    "function to nan": lambda: lambda *_: (float("nan"), 0.0),
    "function to 1e300": lambda: lambda t: (1e300, 1e300) if t else (0.0, 0.0),
    "a function of time": lambda: ancf.Sine(1.0, 2.0),
    "a shape": lambda: ancf.Sphere(0.1),
    "a scene": ancf.Scene,
    "a node elsewhere": lambda: World(2).rod.end,
    "a beam elsewhere": lambda: World(2).rod,
    "a body": lambda: World(3).box,
    "a point of a body": lambda: World(3).box.origin,
    "a joint elsewhere": lambda: World(3).hinge,
}


def labelled(value):
    return repr(value), lambda: value


def sequences(inner):
    """Draw lists, tuples and arrays of up to four values, which may be nested and ragged."""
    kinds = st.sampled_from([list, tuple, as_array])
    return st.tuples(kinds, st.lists(inner, max_size=4)).map(
        lambda drawn: (
            f"{drawn[0].__name__}({', '.join(label for label, _ in drawn[1])})",
            lambda: drawn[0]([make() for _, make in drawn[1]]),
        )
    )


def as_array(values):
    """Return an array, of objects where numbers do not do."""
    try:
        with np.errstate(all="ignore"):
            return np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        made = np.empty(len(values), dtype=object)
        made[:] = values
        return made


numbers = st.sampled_from(NUMBERS).map(labelled)
objects = st.sampled_from(list(OBJECTS)).map(lambda label: (label, OBJECTS[label]))
ODD_VALUES = st.one_of(
    numbers,
    objects,
    st.floats(-1e3, 1e3, width=16).map(labelled),
    sequences(st.one_of(numbers, sequences(numbers))),
)
