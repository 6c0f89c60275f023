"""References: extrapolation is exact where it must be, and two ways to one motion agree."""

import numpy as np
import pytest

from benchmarks.accuracy.models import MODELS, distance
from benchmarks.accuracy.references import (
    converged,
    converged_in_time,
    extrapolate,
    trapezoidal_tip,
)


def test_extrapolation_removes_the_second_and_fourth_power():
    true, a, b = (np.random.default_rng(k).normal(size=(4, 2)) for k in range(3))
    tips = [true + a * h**2 + b * h**4 for h in (0.4, 0.2, 0.1)]
    tip, last = extrapolate(tips)
    np.testing.assert_allclose(tip, true, rtol=0, atol=1e-13)
    once = (4.0 * tips[2] - tips[1]) / 3.0
    assert last == pytest.approx(distance(once, true), rel=1e-9)


@pytest.mark.parametrize("model", ["L2T2", "Thin", "Thin, Biot", "Thick, nodal"])
def test_two_integrators_find_the_same_motion(model):
    reference = converged_in_time(model, 4, 0.2, 2.5e-5)
    assert reference.uncertainty < 1e-9
    assert (
        distance(trapezoidal_tip(model, 4, 0.2, 5e-4), reference.tip) > 1e2 * reference.uncertainty
    )


@pytest.mark.parametrize("model", ["L2T2", "Thin", "Thin, Biot"])
def test_meshes_converge_with_the_order_that_the_extrapolation_takes(model):
    tips = [
        extrapolate([trapezoidal_tip(model, n, 0.4, dt) for dt in (1e-3, 5e-4)])[0]
        for n in (8, 16, 32)
    ]
    order = np.log2(distance(tips[0], tips[1]) / distance(tips[1], tips[2]))
    assert order == pytest.approx(MODELS[model].order, abs=0.6)


def test_uncertainty_covers_the_distance_to_a_finer_reference():
    coarse, fine = (converged("Thin", n, 0.4, 1e-3) for n in (16, 32))
    assert distance(coarse.tip, fine.tip) < coarse.uncertainty
    assert fine.uncertainty < coarse.uncertainty
