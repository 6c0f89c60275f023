"""How an attempt to solve the equations of a step can end."""

from enum import IntEnum


class Outcome(IntEnum):
    """Reasons as the compiled loop gives them; `sentence` says each in words."""

    CONVERGED = 0
    TOO_MANY = 1
    DIVERGED = 2
    NOT_FINITE = 3
    GAINED_ENERGY = 4  # found by the time loop

    @property
    def sentence(self) -> str:
        """The outcome in words, to be completed with time and place."""
        return {
            Outcome.CONVERGED: "converged",
            Outcome.TOO_MANY: "did not converge within the allowed iterations",
            Outcome.DIVERGED: "diverged: the residual grew ten thousandfold",
            Outcome.GAINED_ENERGY: "gained energy that nothing had given",
            Outcome.NOT_FINITE: "left the range of numbers (infinite or undefined residual)",
        }[self]
