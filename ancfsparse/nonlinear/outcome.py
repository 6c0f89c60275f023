"""Outcomes of an attempt to solve the equations of a step, and attempts that recover a step.

Both enumerations are declared, with the meaning of each name, in abi/outcome.h.
"""

import re
from enum import IntEnum
from pathlib import Path

HEADER = Path(__file__).parents[1] / "abi" / "outcome.h"


def read_codes(enumeration: str) -> dict[str, int]:
    """Return the codes of an enumeration in `HEADER`, which compiled code includes."""
    text = HEADER.read_text(encoding="utf-8")
    body = text.partition(f"enum {enumeration} {{")[2].partition("};")[0]
    return {name: int(code) for name, code in re.findall(r"ANCF_(\w+) = (\d+)", body)}


_OUTCOMES = read_codes("ancf_outcome")
_ATTEMPTS = read_codes("ancf_rung")


class Outcome(IntEnum):
    """Outcomes as the compiled loop returns them; `message` describes each."""

    CONVERGED = _OUTCOMES["CONVERGED"]
    TOO_MANY = _OUTCOMES["TOO_MANY"]
    DIVERGED = _OUTCOMES["DIVERGED"]
    NOT_FINITE = _OUTCOMES["NOT_FINITE"]
    GAINED_ENERGY = _OUTCOMES["GAINED_ENERGY"]
    TOO_INACCURATE = _OUTCOMES["TOO_INACCURATE"]
    MAY_GROW = _OUTCOMES["MAY_GROW"]
    INDEFINITE = _OUTCOMES["INDEFINITE"]
    WOULD_GAIN = _OUTCOMES["WOULD_GAIN"]
    HAD_GAINED = _OUTCOMES["HAD_GAINED"]

    @property
    def message(self) -> str:
        """Description of the outcome, to be completed with time and step."""
        return {
            Outcome.CONVERGED: "converged",
            Outcome.TOO_MANY: "did not converge within the allowed iterations",
            Outcome.DIVERGED: "diverged: the residual grew ten thousandfold",
            Outcome.GAINED_ENERGY: "gained energy that nothing had given",
            Outcome.HAD_GAINED: "had gained energy that nothing had given",
            Outcome.WOULD_GAIN: "would gain energy that nothing has given",
            Outcome.TOO_INACCURATE: "exceeded the tolerance of its error",
            Outcome.MAY_GROW: "was more accurate than necessary",
            Outcome.NOT_FINITE: "left the range of numbers (infinite or undefined residual)",
            Outcome.INDEFINITE: "did not converge on a seed whose pivots had a wrong sign",
        }[self]


class Attempt(IntEnum):
    """Attempts at a step, in their order; `description` names each in tables."""

    METHOD = _ATTEMPTS["METHOD"]
    NEW_SEED = _ATTEMPTS["NEW_SEED"]
    DAMPED_NEWTON = _ATTEMPTS["DAMPED_NEWTON"]
    NEWTON = _ATTEMPTS["NEWTON"]
    COASTING = _ATTEMPTS["COASTING"]
    DESCENT = _ATTEMPTS["DESCENT"]

    @property
    def description(self) -> str:
        """Name of the attempt."""
        return {
            Attempt.METHOD: "the method itself",
            Attempt.NEW_SEED: "new seed",
            Attempt.DAMPED_NEWTON: "damped Newton",
            Attempt.NEWTON: "Newton",
            Attempt.COASTING: "Newton from rest",
            Attempt.DESCENT: "descent",
        }[self]
