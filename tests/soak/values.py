"""Values that a caller may give by mistake, by what to call them."""

import datetime as dt
from decimal import Decimal
from fractions import Fraction
from pathlib import Path

import numpy as np

import ancfsparse as ancf


class Rude:
    """An object that cannot be written."""

    def __repr__(self):
        raise RuntimeError("no")


def itself():
    inside = [0.0]
    inside.append(inside)
    return inside


VALUES = {
    "None": lambda: None,
    "True": lambda: True,
    "False": lambda: False,
    "''": lambda: "",
    "'no'": lambda: "no",
    "'auto'": lambda: "auto",
    "'full'": lambda: "full",
    "NUL": lambda: "a\0b",
    "a long text": lambda: "x" * 300,
    "bytes": lambda: b"1",
    "0": lambda: 0,
    "-1": lambda: -1,
    "1": lambda: 1,
    "7": lambda: 7,
    "2.5": lambda: 2.5,
    "-0.0": lambda: -0.0,
    "nan": lambda: float("nan"),
    "inf": lambda: float("inf"),
    "-inf": lambda: float("-inf"),
    "5e-324": lambda: 5e-324,
    "1e-300": lambda: 1e-300,
    "1e-30": lambda: 1e-30,
    "1e30": lambda: 1e30,
    "1e300": lambda: 1e300,
    "1e308": lambda: 1e308,
    "10**20": lambda: 10**20,
    "10**400": lambda: 10**400,
    "-10**5000": lambda: -(10**5000),
    "1j": lambda: 1j,
    "float16": lambda: np.float16(0.1),
    "float32": lambda: np.float32(0.1),
    "longdouble": lambda: np.longdouble("1e400"),
    "int8": lambda: np.int8(3),
    "uint64": lambda: np.uint64(2**64 - 1),
    "bool_": lambda: np.True_,
    "timedelta64": lambda: np.timedelta64(1, "s"),
    "datetime": lambda: dt.datetime(2000, 1, 1),
    "Fraction": lambda: Fraction(1, 3),
    "Decimal": lambda: Decimal("0.1"),
    "Decimal sNaN": lambda: Decimal("sNaN"),
    "array()": lambda: np.array(0.1),
    "zeros(0)": lambda: np.zeros(0),
    "zeros(2)": lambda: np.zeros(2),
    "ones(3)": lambda: np.ones(3),
    "zeros((2, 2))": lambda: np.zeros((2, 2)),
    "zeros((3, 0))": lambda: np.zeros((3, 0)),
    "texts": lambda: ["0", "-9.81"],
    "complex array": lambda: np.array([1 + 5j, 0]),
    "object array": lambda: np.array([1, None], dtype=object),
    "masked": lambda: np.ma.array([0.0, -9.81], mask=[0, 1]),
    "structured": lambda: np.zeros(2, dtype=[("x", float), ("y", int)]),
    "ragged": lambda: [[1, 2], [3]],
    "nested": lambda: [[[0.0, 1.0]]],
    "large integers": lambda: [10**400, 0],
    "nan pair": lambda: (float("nan"), 0.0),
    "huge pair": lambda: (1e300, 1e300),
    "tiny pair": lambda: (5e-324, 0.0),
    "pair": lambda: (0.5, 0.25),
    "triple": lambda: (0.5, 0.25, 0.125),
    "()": lambda: (),
    "itself": itself,
    "{}": dict,
    "set": lambda: {1, 2},
    "range": lambda: range(3),
    "generator": lambda: (x for x in (0.0, 1.0)),
    "object": object,
    "rude": Rude,
    "class": lambda: ancf.Newton,
    "function": lambda: lambda *_: 1.0,
    "function of arrays": lambda: lambda x: np.asarray(x)[..., None] * np.ones(2),
    "function to None": lambda: lambda *_: None,
    "function to nan": lambda: lambda *_: (float("nan"), 0.0),
    "Path": lambda: Path("."),
    "no folder": lambda: Path("nowhere/run.h5"),
    "a node elsewhere": lambda: elsewhere().end,
    "a beam elsewhere": lambda: elsewhere(),
    "a body": lambda: body_elsewhere(),
    "a point of a body": lambda: body_elsewhere().origin,
    "a shape": lambda: ancf.Sphere(0.1),
    "a function of time": lambda: ancf.Sine(1.0, 2.0),
    "a scene": ancf.Scene,
    "a rotation": lambda: np.eye(3),
}


def elsewhere():
    """Give a beam of another scene."""
    return ancf.Scene().add_beam(
        "l2t2", (0, 0), (1, 0), 2, ancf.Circle(0.01), ancf.Material(1e8, 1e3)
    )


def body_elsewhere():
    """Give a rigid body of another scene."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    return scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(0, 0, 0))
