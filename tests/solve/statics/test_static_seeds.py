"""Equilibria on incomplete seeds: those of complete ones, at counts that hardly grow."""

import contextlib
import warnings

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import lattice
from ancfsparse.seeds import DeflatedSeed
from ancfsparse.solve.preparation import choose_factorization, memory_estimate
from ancfsparse.solve.preparation.deflation_space import DeflationModes, divide_into_boxes
from ancfsparse.solve.statics import static_equilibrium as solve_static
from ancfsparse.system import System
from tests.beams import build_beam

STIFF = {"soft": (1e8, 1000.0), "steel": (2.1e11, 7800.0)}
INCOMPLETE = "an incomplete factorization with deflation"


def hung(n, stiff="steel", sideways=0.1, standing=False):
    """A cubic lattice, clamped at its top or bottom, with a share of its weight sideways."""
    modulus, density = STIFF[stiff]
    grid = lattice(n).mesh
    scene = ancf.Scene(gravity=(0.0, 0.0, -9.81))
    mesh = scene.add_mesh(
        grid.positions, grid.edges, "thin", ancf.Rectangle(0.01, 0.01),
        ancf.Material(modulus, density),
    )  # fmt: skip
    height = mesh.positions[:, 2]
    held = height.min() if standing else height.max()
    for node in np.flatnonzero(np.abs(height - held) < 1e-9):
        scene.clamp(mesh.node(int(node)))
    weight = mesh.stiffnesses()["mass_per_length"] * 9.81
    scene.distributed_force(mesh, (sideways * weight, 0.0, 0.0))
    return scene


def both(make):
    return [ancf.solve_static(make(), factorization=kind) for kind in ("complete", "incomplete")]


@pytest.mark.parametrize("sideways", [0.0, 0.1, 1.0])
@pytest.mark.parametrize("stiff", STIFF)
def test_lattices_rest_where_they_do_on_exact_seeds(stiff, sideways):
    exact, incomplete = both(lambda: hung(5, stiff, sideways))
    moved = np.abs(exact.q - exact.system.q0).max()
    assert np.abs(exact.q - incomplete.q).max() <= 1e-9 * moved
    assert INCOMPLETE in incomplete.stats.solver
    assert INCOMPLETE not in exact.stats.solver
    assert incomplete.stable
    assert incomplete.stats.sweeps > incomplete.stats.products > 0
    assert exact.stats.sweeps == exact.stats.products == 0


@pytest.mark.parametrize("stiff", STIFF)
def test_sweeps_grow_less_than_the_side(stiff):
    sweeps = []
    for n in (5, 10):
        stats = ancf.solve_static(hung(n, stiff), factorization="incomplete").stats
        assert stats.factorizations <= 12
        assert stats.steps == 1
        sweeps.append(stats.sweeps / stats.solves)
    assert sweeps[1] < 1.9 * sweeps[0]
    assert sweeps[1] < 50


def test_constraints_are_held_on_them_too():
    def scene():
        made = hung(4)
        mesh = made.beams[0]
        made.rod(mesh.node(2), tuple(mesh.positions[2] + (0.0, 0.3, -0.4)))
        made.rod(mesh.node(40), tuple(mesh.positions[40] + (0.2, 0.1, 0.5)))
        return made

    exact, incomplete = both(scene)
    assert len(exact.lam) > 0
    assert np.abs(exact.q - incomplete.q).max() <= 1e-9 * np.abs(exact.q - exact.system.q0).max()
    np.testing.assert_allclose(incomplete.lam, exact.lam, rtol=1e-6)


def test_planar_meshes_and_beams_work():
    def sheet():
        grid = np.stack(np.meshgrid(np.arange(6.0), np.arange(6.0), indexing="ij"), axis=-1)
        number = np.arange(36).reshape(6, 6)
        pairs = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
        edges = np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b in pairs])
        scene = ancf.Scene(gravity=(0.0, -9.81))
        section, material = ancf.Circle(0.1), ancf.Material(1e9, 1000.0)
        mesh = scene.add_mesh(grid.reshape(-1, 2), edges, "thin", section, material)
        for node in number[0]:
            scene.clamp(mesh.node(int(node)))
        return scene

    def cantilever():
        scene, _ = build_beam(
            "l2t2", (0, 0), (4, 0), 40, ancf.Circle(0.02), ancf.Material(1e8, 1000.0), "clamp"
        )
        return scene

    for make in (sheet, cantilever):
        exact, incomplete = both(make)
        moved = np.abs(exact.q - exact.system.q0).max()
        assert np.abs(exact.q - incomplete.q).max() <= 1e-9 * moved


