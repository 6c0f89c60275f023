"""Outcomes of an attempt to solve the equations of a step, and attempts that recover a step.

Both enumerations are those of abi/outcome.h, which explains each name; a test compares them.
"""

from __future__ import annotations

from enum import IntEnum


class Outcome(IntEnum):
    """Outcomes as the compiled loop returns them; `message` is completed with time and step."""

    message: str

    CONVERGED = 0, "converged"
    TOO_MANY = 1, "did not converge within the allowed iterations"
    DIVERGED = 2, "diverged: the residual grew ten thousandfold"
    NOT_FINITE = 3, "left the range of numbers (infinite or undefined residual)"
    GAINED_ENERGY = 4, "gained energy that nothing had given"
    INDEFINITE = 5, "did not converge on a seed whose pivots had a wrong sign"
    WOULD_GAIN = 6, "would gain energy that nothing has given"
    HAD_GAINED = 7, "had gained energy that nothing had given"
    PASSES_THROUGH = 8, "would let beams pass through each other"

    def __new__(cls, code: int, message: str = "") -> Outcome:
        """Make a member of its code and its description."""
        member = int.__new__(cls, code)
        member._value_, member.message = code, message
        return member


class Attempt(IntEnum):
    """Attempts at a step, in their order, with the name and the description of each for tables.

    With incomplete seeds, descent follows a new seed.
    """

    description: str
    summary: str

    METHOD = 0, "the method itself", "Takes the selected method."
    NEW_SEED = 1, "new seed", "Takes the selected method with a new factorization."
    DAMPED_NEWTON = (
        2,
        "damped Newton",
        "Takes Newton corrections, halved while they increase the residual, then full ones.",
    )
    NEWTON = 3, "Newton", "Takes Newton's method in place of a solution that gains energy."
    COASTING = 4, "Newton from rest", "Starts without the acceleration of the last step."
    DESCENT = 5, "descent", "Minimizes the potential of the step where its matrix is indefinite."
    LONG_NEWTON = (
        6,
        "damped Newton with more iterations",
        "Allows four times as many damped corrections.",
    )

    def __new__(cls, code: int, description: str = "", summary: str = "") -> Attempt:
        """Make a member of its code, its name and its description."""
        member = int.__new__(cls, code)
        member._value_, member.description, member.summary = code, description, summary
        return member
