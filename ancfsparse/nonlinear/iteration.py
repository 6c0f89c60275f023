"""Configuration of the compiled nonlinear loop: tolerances, inverse, costs by operation counts."""

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

if TYPE_CHECKING:
    from ancfsparse.abi.nodal_frames import Frame
    from ancfsparse.nonlinear.loop_protocols import DenseInverse, Inverse, NonlinearLoop, OwnInverse
    from ancfsparse.seeds import Fill, Seed

EPSILON = float(np.finfo(float).eps)
MAX_DENSE_UNKNOWNS = 4000
# Weights of operations, from measured times and right within a factor of two.
LANE_COST = 0.1  # of an operation of a kernel, as kernels run in SIMD lanes
SWEEP_COST = 0.5  # of an operation of a solution or a rotation
FACTOR_COST = 0.12  # of an operation of a factorization, which dominates in dense blocks
# Iterations and factorizations, at the ratio of their measured times (2.5 for cables to 15 for
# nets), were added up over 100 random scenes of the soak and 21 pendulums, chains and nets, for
# modified Newton and pairs of Davidon, DFP and BFGS.  Relative to the best weight of each scene the
# mean is 1.01 to 1.05 for all weights from 4 to 13, 1.02 to 1.06 for 20, 1.06 to 1.09 for 40.
ENTRY_COST = 9.0  # of an entry of a new factor
# In the sums of `ENTRY_COST` modified Newton takes 1.01 to 1.04 of the best for all values from 0
# to 0.5, and 1.05 to 1.08 for 1.  Quasi-Newton takes 1.02 to 1.03 for 0.25 and 1.06 to 1.11 for 1,
# the only value for which the paper's pendulum renews its seed in at most 4 % of the steps.
RENEWAL_EXCESS = 0.15  # iterations of a step above the mean since the last seed, before renewal
RENEWAL_EXCESS_WITH_PAIRS = 1.0  # the same for quasi-Newton
# On 200 random scenes 10 saves 2 to 13 % of the iterations with multipliers and full memory, 1 to
# 4 % without, and does not change results with few pairs; with 3 seeds are renewed more often, and
# 100 saves half as much.
MAX_PAIR_RATIO = 10.0  # of s.y and y.H y in a pair of DFP or BFGS


class Equations(Protocol):
    """Equations of a step; see ``ancf_equations`` in abi/solver_abi.h."""

    @property
    def capsule(self) -> object:
        """Structure "ancf_equations"."""

    def residual(self) -> NDArray[np.float64]:
        """Return the scaled residual."""

    def correct(self, s: NDArray[np.float64]) -> None:
        """Add a correction."""


def make_tolerance(
    tolerance: str | float,
    scale: float,
    *,
    force_scale: float,
    rounding: float,
    noise: float,
    floor: float,
    share: float,
    work: float,
    sure: bool,
) -> Tolerance:
    """Return the convergence criterion for a tolerance given by the user.

    Parameters
    ----------
    tolerance : "default", "paper" or float
        ``"paper"``: max|r| < 1e-6 N (N m on slopes) and max|phi| < 1e-6 m, unscaled.  A number: the
        largest error of the accelerations after a step [m/s2].
    scale : float
        beta dt^2 [s2].
    force_scale : float
        Size of the terms that cancel in the residual [N]; rounding is a lower limit of ``"paper"``.
    rounding : float
        Rounding error of a position [m].
    noise, floor, share, work, sure
        As in `Tolerance`; ``share`` and ``work`` apply to ``"default"``.
    """
    if tolerance == "paper":
        force = scale * max(1e-6, 4.0 * EPSILON * force_scale)
        return Tolerance(False, force, 1e-6, 0.0, noise)
    if isinstance(tolerance, str) and tolerance != "default":
        raise InputError(
            "{tolerance} must be 'default', 'paper' or a number in m/s2, got {value!r}",
            tolerance=Parameter("tolerance"),
            value=tolerance,
        )
    bound = math.inf
    if tolerance != "default":
        bound = scale * check_positive("tolerance", tolerance, "m/s2")
        share, work = math.inf, math.inf
    return Tolerance(True, 0.0, 4.0 * rounding, bound, noise, share, work, floor, sure)


