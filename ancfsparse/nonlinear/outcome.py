"""How an attempt to solve the equations of a step can end."""

from enum import IntEnum


class Outcome(IntEnum):
    """Reasons as the compiled loop gives them; `sentence` says each in words."""

    CONVERGED = 0
    TOO_MANY = 1
    DIVERGED = 2
    NOT_FINITE = 3
    # Found by the time loop; the next two end a stretch of steps of one length, not a run.
    GAINED_ENERGY = 4
    TOO_INACCURATE = 5
    MAY_GROW = 6
    INDEFINITE = 7  # the cause of an event: one of the first three, on a factor with a wrong sign
    WOULD_GAIN = 8  # every solution found of a step gains energy: it was not accepted
    HAD_GAINED = 9  # found at the end of a run, of some step before

    @property
    def sentence(self) -> str:
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
