"""``solver="auto"``: the method for a system, and why."""

from __future__ import annotations

from ancfsparse.nonlinear import Method, ModifiedNewton, Newton, QuasiNewton
from ancfsparse.nonlinear.iteration import describe
from ancfsparse.seeds import IncompleteSeed, Seed
from ancfsparse.solve.settings import check_solver

# Up to this many numbers for each operation of a sweep the dense inverse is the faster one: a thick
# beam of 5 elements has 1.0 and gains a fifth; one of 10 and a cable of 10 have 1.8 and lose.
DENSE_AHEAD = 1.2

# Seeds that turn with the body keep nine vectors more.  On long chains, whose factor is not much
# larger and whose sweeps are cheap, that is memory for little; on nets the factor is far larger.
FRAME_UP_TO, FRAME_FROM_FLOPS = 20_000, 100
# Pairs on incomplete seeds; more of them save no more.
SPARING_PAIRS = 2


def choose(asked: Method | str, seed: Seed, straight: bool) -> tuple[Method, str]:
    """Return the method and a sentence on the choice.

    Where the matrix is nearly full, full-memory BFGS is the fastest, but it presumes positive
    curvature, which constraints whose gradient turns do not give; Davidon's does not.  Everywhere
    else modified Newton is taken: corrections by a sweep are so cheap that saving some by secant
    pairs loses on chains and on nets in smooth motion, and changes nothing on nets in rough motion
    (``ancfsparse study memory``).  Incomplete seeds leave more to corrections, and where those
    contract slowly two pairs of BFGS save up to a third of them.

    Parameters
    ----------
    asked : Method or "auto"
        The choice of the caller.
    seed : SparseSeed or IncompleteSeed
        Sparse factor, exact or not.
    straight : bool
        Whether all constraint equations are linear, or there are none.
    """
    check_solver(asked)
    incomplete = isinstance(seed, IncompleteSeed)
    sort = "an incomplete" if incomplete else "a sparse"
    if isinstance(asked, Newton | ModifiedNewton | QuasiNewton):
        return asked, f"{describe(asked)}{f' on {sort} seed' * incomplete}, as asked"
    n, solve_flops = seed.n, seed.solve_flops
    method: Method
    counts = (
        f"{n} unknowns, {n * n} numbers in a dense inverse, {solve_flops} operations in a sweep"
    )
    turns = n <= FRAME_UP_TO or solve_flops > FRAME_FROM_FLOPS * n
    frame = "auto" if turns else "fixed"
    if incomplete:
        method = QuasiNewton("bfgs", memory=SPARING_PAIRS, seed_frame=frame)
        return method, f"{describe(method)} where sweeps contract slowly, on {sort} seed: {counts}"
    if n * n <= DENSE_AHEAD * solve_flops:
        method = QuasiNewton("bfgs" if straight else "davidon", memory="full")
        turning = "no constraint turns" if straight else "constraints turn with the motion"
        return method, f"{describe(method)}: {counts}, {turning}"
    method = ModifiedNewton(seed_frame=frame)
    return method, f"{describe(method)} on {sort} seed: {counts}"
