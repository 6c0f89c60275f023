"""Select the nonlinear solver of a system for ``solver="auto"``."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from ancfsparse.nonlinear import Method, ModifiedNewton, QuasiNewton
from ancfsparse.nonlinear.iteration import describe
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.preparation.solver_settings import check_solver

if TYPE_CHECKING:
    from ancfsparse.seeds import Seed

# A thick beam of 5 elements has a ratio of 1.0, and a dense inverse saves a fifth of the time; one
# of 10 and a cable of 10 have 1.8, and it costs time.
MAX_DENSE_RATIO = 1.2  # numbers of a dense inverse over operations of a sweep
# For rigid bodies only the constraints are stiff, and they rotate: sparse seeds are renewed in
# every second to fourth step, dense ones, corrected by pairs, never.  Processor time of Davidon's
# update over that of modified Newton, set-up included: four-bar linkages in a row .80, .84, .94 and
# 1.3 for ratios of 1.9, 6.2, 9.1 and 11.9, Andrews' squeezer .70 for 2.8, Bricard's mechanism .42
# for 1.6.
MAX_LINKAGE_DENSE_RATIO = 7.0  # the same ratio

# Seeds in a corotated frame store nine more vectors.  On long chains the factor is hardly larger
# and sweeps are cheap, so they gain little; on nets the factor is far larger.
MAX_COROTATED_UNKNOWNS = 20_000  # unknowns, on chains
MIN_COROTATED_FLOPS = 100  # operations of a sweep per unknown, above that size
LOW_MEMORY_PAIRS = 2  # secant pairs on incomplete seeds; more save no more


def choose_solver(
    requested: Method | str, seed: Seed, is_linear: bool, is_linkage: Callable[[], bool] = bool
) -> tuple[Method, str]:
    """Return the method and a sentence that explains the choice.

    Full-memory BFGS is the fastest on a nearly full matrix, but requires positive curvature, which
    nonlinear constraints do not provide; Davidon's update does not require it.  That is selected
    for linkages of rigid bodies too, up to about a dozen loops.  All other systems use modified
    Newton: a sweep is so cheap that secant pairs cost time on chains and on nets in smooth motion,
    and make no difference on nets in irregular motion
    (``python -m benchmarks scaling secant-pairs``).
    Incomplete seeds need more corrections; where those contract slowly, two BFGS pairs save up to a
    third of them.

    Parameters
    ----------
    requested : Method or "auto"
        Solver given by the caller.
    seed : SparseSeed or IncompleteSeed
        Sparse factor.
    is_linear : bool
        Whether all constraint equations are linear, or there are none.
    is_linkage : callable, optional
        Returns whether the scene consists of rigid bodies that can move.
    """
    check_solver(requested)
    incomplete = not isinstance(seed, SparseSeed)
    factor = f"with {'an incomplete' if incomplete else 'a sparse'} factorization"
    if not isinstance(requested, str):
        return requested, f"{describe(requested)}{f' {factor}' * incomplete}: requested"
    n, solve_flops = seed.n, seed.solve_flops
    method: Method
    counts = (
        f"{n} unknowns, {n * n} numbers in a dense inverse, {solve_flops} operations in a sweep"
    )
    corotates = n <= MAX_COROTATED_UNKNOWNS or solve_flops > MIN_COROTATED_FLOPS * n
    frame = "auto" if corotates else "fixed"
    if incomplete:
        method = QuasiNewton("bfgs", memory=LOW_MEMORY_PAIRS, seed_frame=frame)
        return (
            method,
            f"{describe(method)} where sweeps contract slowly, {factor}: {counts}",
        )
    ratio = n * n / solve_flops
    if ratio <= MAX_DENSE_RATIO or (ratio <= MAX_LINKAGE_DENSE_RATIO and is_linkage()):
        method = QuasiNewton("bfgs" if is_linear else "davidon", memory="full")
        curvature = "linear constraints" if is_linear else "nonlinear constraints"
        return method, f"{describe(method)}: {counts}, {curvature}"
    method = ModifiedNewton(seed_frame=frame)
    return method, f"{describe(method)} {factor}: {counts}"
