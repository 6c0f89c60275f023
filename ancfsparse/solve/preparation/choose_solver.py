"""``solver="auto"``: the method for a system, and why."""

from __future__ import annotations

from collections.abc import Callable

from ancfsparse.nonlinear import Method, ModifiedNewton, Newton, QuasiNewton
from ancfsparse.nonlinear.iteration import describe
from ancfsparse.seeds import IncompleteSeed, Seed
from ancfsparse.solve.preparation.solver_settings import check_solver

# Up to this many numbers for each operation of a sweep the dense inverse is the faster one: a thick
# beam of 5 elements has 1.0 and gains a fifth; one of 10 and a cable of 10 have 1.8 and lose.
DENSE_AHEAD = 1.2
# The same where all bodies are rigid.  Nothing is stiff beside the constraints, which turn: sparse
# seeds are renewed in every second to fourth step, and dense ones, corrected by pairs, never.
# Processor time of Davidon's update over that of modified Newton, set-up included: four-bar
# linkages in a row .80, .84, .94 and 1.3 for ratios of 1.9, 6.2, 9.1 and 11.9, Andrews' squeezer
# .70 for 2.8, Bricard's mechanism .42 for 1.6.
DENSE_AHEAD_OF_BODIES = 7.0

# Seeds that turn with the body keep nine vectors more.  On long chains, whose factor is not much
# larger and whose sweeps are cheap, that is memory for little; on nets the factor is far larger.
FRAME_UP_TO, FRAME_FROM_FLOPS = 20_000, 100
# Pairs on incomplete seeds; more of them save no more.
SPARING_PAIRS = 2


def choose(
    asked: Method | str, seed: Seed, straight: bool, is_linkage: Callable[[], bool] = bool
) -> tuple[Method, str]:
    """Return the method and a sentence on the choice.

    Where the matrix is nearly full, full-memory BFGS is the fastest, but it presumes positive
    curvature, which constraints whose gradient turns do not give; Davidon's does not.  It is taken
    for linkages of rigid bodies, too, up to about a dozen loops.  Everywhere
    else modified Newton is taken: corrections by a sweep are so cheap that saving some by secant
    pairs loses on chains and on nets in smooth motion, and changes nothing on nets in rough motion
    (``python -m benchmarks memory``).  Incomplete seeds leave more to corrections, and where those
    contract slowly two pairs of BFGS save up to a third of them.

    Parameters
    ----------
    asked : Method or "auto"
        The choice of the caller.
    seed : SparseSeed or IncompleteSeed
        Sparse factor, exact or not.
    straight : bool
        Whether all constraint equations are linear, or there are none.
    is_linkage : callable, optional
        Whether the scene has rigid bodies only, and they can move.
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
    ahead = n * n / solve_flops
    if ahead <= DENSE_AHEAD or (ahead <= DENSE_AHEAD_OF_BODIES and is_linkage()):
        method = QuasiNewton("bfgs" if straight else "davidon", memory="full")
        turning = "no constraint turns" if straight else "constraints turn with the motion"
        return method, f"{describe(method)}: {counts}, {turning}"
    method = ModifiedNewton(seed_frame=frame)
    return method, f"{describe(method)} on {sort} seed: {counts}"
