"""How an attempt to solve the equations of a step ends, and what saved the step.

Both enumerations are declared in abi/outcome.h, with what each name stands for.
"""

import re
from enum import IntEnum
from pathlib import Path

HEADER = Path(__file__).parents[1] / "abi" / "outcome.h"


def declared(enumeration: str) -> dict[str, int]:
    """Return the codes of an enumeration of `HEADER`, with which compiled code is built."""
    text = HEADER.read_text(encoding="utf-8")
    body = text.partition(f"enum {enumeration} {{")[2].partition("};")[0]
    return {name: int(code) for name, code in re.findall(r"ANCF_(\w+) = (\d+)", body)}


_OUTCOMES, _RUNGS = declared("ancf_outcome"), declared("ancf_rung")


class Outcome(IntEnum):
    """Reasons as the compiled loop returns them; `message` describes each."""

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
        """The outcome in words, to be completed with time and place."""
        return {
            Outcome.CONVERGED: "converged",
            Outcome.TOO_MANY: "did not converge within the allowed iterations",
            Outcome.DIVERGED: "diverged: the residual grew ten thousandfold",
            Outcome.GAINED_ENERGY: "gained energy that nothing had given",
            Outcome.HAD_GAINED: "had gained energy that nothing had given",
            Outcome.WOULD_GAIN: "would gain energy that nothing has given",
            Outcome.TOO_INACCURATE: "had a larger error than it may have",
            Outcome.MAY_GROW: "was more accurate than it has to be",
            Outcome.NOT_FINITE: "left the range of numbers (infinite or undefined residual)",
            Outcome.INDEFINITE: "did not converge on a seed whose pivots had a wrong sign",
        }[self]


class Rung(IntEnum):
    """What saved a step, or tried to, in the order of the attempts; `words` names it in tables."""

    METHOD = _RUNGS["METHOD"]
    NEW_SEED = _RUNGS["NEW_SEED"]
    DAMPED_NEWTON = _RUNGS["DAMPED_NEWTON"]
    NEWTON = _RUNGS["NEWTON"]
    COASTING = _RUNGS["COASTING"]
    DESCENT = _RUNGS["DESCENT"]

    @property
    def words(self) -> str:
        """The rung in words."""
        return {
            Rung.METHOD: "the method itself",
            Rung.NEW_SEED: "new seed",
            Rung.DAMPED_NEWTON: "damped Newton",
            Rung.NEWTON: "Newton",
            Rung.COASTING: "Newton from rest",
            Rung.DESCENT: "descent",
        }[self]
