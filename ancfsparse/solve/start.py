"""Consistent start of a motion: accelerations and multipliers that balance the initial state."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System

Vector = NDArray[np.float64]

# Share of the smallest phi_q M^-1 phi_q^T by which the constraint block is made definite.
REGULARIZATION = 1e-10


def regularize(system: System, scale: float) -> None:
    """Give the constraint block its small negative diagonal, so that L D L^T always exists.

    Parameters
    ----------
    system : System
        Its assembly is told the value.
    scale : float
        Factor of the stiffness in the matrix, beta dt^2 [s2].
    """
    if not system.n_multipliers:
        return
    lam = np.zeros(system.n_multipliers)
    amplitudes = system.loads.amplitudes(np.zeros(1))[0]
    values = system.assembly.matrix(1.0, scale, system.q0, lam, amplitudes)
    diagonal = values[system.pattern.indptr[: system.n_free]]
    phi_q = system.constraints.jacobian(system.q0)[:, : system.n_free]
    system.assembly.set_regularization(REGULARIZATION * np.min(phi_q.power(2) @ (1.0 / diagonal)))


def check_constraints(system: System) -> None:
    """Refuse a start that violates the constraints or their rates.

    Raises
    ------
    InputError
        With the worst equation and by how much.
    """
    if not system.n_multipliers:
        return
    _, phi = residual(system, np.zeros(system.n_all), np.zeros(system.n_multipliers))
    rate = system.constraints.jacobian(system.q0) @ system.v0
    for values, unit, what in ((phi, "m", "positions"), (rate, "m/s", "velocities")):
        worst = int(np.argmax(np.abs(values)))
        size = 1e-9 * max(1.0, float(np.max(np.abs(system.q0))), float(np.max(np.abs(system.v0))))
        if abs(values[worst]) > size:
            raise InputError(
                f"the initial {what} break the {system.constraints.labels[worst]} by "
                f"{values[worst]:.3g} {unit}: move the start or the joint so that they agree"
            )


def initial_acceleration(system: System, seed: SparseSeed) -> tuple[Vector, Vector]:
    """Solve ``M a + phi_q^T lam = f - Q``, ``phi_q a = -(phi_q v)_q v`` at the initial state.

    Parameters
    ----------
    system : System
        At its initial state ``q0``, ``v0``.
    seed : SparseSeed
        On the pattern of the system; it is left with the factor of the mass matrix.

    Returns
    -------
    a : (n_all,) float
        Accelerations [m/s2, 1/s2], zero at fixed coordinates.
    lam : (m,) float
        Multipliers [N].
    """
    n, m = system.n_free, system.n_multipliers
    a, lam = np.zeros(system.n_all), np.zeros(m)
    zero = system.loads.amplitudes(np.zeros(1))[0]
    values = system.assembly.matrix(1.0, 0.0, system.q0, lam, zero)
    seed.factor(values)
    phi_q = system.constraints.jacobian(system.q0)
    curvature = system.constraints.curvature(system.v0)
    for _ in range(3):  # refinement removes the regularization of the constraint block
        r, _ = residual(system, a, lam)
        correction = seed.solve(np.concatenate([r[:n], phi_q @ a + curvature]))
        a[:n] -= correction[:n]
        lam -= correction[n:]
    return a, lam


def residual(system: System, a: Vector, lam: Vector) -> tuple[Vector, Vector]:
    """Return residual and constraints of the initial state for given accelerations."""
    amplitudes = system.loads.amplitudes(np.zeros(1))[0]
    r, phi = system.assembly.residual(system.q0, a, lam, system.dead_load, amplitudes)
    return np.asarray(r), np.asarray(phi)
