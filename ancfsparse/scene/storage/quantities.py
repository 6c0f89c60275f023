"""Numbers with units in files of scenes, such as "10 mm" or "210 GPa".

The result is the double nearest to the number in SI units: "7 mm" is 0.007, to the last bit.
Angles have a dimension of their own here, so that 10 Hz is not accepted as an angular velocity.

The table of units is short and takes the place of pint; tests compare both.  Pint 0.25 evaluates
texts (``9**9**9 m`` takes minutes), rounds 144 of "1 mm" to "999 mm" to a neighbour, accepts 10 Hz
as an angular velocity, and takes a second to load; and a file that one machine reads would not be
read by another without it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value, suggest_names


class Unit(NamedTuple):
    """A unit: its factor to SI units, and its exponents of kg, m, s and rad."""

    factor: Fraction
    dimension: tuple[int, int, int, int]


def _unit(factor: str | float | Fraction, *dimension: int) -> Unit:
    kg, m, s, rad = (*dimension, 0, 0, 0, 0)[:4]
    return Unit(Fraction(factor), (kg, m, s, rad))


PREFIXES = {
    "T": 12, "G": 9, "M": 6, "k": 3, "c": -2, "m": -3, "u": -6, "µ": -6, "μ": -6, "n": -9,
}  # fmt: skip
WITH_PREFIXES = {
    "m": _unit(1, 0, 1),
    "g": _unit("0.001", 1),
    "s": _unit(1, 0, 0, 1),
    "N": _unit(1, 1, 1, -2),
    "Pa": _unit(1, 1, -1, -2),
    "J": _unit(1, 1, 2, -2),
    "W": _unit(1, 1, 2, -3),
    "Hz": _unit(1, 0, 0, -1),
    "rad": _unit(1, 0, 0, 0, 1),
}
POUND_FORCE = Fraction("0.45359237") * Fraction("9.80665")
UNITS = {
    **WITH_PREFIXES,
    **{
        prefix + name: Unit(unit.factor * Fraction(10) ** power, unit.dimension)
        for name, unit in WITH_PREFIXES.items()
        for prefix, power in PREFIXES.items()
    },
    "1": _unit(1),
    "-": _unit(1),
    "%": _unit("0.01"),
    "t": _unit(1000, 1),
    "min": _unit(60, 0, 0, 1),
    "h": _unit(3600, 0, 0, 1),
    "bar": _unit(100_000, 1, -1, -2),
    "deg": _unit(Fraction(math.pi) / 180, 0, 0, 0, 1),
    "rev": _unit(2 * Fraction(math.pi), 0, 0, 0, 1),
    "rpm": _unit(Fraction(math.pi) / 30, 0, 0, -1, 1),
    "in": _unit("0.0254", 0, 1),
    "ft": _unit("0.3048", 0, 1),
    "lb": _unit("0.45359237", 1),
    "lbf": _unit(POUND_FORCE, 1, 1, -2),
    "psi": _unit(POUND_FORCE / Fraction("0.0254") ** 2, 1, -1, -2),
}
UNITS |= {"degrees": UNITS["deg"], "°": UNITS["deg"]}
"""Units by their symbols; products are "N m", powers "mm2" or "mm^2", quotients "N s/m"."""

QUANTITY = re.compile(r"\s*([-+]?(?:\d{1,40}\.?\d{0,40}|\.\d{1,40})(?:[eE][-+]?\d{1,3})?)\s*(.*)")
FACTOR = re.compile(r"([^\d^]+|1)(?:\^?(\d))?")


def is_quantity(text: str) -> bool:
    """Return True for a text that begins with a number."""
    return QUANTITY.fullmatch(text) is not None


def parse_quantity(text: str, units: Sequence[str]) -> float:
    """Return a number with a unit in SI units, angles in degrees where these are required.

    Parameters
    ----------
    text : str
        Number and unit, such as "10 mm".
    units : sequence of str
        The SI units that it may have.

    Raises
    ------
    InputError
        If it is not a number with a unit of the same dimension as one of `units`.
    """
    match = QUANTITY.fullmatch(text)
    if match is None:
        raise InputError(
            f"a number is needed, or a number with a unit such as '10 mm', got {format_value(text)}"
        )
    if not match[2]:
        raise InputError(f"{format_value(text)} has no unit: write the number without quotes")
    if not units:
        raise InputError(f"this number has no unit, got {format_value(text)}: leave the unit out")
    unit = parse_unit(match[2])
    for name in units:
        needed = parse_unit(name)
        if needed.dimension == unit.dimension:
            try:
                return float(Fraction(match[1]) * unit.factor / needed.factor)
            except OverflowError:
                raise InputError(
                    f"{format_value(text)} is beyond the range of floating-point numbers"
                ) from None
    raise InputError(f"a unit such as {' or '.join(units)} is needed, got {format_value(text)}")


@lru_cache(maxsize=256)
def parse_unit(text: str) -> Unit:
    """Return a unit from its text, such as "N s/m" or "kg/m3"."""
    top, slash, bottom = text.replace("**", "^").partition("/")
    factor, exponents = Fraction(1), [0, 0, 0, 0]
    for part, sign in ((top, 1), (bottom, -1)):
        for word in re.split(r"[\s*·]+", part.strip()) if part.strip() else ():
            match = FACTOR.fullmatch(word)
            if match is None or match[1] not in UNITS:
                raise InputError(
                    f"unknown unit {format_value(word)} in {format_value(text)}: "
                    + suggest_names(match[1] if match else word, _plain_units())
                )
            power = sign * int(match[2] or 1)
            unit = UNITS[match[1]]
            factor *= unit.factor**power
            exponents = [a + power * b for a, b in zip(exponents, unit.dimension, strict=True)]
    if slash and not bottom.strip():
        raise InputError(f"the unit {format_value(text)} ends in a slash")
    kg, m, s, rad = exponents
    return Unit(factor, (kg, m, s, rad))


def _plain_units() -> list[str]:
    """Return the units for messages, without most of the prefixes."""
    prefixed = {p + name for name in WITH_PREFIXES for p in PREFIXES}
    return [name for name in UNITS if name not in prefixed or name in ("mm", "kg", "kN", "GPa")]
