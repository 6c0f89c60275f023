"""How long a step of an explicit integrator may be."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError, Parameter
from ancfsparse.integrators.explicit import Explicit
from ancfsparse.nonlinear import Newton
from ancfsparse.scene import Scene, check_scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.blocks import BlockInverse
from ancfsparse.solve.memory import NOTHING, check_factor, estimate, memory_for
from ancfsparse.solve.rates import start_load
from ancfsparse.system import System
from ancfsparse.words import shown

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = NDArray[np.float64]

# Up to so many coordinates all frequencies together are found sooner than the highest alone.
DENSE = 100
# Arrays of values on the pattern: two whole matrices, each from its triangle, with their indices.
MATRICES = 10
# Relative accuracy of the square of the highest frequency; the limit is half as uncertain.
ACCURACY = 1e-4
# Constraints that an explicit method holds at most: each costs a solution for each evaluation of
# the forces, and all together a small dense matrix.
MOST_HELD = 12

IMPLICIT = Parameter("integrator", "GeneralizedAlpha(0.9)", joint="")
"""What is advised where no explicit method serves."""


def stable_step(scene: Scene, integrator: Explicit) -> float:
    """Return the longest stable step of an explicit integrator at the start of the motion [s].

    ``interval / omega``, with the fastest vibration omega of the scene and what the method can
    follow, 2 for central differences.  Beams that are stretched vibrate faster, so stay below it.

    Parameters
    ----------
    scene : Scene
        Without joints that need multipliers and without damping, but for `DormandPrince`.
    integrator : CentralDifference, RungeKuttaNystrom or DormandPrince
        The method.

    Raises
    ------
    InputError
        If the integrator is not explicit or does not take the scene, or the factor of its masses
        cannot fit in memory.
    """
    check_explicit(integrator)
    check_scene(scene)
    with memory_for(estimate(scene, 1, 0, False, Newton(), matrices=MATRICES)):
        system = System(scene)
        check_free(system, integrator)
        mass = mass_seed(system)
        omega = fastest_vibration(system, mass, system.q0, start_load(system))
    return integrator.tableau.interval / omega


def check_explicit(integrator: object) -> None:
    """Refuse what is not an explicit integrator."""
    if not isinstance(integrator, Explicit):
        from ancfsparse.integrators.names import EXPLICIT_EXAMPLES  # for this message alone

        *others, last = EXPLICIT_EXAMPLES
        raise InputError(
            f"only {', '.join(others)} and {last} have a stable step, got {shown(integrator)}"
        )


def check_free(system: System, integrator: Explicit) -> None:
    """Refuse multipliers and damping where forces must depend on free positions alone.

    Others take damping, and few multipliers.
    """
    if system.prescribed.n_equations:
        raise InputError(
            f"{integrator!r} cannot follow lengths that change with time, nor drives by "
            "multipliers: drive a node by numbering, as_constraint=False, or take an implicit "
            "integrator such as GeneralizedAlpha(0.9)"
        )
    if system.constraints.measures:
        raise InputError(
            "{integrator!r} cannot hold gears and winches: take an implicit integrator such as "
            "{implicit}",
            integrator=integrator,
            implicit=IMPLICIT,
        )
    rigid = [body.name for body in system.scene.bodies if not body.n_elements]
    if rigid:
        raise InputError(
            "{integrator!r} cannot hold {name} rigid, which takes multipliers: take an implicit "
            "integrator such as {implicit}",
            integrator=integrator,
            name=rigid[0],
            implicit=IMPLICIT,
        )
    if integrator.takes_velocities:
        if system.n_multipliers > MOST_HELD:
            raise InputError(
                "{integrator!r} holds at most {most} constraints by multipliers, and this scene "
                "has {n}: make pins, clamps and connections by numbering, as_constraint=False, or "
                "take an implicit integrator such as {implicit}",
                integrator=integrator,
                most=MOST_HELD,
                n=system.n_multipliers,
                implicit=IMPLICIT,
            )
        return
    if system.n_multipliers:
        raise InputError(
            "{integrator!r} cannot hold constraints by multipliers, and the {first} needs them: "
            "make pins, clamps and connections by numbering, as_constraint=False, or take "
            "DormandPrince() or an implicit integrator such as {implicit}",
            integrator=integrator,
            first=system.constraints.labels[0],
            implicit=IMPLICIT,
        )
    if system.damped:
        raise InputError(
            "{integrator!r} takes forces that depend on positions and time, and the damping of "
            "this scene depends on velocities: take DormandPrince() or an implicit integrator such "
            "as {implicit}",
            integrator=integrator,
            implicit=IMPLICIT,
        )


def mass_matrix(system: System) -> sp.csc_array:
    """Return the lower triangle of the mass matrix over the free coordinates."""
    return on_free(system, system.assembly.mass)


def mass_seed(system: System) -> SparseSeed:
    """Factor the mass matrix."""
    mass = mass_matrix(system)
    seed = SparseSeed(mass.indptr, mass.indices, system.n_free)
    check_factor(NOTHING, seed)
    seed.factor(mass.data)
    return seed


def fastest_vibration(
    system: System, seed: SparseSeed | BlockInverse, q: Vector, amplitudes: Vector
) -> float:
    """Return the highest angular frequency of ``K x = omega^2 M x`` at a state [rad/s].

    Or the highest rate of ``C x = omega M x``, if that is more: no vibration, damped or not, has a
    larger eigenvalue than both.  Constraints only slow vibrations down.

    Parameters
    ----------
    system : System
        What moves.
    seed : SparseSeed or BlockInverse
        Inverse of its mass matrix.
    q : (n_all,) float
        Coordinates.
    amplitudes : (n_amplitudes,) float
        Loads that change, because moments stiffen what they turn.
    """
    lam, mass = np.zeros(system.n_multipliers), whole(mass_matrix(system))

    def highest(values: Vector) -> float:
        square = _highest(whole(on_free(system, values)), mass, seed)
        return max(square, np.finfo(float).tiny)

    omega = math.sqrt(highest(system.assembly.matrix(0.0, 1.0, q, lam, amplitudes)))
    if system.damped:
        damping = system.assembly.matrix(0.0, 0.0, q, lam, amplitudes, damping_factor=1.0)
        omega = max(omega, highest(damping))
    return omega


def _highest(matrix: sp.csr_array, mass: sp.csr_array, seed: SparseSeed | BlockInverse) -> float:
    """Return the highest eigenvalue of a symmetric matrix over that of the masses."""
    from scipy.linalg import eigh
    from scipy.sparse.linalg import LinearOperator, eigsh

    n = mass.shape[0]
    if n <= DENSE:
        found = eigh(
            matrix.toarray(), mass.toarray(), eigvals_only=True, subset_by_index=[n - 1, n - 1]
        )
    else:
        found = eigsh(
            matrix,
            k=1,
            M=mass,
            Minv=LinearOperator((n, n), matvec=lambda r: seed.solve(np.ravel(r)), dtype=float),
            which="LA",
            v0=np.random.default_rng(0).standard_normal(n),  # the same in every run
            tol=ACCURACY,
            return_eigenvectors=False,
        )
    return float(found[0])


def on_free(system: System, values: Vector) -> sp.csc_array:
    """Return the lower triangle over the free coordinates, from values on the pattern."""
    import scipy.sparse as sp

    pattern, n = system.pattern, system.n_free
    lower = sp.csc_array((values, pattern.indices, pattern.indptr))
    return lower if lower.shape[0] == n else lower[:n, :n].tocsc()


def whole(lower: sp.csc_array) -> sp.csr_array:
    """Return a symmetric matrix from its lower triangle."""
    import scipy.sparse as sp

    return (lower + sp.tril(lower, -1).T).tocsr()
