"""The first step of Newmark's family from rest, of a linear system, in NumPy.

Nothing of the package's integrators computes here: formulas, start and energy are written again.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import null_space

from ancfsparse.solve.linearization.matrices import free_submatrix, symmetric_from_lower


@dataclass
class Linear:
    """Matrices, and the loads before and after the first step."""

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    loads: tuple

    def filters(self, scheme, dt):
        """Return what the first step keeps of an acceleration, and of its rate."""
        ratio = (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m)
        step = self.mass + ratio * (
            scheme.beta * dt**2 * self.stiffness + scheme.gamma * dt * self.damping
        )
        once, one = np.linalg.solve(step, self.mass), np.eye(len(step))
        return one - (one - once) @ (one - once), once @ once @ once


@dataclass
class Step:
    """Displacement and velocity after a step from rest, and both accelerations around it."""

    q: np.ndarray
    v: np.ndarray
    a: tuple
    b: tuple


def first_step(linear, scheme, dt, filters=None):
    """Make the first step from rest without stress.

    It starts as simulations do, or as in the literature with two filters that keep everything.
    """
    of_a, of_rate = linear.filters(scheme, dt) if filters is None else filters
    beta, gamma, m, f = scheme.beta, scheme.gamma, scheme.alpha_m, scheme.alpha_f
    (before, after), size = linear.loads, len(linear.mass)
    exact = np.linalg.solve(linear.mass, before)
    rate = np.linalg.solve(linear.mass, (after - before) / dt - linear.damping @ exact)
    a0 = of_a @ exact
    b0 = a0 + (m - f) * dt * (of_rate @ rate)
    # Unknowns q, v, a and b after the step; its four equations are the rows.
    one, none = np.eye(size), np.zeros((size, size))
    matrix = np.block([
        [one, none, none, -(dt**2) * beta * one],
        [none, one, none, -dt * gamma * one],
        [linear.stiffness, linear.damping, linear.mass, none],
        [none, none, -(1.0 - f) * one, (1.0 - m) * one],
    ])  # fmt: skip
    right = [dt**2 * (0.5 - beta) * b0, dt * (1.0 - gamma) * b0, after, f * a0 - m * b0]
    # The block of a and b alone would be singular for b -> 0, so all are solved for at once.
    q, v, a1, b1 = np.split(np.linalg.solve(matrix, np.concatenate(right)), 4)
    return Step(q, v, (a0, a1), (b0, b1))


def gain(linear, step):
    """Return the energy after a step from rest above the work of the trapezoidal rule [J]."""
    energy = 0.5 * (step.v @ linear.mass @ step.v + step.q @ linear.stiffness @ step.q)
    return float(energy - 0.5 * step.q @ (linear.loads[0] + linear.loads[1]))


def linearized(system, dt):
    """Linearize a system about its start, at rest and without stress, across its constraints."""
    n, rest = system.n_free, np.zeros(system.n_all)
    amplitudes = system.loads.amplitudes(system.t0 + dt * np.arange(2.0))
    none = np.zeros(system.n_multipliers)

    def force(amplitude):
        residual = system.assembly.residual
        return -residual(system.q0, rest, rest, none, system.dead_load, amplitude)[0][:n]

    def dense(mass, stiffness, damping, lam):
        values = system.assembly.matrix(
            mass, stiffness, system.q0, lam, amplitudes[0], damping_factor=damping, v=rest
        )
        return symmetric_from_lower(free_submatrix(system, values)).toarray()

    mass = dense(1.0, 0.0, 0.0, none)
    gradients, basis, lam = np.zeros((0, n)), np.eye(n), none
    if system.n_multipliers:
        gradients = system.constraints.jacobian(system.q0)[:, :n].toarray()
        basis = null_space(gradients)
        compliance = gradients @ np.linalg.solve(mass, gradients.T)
        lam = np.linalg.lstsq(
            compliance, gradients @ np.linalg.solve(mass, force(amplitudes[0])), rcond=None
        )[0]
    matrices = (mass, dense(0.0, 0.0, 1.0, none), dense(0.0, 1.0, 0.0, lam))
    loads = tuple(basis.T @ force(each) for each in amplitudes)
    return Linear(*(basis.T @ each @ basis for each in matrices), loads)
