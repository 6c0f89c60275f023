"""No step is accepted unconverged: accepted states are put back into the equations."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear.methods import UPDATES
from ancfsparse.problems import pendulum
from tests.matrices import full

SOLVERS = {
    "newton": ancf.Newton(),
    "modified newton": ancf.ModifiedNewton(),
    **{u: ancf.QuasiNewton(u) for u in UPDATES},
    **{f"{u}, 10 pairs": ancf.QuasiNewton(u, 10) for u in UPDATES},
}


def residuals(run):
    """Unscaled residual on the free coordinates, and constraints, at all states but the first."""
    system = run.system
    amplitudes = system.loads.amplitudes(run.t)
    pairs = [
        system.assembly.residual(q, v, a, lam, system.dead_load, now)
        for q, v, a, lam, now in zip(run.q, run.v, run.a, run.lam, amplitudes, strict=True)
    ]
    r = np.array([pair[0] for pair in pairs])[1:, : system.n_free]
    return r, np.array([pair[1] for pair in pairs])[1:]


def worst_acceleration_error(run, dt):
    """What one more Newton correction would change in the accelerations, worst step [m/s2].

    Weighed by mass, as slopes and positions can be added up.
    """
    system, scale = run.system, 0.25 * dt**2
    weights = system.mass_diagonal / system.mass
    r, phi = residuals(run)
    size = np.linalg.norm(r, axis=1)
    worst = 0.0
    for k in np.argsort(size)[-50:]:  # the error follows the residual within a small factor
        values = system.assembly.matrix(1.0, scale, run.q[k + 1], run.lam[k + 1], np.zeros(0))
        correction = np.linalg.solve(full(system, values), np.concatenate([scale * r[k], phi[k]]))
        worst = max(worst, np.sqrt(weights @ (correction[: system.n_free] / scale) ** 2))
    return worst


@pytest.mark.parametrize("as_constraint", [False, True])
@pytest.mark.parametrize("name", SOLVERS)
def test_the_papers_tolerance_is_kept(name, as_constraint):
    scene, _ = pendulum("thin", as_constraint=as_constraint)
    run = ancf.simulate(scene, 0.25, 5e-4, solver=SOLVERS[name], tolerance="paper")
    r, phi = residuals(run)
    assert np.abs(r).max() < 1e-6
    assert np.abs(phi).max(initial=0.0) < 1e-6


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5])
@pytest.mark.parametrize("name", SOLVERS)
def test_a_number_bounds_the_error_of_the_accelerations(name, tolerance):
    # The contraction that turns a correction into an error is that of steps before: an estimate.
    scene, _ = pendulum("thin")
    dt = 2.5e-4
    run = ancf.simulate(scene, 0.5, dt, solver=SOLVERS[name], tolerance=tolerance)
    assert worst_acceleration_error(run, dt) <= 10 * tolerance


@pytest.mark.parametrize("dt", [2.5e-4, 1.25e-4, 6.25e-5])
@pytest.mark.parametrize("tolerance", ["default", 1e-5, 1e-9])
@pytest.mark.parametrize("update", UPDATES)
def test_no_step_is_far_out_of_balance(update, tolerance, dt):
    # An inverse that is singular by accident makes any correction small: that is no convergence.
    scene, _ = pendulum("thin")
    run = ancf.simulate(scene, 0.5, dt, solver=ancf.QuasiNewton(update), tolerance=tolerance)
    bound = {"default": 1e-3}.get(tolerance, tolerance)
    noise = np.finfo(float).eps * 2.0 / (0.25 * dt**2)  # rounding of 2 m, as an acceleration
    assert worst_acceleration_error(run, dt) <= 100 * max(bound, 10 * noise)
