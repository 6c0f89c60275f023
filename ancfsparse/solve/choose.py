"""``solver="auto"``: the method for a system, and why."""

from __future__ import annotations

from ancfsparse.errors import InputError, check_choice
from ancfsparse.nonlinear import Method, ModifiedNewton, Newton, QuasiNewton
from ancfsparse.nonlinear.iteration import describe

# A dense inverse of this many unknowns fits the second-level cache of common machines.
DENSE_UP_TO = 200
PAIRS = 10


def choose(wish: Method | str, n: int, straight: bool) -> tuple[Method, str]:
    """Return the method and a sentence on the choice.

    For few unknowns full-memory BFGS is the most accurate and among the fastest, but it presumes
    positive curvature, which constraints whose gradient turns do not give; Davidon's does not.

    Parameters
    ----------
    wish : Method or "auto"
        What the person said.
    n : int
        Number of unknowns.
    straight : bool
        Whether all constraint equations are linear, or there are none.
    """
    if isinstance(wish, Newton | ModifiedNewton | QuasiNewton):
        return wish, f"{describe(wish)}, as asked"
    if not isinstance(wish, str):
        raise InputError(
            f"solver must be 'auto', Newton(), ModifiedNewton() or QuasiNewton(...), got {wish!r}"
        )
    check_choice("solver", wish, ("auto",))
    method: Method
    if n <= DENSE_UP_TO:
        method = QuasiNewton("bfgs" if straight else "davidon", memory="full")
        turning = "no constraint turns" if straight else "constraints turn with the motion"
        return method, f"{describe(method)}: {n} unknowns fit the cache densely, {turning}"
    method = QuasiNewton("broyden", memory=PAIRS)
    return method, f"{describe(method)} on a sparse seed: {n} unknowns are too many for a dense one"
