"""``solver="auto"``: the method for a system, and why."""

from __future__ import annotations

from ancfsparse.errors import InputError, check_choice
from ancfsparse.nonlinear import Method, ModifiedNewton, Newton, QuasiNewton
from ancfsparse.nonlinear.iteration import describe

# A dense inverse of this many unknowns fits the second-level cache of common machines.
DENSE_UP_TO = 200
PAIRS = 10


def choose(wish: Method | str, n: int) -> tuple[Method, str]:
    """Return the method and a sentence on the choice.

    Parameters
    ----------
    wish : Method or "auto"
        What the person said.
    n : int
        Number of unknowns.
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
        method = QuasiNewton("davidon", memory="full")
        return method, f"{describe(method)}: {n} unknowns, a dense inverse fits the cache"
    method = QuasiNewton("broyden", memory=PAIRS)
    return method, f"{describe(method)} on a sparse seed: {n} unknowns are too many for a dense one"
