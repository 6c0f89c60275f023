"""Damping in the matrix of a step and in that of the start: whole, for every weight."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear import Newton
from ancfsparse.nonlinear.iteration import finite_difference
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.initial_conditions.consistent_state import starting_state
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from tests.matrices import full

FAMILY = [ancf.Newmark(0.0), ancf.Newmark(0.3), ancf.HHT(0.3), ancf.GeneralizedAlpha(0.5)]
DT = 2e-3


def still(damping, force=0.0):
    """A straight clamped beam at rest, whose forces are linear around there."""
    scene = ancf.Scene((0.0, 0.0))
    material = ancf.Material(
        1e7, 1000.0, axial_damping=damping, bending_damping=damping, rayleigh=(2e3 * damping, 0.0)
    )
    rod = scene.add_beam("thin", (0, 0), (1, 0), 3, ancf.Rectangle(0.05, 0.05), material)
    scene.clamp(rod.start)
    scene.point_force(rod.end, (0.0, force))
    return System(scene)


@pytest.mark.parametrize("integrator", [*FAMILY, ancf.EnergyMomentum()], ids=repr)
def test_the_matrix_of_a_step_is_the_derivative_of_its_residual(integrator):
    matrices = []
    for damping in (0.0, 0.02):
        system = still(damping)
        march, *_ = prepare_implicit(system, DT, integrator, Newton(), "default", np.inf)
        exact, _ = finite_difference(march)
        found = full(system, march.matrix())
        assert np.abs(found - exact).max() < 1e-6 * np.abs(exact).max()
        matrices.append(exact)
    assert np.abs(matrices[1] - matrices[0]).max() > 0.5 * np.abs(matrices[1]).max()


@pytest.mark.parametrize("integrator", FAMILY, ids=repr)
def test_a_start_takes_out_what_a_damped_step_cannot_follow(integrator):
    """1 - (1 - S^-1 M)^2 of the acceleration, S from the change of the formulas with a1."""
    system = still(0.02, force=-5.0)
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free, 1)
    start, a = starting_state(system, seed, integrator, DT)
    m, f = integrator.alpha_m, integrator.alpha_f
    # By one unit of a1: b1, and with it positions and velocities at the end of the step.
    b1 = (1.0 - f) / (1.0 - m)
    q1, v1 = DT**2 * integrator.beta * b1, DT * integrator.gamma * b1
    none, q = np.zeros(0), system.q0
    mass, stiffness = (
        full(system, system.assembly.matrix(*factors, q, none, none))
        for factors in ((1.0, 0.0), (0.0, 1.0))
    )
    viscous = full(system, system.assembly.matrix(0.0, 0.0, q, none, none, damping_factor=1.0))
    follows = np.linalg.solve(mass + q1 * stiffness + v1 * viscous, mass)
    n = system.n_free
    once = follows @ a[:n]
    expected = 2.0 * once - follows @ once
    if integrator.shift == 0.0:
        np.testing.assert_allclose(start.b[:n], expected, rtol=0, atol=1e-9 * np.abs(a).max())
    np.testing.assert_allclose(start.a[:n], expected, rtol=0, atol=1e-9 * np.abs(a).max())
