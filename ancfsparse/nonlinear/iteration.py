"""Configure the compiled nonlinear loop: tolerances, inverse, cost of a seed in counts."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from ancfsparse.checks import check_positive
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError, Parameter
from ancfsparse.nonlinear.loop_protocols import Tolerance
from ancfsparse.nonlinear.methods import Method, ModifiedNewton, Newton, QuasiNewton
from ancfsparse.seeds import Fill, Seed

if TYPE_CHECKING:
    from ancfsparse.abi.nodal_frames import Frame
    from ancfsparse.nonlinear.loop_protocols import DenseInverse, Inverse, NonlinearLoop, OwnInverse

EPSILON = float(np.finfo(float).eps)
DENSE_LIMIT = 4000
# Weight of an entry of a new factor.  Iterations and factors, at the ratio of their measured times
# (2.5 for cables to 15 for nets), were added up over 100 random scenes of the soak and 21
# pendulums, chains and nets, for modified Newton and pairs of Davidon, DFP and BFGS.  Over the best
# weight of each scene the mean is 1.01 to 1.05 for all weights from 4 to 13; for 20 it is 1.02 to
# 1.06, for 40 1.06 to 1.09.
ENTRY = 9.0
# Iterations above the mean cost since the last seed that a step may take before it is renewed.  In
# the same sums, modified Newton takes 1.01 to 1.04 of the best for all values from 0 to 0.5, and
# 1.05 to 1.08 for 1.  Quasi-Newton takes 1.02 to 1.03 for 0.25 and 1.06 to 1.11 for 1, with which
# alone the paper's pendulum renews its seed in no more than 4 % of the steps.
WAITING, WAITING_WITH_PAIRS = 0.15, 1.0
# Of s.y and y.H y in a pair of DFP or BFGS.  On 200 random scenes 10 saves 2 to 13 % of iterations
# with multipliers and full memory, 1 to 4 % without, and changes nothing for few pairs; 3 refuses
# so much that seeds are renewed more often, 100 saves half as much.
LARGEST_RATIO = 10.0


class Equations(Protocol):
    """What the loop solves; see ``ancf_equations`` in abi/solver_abi.h."""

    @property
    def capsule(self) -> object:
        """The equations, "ancf_equations"."""

    def residual(self) -> NDArray[np.float64]:
        """Return the scaled residual."""

    def correct(self, s: NDArray[np.float64]) -> None:
        """Add a correction."""


def tolerance_of(
    asked: str | float,
    scale: float,
    *,
    force_scale: float,
    place: float,
    noise: float,
    floor: float,
    share: float,
    work: float,
    sure: bool,
) -> Tolerance:
    """Translate what a person asks for into bounds.

    Parameters
    ----------
    asked : "default", "paper" or float
        ``"paper"``: max|r| < 1e-6 N (N m on slopes) and max|phi| < 1e-6 m, unscaled.  A number: the
        error of the accelerations that a step may leave [m/s2].
    scale : float
        beta dt^2 [s2].
    force_scale : float
        Size of the terms that cancel in the residual [N]; rounding puts a floor under ``"paper"``.
    place : float
        Rounding of a position [m].
    noise, floor, share, work, sure
        As in `Tolerance`; ``share`` and ``work`` apply to ``"default"``.
    """
    if asked == "paper":
        force = scale * max(1e-6, 4.0 * EPSILON * force_scale)
        return Tolerance(False, force, 1e-6, 0.0, noise)
    if isinstance(asked, str) and asked != "default":
        raise InputError(
            "{tolerance} must be 'default', 'paper' or a number in m/s2, got {asked!r}",
            tolerance=Parameter("tolerance"),
            asked=asked,
        )
    bound = math.inf
    if asked != "default":
        bound, share, work = scale * check_positive("tolerance", asked, "m/s2"), math.inf, math.inf
    return Tolerance(True, 0.0, 4.0 * place, bound, noise, share, work, floor, sure)


@dataclass(frozen=True)
class Costs:
    """Modelled cost of an iteration, of a new seed, and of turning the seed in an iteration.

    All are in the same arbitrary unit.

    Counts, not clocks, so that runs repeat bit for bit.
    """

    iteration: float
    seed: float
    rotation: float = 0.0

    @classmethod
    def of(
        cls, residual: int, tangent: int, seed: Seed | Fill, frame: Frame | None = None
    ) -> Costs:
        """Weigh operation counts as the parts were measured to take them, within a factor of two.

        Kernels run in SIMD lanes.  Of a factor every entry has its price, where they are few for
        each column, and every operation a small one, where they come in blocks.
        """
        return cls(
            0.1 * residual + 0.5 * seed.solve_flops,
            0.1 * tangent + ENTRY * seed.nnz + 0.12 * seed.factor_flops,
            0.0 if frame is None else 0.5 * frame.operations,
        )


def make_inverse(
    method: Method,
    seed: Seed,
    weights: NDArray[np.float64] | None,
    norm: NDArray[np.float64],
    smallest_y: float,
) -> OwnInverse:
    """Build the compiled inverse of a method on a seed.

    Parameters
    ----------
    method : Method
        The person's choice.
    seed : SparseSeed or IncompleteSeed
        Factor of the iteration matrix.
    weights : (n,) float or None
        Inner product for Broyden's update: the diagonal of the mass matrix, zero on multipliers.
        None is the plain one of the paper, whose pairs depend on the units.
    norm : (n,) float
        Weights of the squares of a step, in the norm by which pairs are accepted; those of a
        difference of residuals are divided by it.
    smallest_y : float
        Differences of residuals below this are rounding, and their pairs are skipped.
    """
    inverse: OwnInverse
    if isinstance(method, QuasiNewton) and method.is_dense:
        if seed.n > DENSE_LIMIT:
            raise InputError(
                f"memory='full' would keep a dense inverse of {seed.n} x {seed.n} numbers, "
                f"{8 * seed.n**2 / 1e9:.3g} GB: use QuasiNewton({method.update!r}, memory=10)"
            )
        inverse = compiled_module("dense").Dense(seed, method.update, weights)
    elif isinstance(method, QuasiNewton):
        inverse = compiled_module("limited").Limited(seed, method.update, method.pairs, weights)
    else:
        inverse = compiled_module("limited").Limited(seed, "broyden", 0)
    inverse.set_guard(norm, smallest_y, LARGEST_RATIO)
    return inverse


def make_iteration(
    equations: Equations,
    seed: Seed,
    inverse: OwnInverse,
    method: Method,
    tolerance: Tolerance,
    costs: Costs,
    frame: Frame | None = None,
    reach: NDArray[np.float64] | float = 1e-6,
    sparing: bool = False,
) -> NonlinearLoop:
    """Build the compiled loop; a finite-difference seed is taken at the present iterate.

    Parameters
    ----------
    equations, seed, inverse
        What is solved, and with what.
    method, tolerance, costs
        How it is solved.
    frame : compiled object with a ``capsule`` "ancf_frame", optional
        Rotations of the body, needed unless `Solver.frame` is fixed.
    reach : float or (n,) float, optional
        By how much unknowns are moved for a finite-difference seed, see `finite_difference`.
    sparing : bool, optional
        Whether pairs are taken only where corrections by sweeps contract slowly.

    Raises
    ------
    InputError
        If a finite-difference seed cannot be inverted.
    """
    seed_frame, full = method.frame, method.is_dense
    carry = full or (isinstance(method, QuasiNewton) and method.carry)
    learns = isinstance(method, QuasiNewton)
    davidon = isinstance(method, QuasiNewton) and method.update == "davidon"
    loop: NonlinearLoop = compiled_module("iteration").Iteration(
        equations,
        seed,
        turned(inverse, method, frame),
        None if seed_frame == "fixed" else frame,
        rotating=seed_frame == "rotating",
        compares_frames=seed_frame == "auto",
        newton=isinstance(method, Newton),
        learns=learns,
        sparing=sparing,
        carry=carry,
        polishes=not davidon,
        economical=not full and not isinstance(method, Newton),
        rounds=not full,
        by_correction=tolerance.by_correction,
        max_iterations=method.max_iterations,
        force_tolerance=tolerance.force,
        constraint_tolerance=tolerance.constraint,
        correction_tolerance=tolerance.correction,
        noise=tolerance.noise,
        cost_iteration=costs.iteration,
        cost_rotation=costs.rotation,
        cost_seed=costs.seed,
        patience=WAITING_WITH_PAIRS if learns and not sparing else WAITING,
        sure=tolerance.sure,
        share=tolerance.share,
        work=tolerance.work,
        floor=tolerance.floor,
    )
    if method.by_differences:
        try:
            matrix = finite_difference(equations, reach, seed.n - seed.n_positive)
            cast("DenseInverse", inverse).matrix = np.linalg.inv(matrix).astype(np.float64)
        except np.linalg.LinAlgError:
            raise InputError(
                "the matrix from finite differences is singular: leave seed='tangent', which is "
                "exact, or take a smaller dt"
            ) from None
        loop.mark_seeded()
    return loop


def turned(inverse: Inverse, method: Method, frame: Frame | None) -> Inverse:
    """Return an inverse as the loop of a method takes it: in a frame, if its seeds may turn."""
    if method.frame == "fixed":
        return inverse
    turning: Inverse = compiled_module("corotated").Corotated(inverse, frame)
    return turning


def finite_difference(
    equations: Equations, reach: NDArray[np.float64] | float = 1e-6, n_linear: int = 0
) -> NDArray[np.float64]:
    """Return the iteration matrix (n, n) by central differences of the residual.

    Parameters
    ----------
    equations : Equations
        What is solved.
    reach : float or (n,) float, optional
        By how much each unknown is moved; without it all are taken to be of size one.
    n_linear : int, optional
        Number of unknowns, the last ones, on which the residual depends linearly: multipliers.
        They are moved by the largest change of a force that any other makes, beside which theirs
        is no rounding.
    """
    n = len(equations.residual())
    matrix = np.empty((n, n))
    steps = np.broadcast_to(reach, n).copy()
    for j in range(n):
        s = np.zeros(n)
        if j == n - n_linear:
            steps[j:] = np.max(np.abs(matrix[:j, :j]) * steps[:j])
        step = steps[j]
        s[j] = step
        equations.correct(s)
        ahead = equations.residual()
        equations.correct(-2.0 * s)
        matrix[:, j] = (ahead - equations.residual()) / (2.0 * step)
        equations.correct(s)
    return matrix


def describe(method: Method) -> str:
    """Name a method in a few words."""
    if isinstance(method, QuasiNewton):
        memory = "full memory" if method.memory == "full" else f"{method.memory} pairs"
        return f"quasi-Newton ({method.update}, {memory})"
    return "modified Newton" if isinstance(method, ModifiedNewton) else "Newton"
