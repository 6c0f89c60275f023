"""Phase errors that integrators declare, against the eigenvalues of their steps."""

from dataclasses import dataclass, replace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.integrators import Explicit
from ancfsparse.integrators.explicit.nystrom_tableaus import FOURTH
from ancfsparse.problems import pendulum

EXPLICIT = [
    ancf.CentralDifference(),
    ancf.RungeKuttaNystrom(4),
    ancf.RungeKuttaNystrom(8),
    ancf.DormandPrince(),
]
Z = np.linspace(0.5, 7.0, 60)


@pytest.mark.parametrize("integrator", EXPLICIT, ids=repr)
def test_a_phase_error_is_that_of_the_eigenvalue_of_a_step(integrator):
    method = integrator.tableau
    inside = Z[method.order * 0.05 < Z]
    exact = [
        np.min(np.abs(np.linalg.eigvals(method.transfer(z)) - np.exp(1j * z))) / z for z in inside
    ]
    expected = np.where(inside < method.interval, exact, 1.0)
    np.testing.assert_allclose(integrator.phase_error(inside), expected, rtol=1e-3)


@pytest.mark.parametrize("integrator", EXPLICIT, ids=repr)
def test_a_phase_error_falls_with_the_order_down_to_rounding(integrator):
    order = integrator.order
    errors = integrator.phase_error(np.array([1e-4, 2e-4]))
    assert errors[1] / errors[0] == pytest.approx(2.0**order, rel=1e-6)


def test_a_phase_error_of_the_trapezoidal_rule():
    z = np.array([0.0, 1e-3, 1.0])
    step = (1.0 + 0.5j * z) / (1.0 - 0.5j * z)
    expected = 1.0 - np.angle(step)[1:] / z[1:]
    errors = ancf.GeneralizedAlpha(0.9).phase_error(z)
    np.testing.assert_allclose(errors[1:], expected, rtol=1e-6)
    assert errors[0] == 0.0


@dataclass(frozen=True)
class ThirdOrder(Explicit):
    """An explicit integrator of an order that no other has."""

    @property
    def tableau(self):
        return replace(FOURTH, order=3)


@pytest.mark.parametrize("accuracy", [1e-3, 1e-6])
def test_an_integrator_of_another_order_runs_to_an_accuracy(accuracy):
    scene, rod = pendulum("thin", 4)
    run, exact = (
        ancf.simulate(scene, 0.2, accuracy=error, integrator=integrator)
        for error, integrator in ((accuracy, ThirdOrder()), (1e-8, "auto"))
    )
    assert run.stats.solver.startswith("ThirdOrder()")
    assert np.abs(run.position(rod.end) - exact.position(rod.end)).max() <= accuracy
