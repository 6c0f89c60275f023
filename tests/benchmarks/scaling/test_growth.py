"""Counts and memory grow as they must; times are not looked at."""

import numpy as np
import pytest

from ancfsparse import QuasiNewton, simulate
from ancfsparse.problems import chain, lattice, net, octet
from ancfsparse.problems.meshes import LATTICE_MATERIALS
from ancfsparse.solve.preparation.choose_factorization import make_seed
from ancfsparse.solve.preparation.memory_estimate import NO_MEMORY
from ancfsparse.system import System
from benchmarks.common.worker import Worker
from benchmarks.scaling.scaling import PROGRAM
from benchmarks.scaling.scaling_job import Job, counts

CHAINS = (100, 1000, 10_000)
NETS = (10, 20, 40, 80)
MOST_BYTES = 4000  # per element of a chain while it runs, so that 1e6 elements fit 4 GB
BROYDEN = QuasiNewton("broyden", memory=10)


def slopes(x, y):
    """Return the power of x in y between neighbours."""
    return np.diff(np.log(y)) / np.diff(np.log(x))


def test_chains_are_linear_in_pattern_and_factor():
    table = [counts(chain(n).scene) for n in CHAINS]
    for key in "unknowns", "pattern_entries", "factor_entries", "factor_flops":
        np.testing.assert_allclose(slopes(CHAINS, [c[key] for c in table]), 1.0, atol=0.02)
    for c in table:  # next to no fill: L and the pivots are the lower triangle
        assert c["factor_entries"] + c["unknowns"] <= c["pattern_entries"] + 64


def test_entries_of_a_chain_by_hand():
    # Two free nodes of four coordinates and the slope of the pinned one: a lower triangle of 10
    # unknowns in which the first two do not meet the last four.
    c = counts(chain(2).scene)
    assert c["unknowns"] == 10
    assert c["pattern_entries"] == 10 * 11 // 2 - 2 * 4
    assert c["factor_entries"] == c["pattern_entries"] - 10


@pytest.mark.slow
def test_nets_fill_in_like_nested_dissection():
    # Entries of a single net scatter by 3 %, with the ties that METIS breaks: means of three.
    sizes = np.array(NETS)[:, np.newaxis] + [-1, 0, 1]
    rows = [[counts(net(n).scene) for n in row.tolist()] for row in sizes]
    table = [row[1] for row in rows]
    n = np.array(NETS, dtype=float)
    np.testing.assert_array_equal([c["unknowns"] for c in table], 9 * n**2 - 12)
    np.testing.assert_allclose(slopes(n, [c["pattern_entries"] for c in table])[1:], 2.0, atol=0.1)
    # N^2 log N entries and N^3 operations: per node, each doubling of N adds about as many entries.
    entries = [[c["factor_entries"] for c in row] for row in rows]
    entries = np.mean(entries / sizes**2, axis=1)
    assert np.ptp(np.diff(entries)) < 0.25 * np.mean(np.diff(entries))
    operations = [[c["factor_flops"] for c in row] for row in rows]
    operations = np.mean(operations / sizes**3, axis=1)
    assert np.all(np.diff(operations, n=2) < 0.0)
    assert operations[-1] < 1.25 * operations[-2]
    assert table[-1]["ordering"] == "metis"


@pytest.mark.parametrize("motion", ["rest", "rough"])
def test_iterations_on_chains_do_not_grow_with_the_size(motion):
    per_step, seeds = [], []
    for n in CHAINS:
        stats = simulate(
            chain(n, motion).scene, 0.01, 5e-4, solver=QuasiNewton("broyden", 10)
        ).stats
        assert stats.recoveries == 0
        per_step.append(stats.iterations_per_step)
        seeds.append(stats.factorizations)
    assert max(per_step) <= 1.2 * min(per_step)
    assert max(seeds) <= (2 if motion == "rest" else 5)
    assert max(per_step) < (2.0 if motion == "rest" else 4.5)


def test_iterations_on_nets_do_not_grow_with_the_size():
    per_step = []
    for n in (10, 20, 40):
        stats = simulate(net(n).scene, 0.005, 5e-4, solver=BROYDEN).stats
        assert stats.factorizations <= 2
        per_step.append(stats.iterations_per_step)
    assert max(per_step) <= 1.25 * min(per_step)


# Lattices by nodes along a side, octet trusses by cells: of about as many elements each.
CUBES = {"lattice": (lattice, (6, 10, 15)), "octet truss": (octet, (3, 5, 7))}


@pytest.mark.parametrize("cube", CUBES)
def test_incomplete_seeds_are_linear_in_the_mesh(cube):
    make, sizes = CUBES[cube]
    elements, nbytes, factored = [], [], []
    for n in sizes:
        scene, mesh = make(n)
        made, _ = make_seed(System(scene), "incomplete", "auto", 1, NO_MEMORY)
        elements.append(mesh.n_elements)
        nbytes.append(made.own.nbytes)
        factored.append(made.nnz)
    # They have a surface: less and less of them is outside, and nodes there have fewer neighbours.
    most = 0.04 if cube == "lattice" else 0.08
    assert np.all(np.abs(slopes(elements, nbytes) - 1.0) < most)
    assert np.all(np.abs(slopes(elements, factored) - 1.0) < most)
    assert nbytes[-1] / elements[-1] < (1200 if cube == "lattice" else 1900)


def corrections_and_inner(cube, stiff, motion, dt):
    """Corrections, and sweeps and products, per step of the three sizes."""
    make, sizes = CUBES[cube]
    corrections, inner = [], []
    for n in sizes:
        scene = make(n, motion, *LATTICE_MATERIALS[stiff]).scene
        stats = simulate(scene, 10 * dt, dt, factorization="incomplete").stats
        assert stats.recoveries == 0
        corrections.append(stats.iterations_per_step)
        inner.append((stats.sweeps + stats.products) / stats.steps)
    return corrections, inner


@pytest.mark.parametrize("cube", CUBES)
@pytest.mark.parametrize(
    ("stiff", "motion", "dt"),
    [
        ("soft", "rest", 1e-3),
        ("soft", "rough", 1e-3),
        ("soft", "rest", 4e-3),
        ("steel", "rest", 1e-3),
        ("steel", "rest", 4e-3),
    ],
)
def test_work_on_cubes_does_not_grow_with_the_size(cube, stiff, motion, dt):
    corrections, inner = corrections_and_inner(cube, stiff, motion, dt)
    assert max(corrections) <= 1.5 * min(corrections)
    if (cube, stiff, dt) == ("octet truss", "steel", 4e-3):
        # In such a step a wave runs through 80 elements: trusses of 3 to 7 cells are smaller, and
        # conjugate gradients grow with them, but less than in proportion and less and less.
        growth = slopes(CUBES[cube][1], inner)
        assert growth[1] < growth[0] < 0.9
        return
    assert inner[-1] <= 1.35 * inner[0]
    assert inner[-1] <= 1.2 * inner[1]


def test_peak_memory_of_long_chains():
    def peak(size):
        with Worker(PROGRAM) as worker:
            record = worker.run(Job("chain", size, "rest", "auto", 2, 5e-4))
        return (record["peak_bytes"] - record["base_bytes"]) / size

    at_6e4 = peak(60_000)
    assert at_6e4 < MOST_BYTES
    assert at_6e4 < 1.2 * peak(20_000)
