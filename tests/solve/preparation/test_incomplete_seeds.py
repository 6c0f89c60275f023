"""Runs on incomplete seeds: the motion of complete ones, at counts independent of the mesh."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import chain, lattice, net
from ancfsparse.seeds import Groups, IncompleteSeed
from ancfsparse.system import System
from ancfsparse.system.coordinates.nodal_vectors import vectors_of

STEEL = {"youngs_modulus": 2.1e11, "density": 7800.0}
SOFT = {"youngs_modulus": 1e8, "density": 1000.0}


def both(make, t_end, dt, **options):
    """The same run on exact and on incomplete seeds."""
    return [
        ancf.simulate(make(), t_end, dt, factorization=kind, **options)
        for kind in ("complete", "incomplete")
    ]


@pytest.mark.parametrize("motion", ["rest", "rough"])
@pytest.mark.parametrize("stiff", [SOFT, STEEL], ids=["soft", "steel"])
def test_lattices_move_as_on_exact_seeds(stiff, motion):
    exact, incomplete = both(lambda: lattice(5, motion, **stiff).scene, 0.02, 5e-4)
    moved = np.abs(exact.q[-1] - exact.q[0]).max()
    # Each step may leave a two-thousandth of what it changes.
    assert np.abs(exact.q - incomplete.q).max() <= 2e-4 * moved
    assert incomplete.stats.sweeps >= incomplete.stats.solves
    assert exact.stats.sweeps == exact.stats.products == 0
    assert "incomplete factorization" in incomplete.stats.solver
    energy = [run.energy.drift for run in (exact, incomplete)]
    assert energy[1] <= max(2.0 * energy[0], 1e-5)


@pytest.mark.parametrize(
    "solver", [ancf.Newton(), ancf.ModifiedNewton(), ancf.QuasiNewton("bfgs", 5)], ids=str
)
def test_all_sparse_methods_work_on_them(solver):
    exact, incomplete = both(lambda: lattice(4, "rough", **STEEL).scene, 5e-3, 5e-4, solver=solver)
    moved = np.abs(exact.q[-1] - exact.q[0]).max()
    assert np.abs(exact.q - incomplete.q).max() <= 2e-4 * moved


def test_on_chains_they_are_exact():
    # Newton's, so that the costs of seeds do not decide when there is a new one.
    newton = ancf.Newton()
    exact, incomplete = both(lambda: chain(200, "rough").scene, 0.02, 5e-4, solver=newton)
    assert incomplete.stats.iterations == exact.stats.iterations
    assert incomplete.stats.products == incomplete.stats.solves  # one round each
    assert np.abs(exact.q - incomplete.q).max() <= 1e-6


def test_thick_nodes_have_four_vectors():
    def scene():
        scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
        section, material = ancf.Rectangle(0.02, 0.02), ancf.Material(1e8, 1000.0, 0.3)
        bars = [
            scene.add_beam("thick", (0, y, 0), (1, y, 0), 4, section, material) for y in (0.0, 0.5)
        ]
        tie = scene.add_beam("thick", (0.5, 0, 0), (0.5, 0.5, 0), 2, section, material)
        scene.connect(bars[0].node(2), tie.start)
        scene.connect(bars[1].node(2), tie.end)
        scene.pin(bars[0].start)
        scene.clamp(bars[1].start)
        return scene

    system = System(scene())
    vectors, node = vectors_of(system.places, system.kinds, system.n_free)
    assert sorted(vectors[vectors >= 0]) == list(range(system.n_free))
    assert max(np.bincount(node)) == 7  # where two beams meet: six slopes and a position
    exact, incomplete = both(scene, 0.02, 1e-3)
    assert np.abs(exact.q - incomplete.q).max() <= 1e-6


def test_set_up_without_a_march_is_linear():
    # Blocks, and so time and memory: 5 below the diagonal and 4/3 on it for each element.
    for n in (6, 12):
        system = System(lattice(n).scene)
        vectors, node = vectors_of(system.places, system.kinds, system.n_free)
        indptr, indices = system.pattern.indptr, system.pattern.indices
        seed = IncompleteSeed(indptr, indices, Groups.from_matrix(indptr, indices, vectors, node))
        assert seed.nnz == system.pattern.n_values - system.n_free
        assert seed.own.nbytes == pytest.approx(seed.nbytes, rel=0.05)
        assert seed.nbytes / (3 * n * n * (n - 1)) < 1300


def test_what_they_cannot_do_is_refused():
    scene = net(3).scene
    for options, words in (
        ({"factorization": "inexact"}, "unknown factorization .inexact."),
        (
            {"factorization": "incomplete", "solver": ancf.QuasiNewton("bfgs")},
            "starts from the full inverse",
        ),
        (
            {"factorization": "incomplete", "accuracy": 1e-3},
            "estimates errors with a complete factor",
        ),
        (
            {"factorization": "complete", "integrator": ancf.CentralDifference()},
            "solves no equations",
        ),
    ):
        with pytest.raises(ancf.InputError, match=words):
            ancf.simulate(scene, 0.01, 1e-3, **options)


def on_rods(n, motion, rods, youngs_modulus, density, **options):
    """A lattice of which some nodes of one side are tied to points below it."""
    scene, mesh = lattice(n, motion, youngs_modulus, density)
    for k in range(rods):  # evenly over x = 0, which no motion moves at first
        scene.rod(mesh.node(n * (k % n) + k // n), (0.1 * k, 0.3, -2.0), **options)
    return scene


@pytest.mark.parametrize(
    ("stiff", "motion", "dt"),
    [(SOFT, "rest", 1e-3), (SOFT, "rough", 1e-3), (STEEL, "rest", 1e-3), (STEEL, "rest", 1e-2)],
    ids=["soft", "soft and rough", "steel", "steel, long steps"],
)
def test_lattices_on_rods_move_as_on_exact_seeds(stiff, motion, dt):
    exact, incomplete = both(lambda: on_rods(5, motion, 7, **stiff), 20 * dt, dt)
    assert incomplete.stats.factorizations > 0
    assert "with an incomplete factorization" in incomplete.stats.solver
    moved = np.abs(exact.q[-1] - exact.q[0]).max()
    assert np.abs(exact.q - incomplete.q).max() <= 2e-4 * moved
    assert np.abs(exact.lam - incomplete.lam).max() <= 2e-3 * np.abs(exact.lam).max()
    drifts = [run.energy.drift for run in (exact, incomplete)]
    assert drifts[1] <= max(1.1 * drifts[0], 1e-5)
    rod = incomplete.system.scene.joints[-1]
    lengths = np.linalg.norm(incomplete.position(rod.nodes[0]) - rod.anchor, axis=1)
    assert np.ptp(lengths) <= 1e-6 * lengths[0]


@pytest.mark.parametrize(
    "options",
    [
        {"integrator": ancf.EnergyMomentum()},
        {"solver": ancf.Newton()},
        {"solver": ancf.QuasiNewton("broyden", 4)},
        {"tolerance": "paper"},
        {"threads": 2},
    ],
    ids=str,
)
def test_equations_go_with_all_that_takes_incomplete_seeds(options):
    exact, incomplete = both(lambda: on_rods(4, "rough", 3, **SOFT), 0.01, 1e-3, **options)
    moved = np.abs(exact.q[-1] - exact.q[0]).max()
    assert np.abs(exact.q - incomplete.q).max() <= 2e-4 * moved


def test_a_winch_pulls_as_on_exact_seeds():
    _, mesh = lattice(4)
    anchor = np.array([0.0, 0.3, -2.0])
    far = float(np.linalg.norm(mesh.node(0).position - anchor))

    course = {
        "length": lambda t: far - 4.0 * t * t,
        "rate": lambda t: -8.0 * t,
        "second_rate": lambda t: -8.0,
    }

    def winch():
        return on_rods(4, "rest", 1, **SOFT, **course)

    exact, incomplete = both(winch, 0.05, 1e-3)
    moved = np.abs(exact.q[-1] - exact.q[0]).max()
    assert np.abs(exact.q - incomplete.q).max() <= 2e-4 * moved
