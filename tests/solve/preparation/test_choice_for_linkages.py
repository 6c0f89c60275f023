"""What ``solver="auto"`` takes for linkages of rigid bodies, by counts."""

import pytest

import ancfsparse as ancf
from ancfsparse.problems import andrews, bricard, four_bar, n_four_bar, slider_crank


@pytest.mark.parametrize(
    ("make", "dt"),
    [
        (four_bar, 2e-3),
        (slider_crank, 2e-3),
        (andrews, 2e-5),
        (lambda: n_four_bar(6), 2e-3),
    ],
)
def test_small_ones_keep_a_dense_inverse(make, dt):
    scene = make().scene
    auto = ancf.simulate(scene, 300 * dt, dt)
    assert "davidon, full memory" in auto.stats.solver
    assert auto.stats.factorizations <= 5
    sparse = ancf.simulate(scene, 300 * dt, dt, solver=ancf.ModifiedNewton())
    assert sparse.stats.factorizations > 40
    assert auto.stats.iterations < 1.3 * sparse.stats.iterations


@pytest.mark.filterwarnings("ignore::ancfsparse.RedundantConstraintsWarning")
@pytest.mark.parametrize("dt", [4e-3, 2e-3, 1e-3])
def test_redundant_constraints_keep_a_dense_inverse_too(dt):
    """It takes more corrections than a sparse factor, each of which costs less: equal times."""
    scene = bricard().scene
    auto = ancf.simulate(scene, 300 * dt, dt)
    assert "davidon, full memory" in auto.stats.solver
    assert auto.stats.factorizations <= 5
    sparse = ancf.simulate(scene, 300 * dt, dt, solver=ancf.ModifiedNewton())
    assert sparse.stats.factorizations > 3 * auto.stats.factorizations
    assert auto.stats.iterations < 2.0 * sparse.stats.iterations


def test_long_ones_keep_sparse_seeds():
    run = ancf.simulate(n_four_bar(16).scene, 0.02, 1e-3)
    assert "modified Newton with a sparse factorization" in run.stats.solver