@pytest.mark.parametrize("modulus", [3e8, 1e8, 3e7])
def test_beyond_buckling_straight_columns_are_not_called_stable(modulus):
    STIFF["column"] = (modulus, 1000.0)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ancf.UnstableEquilibriumWarning)
        exact, incomplete = both(lambda: hung(4, "column", 0.0, standing=True))
    assert exact.stable == (modulus == 3e8)
    apart = np.abs(exact.q - incomplete.q).max()
    if exact.stable:
        assert incomplete.stable
        assert apart < 1e-12
    else:  # either it was found unstable too, or one beside it that is stable
        assert not incomplete.stable or apart > 0.1


def test_what_fails_is_solved_on_an_exact_seed_if_it_fits(monkeypatch):
    STIFF["column"] = (3e7, 1000.0)
    scene = hung(3, "column", 0.0, standing=True)
    with pytest.raises(ancf.EquilibriumError):
        ancf.solve_static(scene, factorization="incomplete")
    monkeypatch.setattr(choose_factorization, "MAX_SMALL_COORDINATES", 0)
    monkeypatch.setattr(choose_factorization, "MAX_STATIC_FILL", 1.0)
    with pytest.warns(ancf.UnstableEquilibriumWarning):
        solved = ancf.solve_static(scene)
    assert solved.stats.solver.endswith(
        "then with a complete factorization (which found an equilibrium)"
    )
    assert solved.stats.sweeps > 0


def test_what_fails_and_does_not_fit_exactly_fails(monkeypatch):
    kinds = []

    def failing(equations, *_):
        kinds.append(type(equations.seed).__name__)
        raise ancf.EquilibriumError("a reason", 1.0, 2.0, "somewhere", "N")

    monkeypatch.setattr("ancfsparse.solve.statics.static_equilibrium.find_equilibrium", failing)
    monkeypatch.setattr(choose_factorization, "MAX_STATIC_FILL", 1.0)
    with pytest.raises(ancf.EquilibriumError, match="a reason"):
        ancf.solve_static(hung(4))
    assert kinds == ["DeflatedSeed", "SparseSeed"]
    vectors = memory_estimate.estimate_memory(hung(4), 1, 0, False, ancf.Newton()).vectors
    monkeypatch.setattr(memory_estimate, "available_memory", lambda: vectors + 1e4)
    monkeypatch.setattr(memory_estimate, "MIN_CHECKED", 0.0)
    monkeypatch.setattr(solve_static, "within_memory", lambda _: contextlib.nullcontext())
    monkeypatch.setattr(DeflatedSeed, "nbytes", 0.0)
    with pytest.raises(ancf.EquilibriumError, match="a reason"):
        ancf.solve_static(hung(4))
    assert kinds[2:] == ["DeflatedSeed"]


def test_the_choice_is_by_fill(monkeypatch):
    assert INCOMPLETE not in ancf.solve_static(hung(5)).stats.solver
    monkeypatch.setattr(choose_factorization, "MAX_STATIC_FILL", 3.0)
    assert INCOMPLETE in ancf.solve_static(hung(5)).stats.solver
    assert INCOMPLETE not in ancf.solve_static(hung(5), factorization="complete").stats.solver


def test_what_does_not_fit_exactly_is_solved(monkeypatch):
    scene = hung(8)
    monkeypatch.setattr(choose_factorization, "MAX_STATIC_FILL", 3.0)
    needed = memory_estimate.estimate_memory(
        scene, 1, 0, False, ancf.Newton(), matrices=8, incomplete=True,
        incomplete_entry=memory_estimate.DEFLATED_ENTRY_BYTES,
    )  # fmt: skip
    monkeypatch.setattr(memory_estimate, "available_memory", lambda: 1.05 * needed.total)
    assert needed.complete > needed.factor
    assert INCOMPLETE in ancf.solve_static(scene).stats.solver


def test_other_words_are_refused():
    with pytest.raises(ancf.InputError, match=r"unknown factorization .inexact."):
        ancf.solve_static(hung(2), factorization="inexact")


def test_coarse_modes_are_rigid_where_they_turn():
    system = System(hung(4))
    modes = DeflationModes(system)
    q = system.q0 + 0.01 * np.random.default_rng(0).standard_normal(system.n_all)
    matrix = modes.at(q)
    # A turn of everything about the x axis, and sliding of everything along it, are sums of modes.
    turn = np.zeros(system.n_all)
    for body, table in zip(system.scene.beams, system.places, strict=True):
        assert body.n_nodes == 64
        for first in (0, 3):
            turn[table[:, first + 1]] = -q[table[:, first + 2]]
            turn[table[:, first + 2]] = q[table[:, first + 1]]
    turn = turn[: system.n_free]
    best = np.linalg.lstsq(matrix.toarray(), turn, rcond=None)[0]
    np.testing.assert_allclose(matrix @ best, turn, atol=1e-10)


def test_boxes_are_of_like_size():
    places = np.random.default_rng(1).random((1000, 3)) * (1.0, 5.0, 0.1)
    counts = np.bincount(divide_into_boxes(places))
    assert counts.max() <= 64
    assert counts.min() >= 30
    assert counts.sum() == 1000
