"""Memory is estimated before set-up: entries of factors are counted on a small graph."""

import tracemalloc

import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear import Newton
from ancfsparse.problems import chain, net
from ancfsparse.solve.preparation.fill_in_estimate import count_factor_entries
from ancfsparse.solve.preparation.memory_estimate import estimate_memory
from ancfsparse.solve.statics.static_equilibrium import N_MATRICES
from tests.solve.preparation.factors import cubic_lattice, seed_of


@pytest.mark.parametrize(
    "scene",
    [cubic_lattice(6), cubic_lattice(9), net(12).scene, chain(50)[0], chain(50, element="thin")[0]],
    ids=["lattice 6", "lattice 9", "net", "chain", "thin chain"],
)
def test_fill_is_counted_to_a_tenth(scene):
    seed = seed_of(scene)
    assert count_factor_entries(scene) == pytest.approx(seed.nnz + seed.n, rel=0.1)


def test_the_factor_of_a_lattice_that_may_not_fit_is_not_taken_for_that_of_a_net(monkeypatch):
    scene = cubic_lattice(10)
    seed = seed_of(scene)
    monkeypatch.setattr(
        "ancfsparse.solve.preparation.memory_estimate.available_memory", lambda: 2.0 * seed.nbytes
    )
    estimated = estimate_memory(scene, 1, 0, False, Newton()).factor
    assert seed.nbytes <= estimated <= 2.0 * seed.nbytes


def test_nothing_is_counted_where_it_fits_in_any_case(monkeypatch):
    def never(_):
        raise AssertionError("counted")

    monkeypatch.setattr("ancfsparse.solve.preparation.count_factor_entries", never)
    estimate_memory(cubic_lattice(6), 1, 0, False, Newton())


@pytest.mark.parametrize("kind", ["chain", "net"])
def test_the_estimate_for_statics_is_near_the_truth(kind):
    if kind == "chain":
        scene, rod = chain(20_000)
        scene.pin(rod.end)
    else:
        scene = net(40).scene
    estimated = estimate_memory(scene, 1, 0, False, Newton(), matrices=N_MATRICES).total
    tracemalloc.start()
    ancf.solve_static(scene)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert 0.6 * peak < estimated < 1.7 * peak