@dataclass(frozen=True)
class Costs:
    """Modelled costs of the parts of a step, all in one arbitrary unit.

    They are from counts instead of clocks, so that runs repeat bit for bit.

    Attributes
    ----------
    residual, solve, factor : float
        Cost of a residual, of a solution, and of a new factor with its matrix.
    rotation : float
        Cost of the rotation of the seed in an iteration.
    """

    residual: float
    solve: float
    factor: float
    rotation: float = 0.0

    @classmethod
    def from_counts(
        cls, residual: int, tangent: int, seed: Seed | Fill, frame: Frame | None = None
    ) -> Costs:
        """Return the costs of the operations of two kernels and of a seed."""
        return cls(
            LANE_COST * residual,
            SWEEP_COST * seed.solve_flops,
            LANE_COST * tangent + ENTRY_COST * seed.nnz + FACTOR_COST * seed.factor_flops,
            0.0 if frame is None else SWEEP_COST * frame.operations,
        )

    @property
    def iteration(self) -> float:
        """Cost of an iteration, without rotation."""
        return self.residual + self.solve

    def total(self, residuals: float, solves: float, factors: float) -> float:
        """Return the cost of a number of each."""
        return self.residual * residuals + self.solve * solves + self.factor * factors


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
        The method.
    seed : SparseSeed or IncompleteSeed
        Factor of the iteration matrix.
    weights : (n,) float or None
        Inner product for Broyden's update: the diagonal of the mass matrix, zero on multipliers.
        None is the Euclidean one of the paper, which makes pairs depend on units.
    norm : (n,) float
        Weights of the squares of a step, in the norm by which pairs are accepted; weights of a
        difference of residuals are their inverses.
    smallest_y : float
        Differences of residuals below this are rounding errors, and their pairs are skipped.
    """
    inverse: OwnInverse
    if isinstance(method, QuasiNewton) and method.is_dense:
        if seed.n > MAX_DENSE_UNKNOWNS:
            raise InputError(
                f"memory='full' would keep a dense inverse of {seed.n} x {seed.n} numbers, "
                f"{8 * seed.n**2 / 1e9:.3g} GB: use QuasiNewton({method.update!r}, memory=10)"
            )
        inverse = compiled_module("dense").Dense(seed, method.update, weights)
    elif isinstance(method, QuasiNewton):
        inverse = compiled_module("limited").Limited(seed, method.update, method.pairs, weights)
    else:
        inverse = compiled_module("limited").Limited(seed, "broyden", 0)
    if isinstance(method, QuasiNewton):
        inverse.set_guard(norm, smallest_y, MAX_PAIR_RATIO)
    return inverse


def make_iteration(
    equations: Equations,
    seed: Seed,
    inverse: OwnInverse,
    method: Method,
    tolerance: Tolerance,
    costs: Costs,
    frame: Frame | None = None,
    steps: NDArray[np.float64] | float = 1e-6,
    sparing: bool = False,
) -> NonlinearLoop:
    """Build the compiled loop; a finite-difference seed is taken at the present iterate.

    Parameters
    ----------
    equations, seed, inverse
        Equations of a step, seed and inverse.
    method, tolerance, costs
        Method, convergence criterion and costs.
    frame : compiled object with a ``capsule`` "ancf_frame", optional
        Rotations of the body, needed unless `Solver.frame` is fixed.
    steps : float or (n,) float, optional
        Steps of the unknowns for a finite-difference seed, see `finite_difference`.
    sparing : bool, optional
        Whether pairs are stored only if corrections by sweeps contract slowly.

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
        rotate_with_frame(inverse, method, frame),
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
        cost_seed=costs.factor,
        patience=RENEWAL_EXCESS_WITH_PAIRS if learns and not sparing else RENEWAL_EXCESS,
        sure=tolerance.sure,
        share=tolerance.share,
        work=tolerance.work,
        floor=tolerance.floor,
    )
    if method.by_differences:
        try:
            matrix, steps = finite_difference(equations, steps, seed.n - seed.n_positive)
            # Scaled to work, so that pivots do not depend on units.
            scale = np.outer(steps, steps)
            cast("DenseInverse", inverse).matrix = np.linalg.inv(matrix * scale) * scale
        except np.linalg.LinAlgError:
            raise InputError(
                "the matrix from finite differences is singular: leave seed='tangent', which is "
                "exact, or take a smaller dt"
            ) from None
        loop.mark_seeded()
    return loop


def rotate_with_frame(inverse: Inverse, method: Method, frame: Frame | None) -> Inverse:
    """Return an inverse that rotates with a frame, if the seeds of the method may rotate."""
    if method.frame == "fixed":
        return inverse
    corotated: Inverse = compiled_module("corotated").Corotated(inverse, frame)
    return corotated


def finite_difference(
    equations: Equations, steps: NDArray[np.float64] | float = 1e-6, n_linear: int = 0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the iteration matrix by central differences of the residual, and the steps of them.

    Parameters
    ----------
    equations : Equations
        Equations of a step.
    steps : float or (n,) float, optional
        Step of each unknown; the default suits unknowns of size one.
    n_linear : int, optional
        Number of unknowns, the last ones, on which the residual depends linearly: multipliers.
        With their steps the constraints do the largest work of the others, so that it exceeds
        rounding errors.

    Returns
    -------
    matrix : (n, n) float
    steps : (n,) float
    """
    n = len(equations.residual())
    matrix = np.empty((n, n))
    steps = np.broadcast_to(steps, n).copy()
    for j in range(n):
        if j == n - n_linear:
            work = np.abs(matrix[:j, :j] * steps[:j] * steps[:j, None]).max()
            changes = np.abs(matrix[j:, :j] * steps[:j]).max(axis=1)
            steps[j:] = work / np.where(changes > 0.0, changes, 1.0)
        s = np.zeros(n)
        s[j] = steps[j]
        equations.correct(s)
        ahead = equations.residual()
        equations.correct(-2.0 * s)
        matrix[:, j] = (ahead - equations.residual()) / (2.0 * steps[j])
        equations.correct(s)
    return matrix, steps


def describe(method: Method) -> str:
    """Return the name of a method."""
    if isinstance(method, QuasiNewton):
        memory = "full memory" if method.memory == "full" else f"{method.memory} pairs"
        return f"quasi-Newton ({method.update}, {memory})"
    return "modified Newton" if isinstance(method, ModifiedNewton) else "Newton"
