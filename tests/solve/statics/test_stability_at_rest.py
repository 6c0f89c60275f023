"""Which equilibria are stable, by negative pivots: columns, arches, moments in space."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import roll_up
from ancfsparse.solve.statics.newton_and_relaxation import NotFoundError
from tests.solve.statics.equilibria import eigenvalues, unbalanced


def column(share, push=0.0, element="thin", dim=2):
    """A clamped column under a share of Euler's load, pushed aside by a share of that."""
    scene = ancf.Scene((0.0,) * dim)
    end = np.eye(dim)[0]
    section, material = ancf.Circle(0.02), ancf.Material(1e9, 1000.0)
    rod = scene.add_beam(element, (0.0,) * dim, end, 16, section, material)
    scene.clamp(rod.start)
    load = share * math.pi**2 * rod.parameters()["bending_stiffness"] / 4
    scene.point_force(rod.end, -load * end + push * load * np.eye(dim)[1])
    return scene, rod


@pytest.mark.parametrize(("element", "dim"), [("thin", 2), ("thin", 3), ("thick", 2), ("thick", 3)])
@pytest.mark.parametrize("share", [0.5, 0.99, 1.01, 2.0])
def test_a_column_is_stable_up_to_eulers_load(share, element, dim):
    scene, _ = column(share, element=element, dim=dim)
    if share < 1.0:
        equilibrium = ancf.solve_static(scene)
        assert equilibrium.stable
        assert "unstable" not in repr(equilibrium)
    else:
        # In space it can leave in two directions.
        with pytest.warns(
            ancf.UnstableEquilibriumWarning, match="beyond its buckling load"
        ) as caught:
            equilibrium = ancf.solve_static(scene)
        assert caught[0].message.negative == equilibrium.stats.negative_pivots == dim - 1
        assert not equilibrium.stable
        assert f"unstable ({dim - 1} negative pivots)" in repr(equilibrium)
        assert caught[0].filename == __file__
    negative = np.count_nonzero(eigenvalues(equilibrium) < 0.0)
    assert equilibrium.stats.negative_pivots == negative


@pytest.mark.parametrize("push", [1e-3, -1e-3])
def test_a_column_that_is_pushed_buckles_to_that_side(push):
    scene, rod = column(1.5, push)
    equilibrium = ancf.solve_static(scene)
    assert equilibrium.stable
    assert np.sign(equilibrium.position(rod.end)[1]) == np.sign(push)
    # Far beyond its load it has bent by more than half its length: the elastica of a tip load.
    assert abs(equilibrium.position(rod.end)[1]) == pytest.approx(0.789, abs=2e-3)


def arch(force, *, as_constraint=False):
    scene = ancf.Scene((0.0, 0.0))
    section, material = ancf.Circle(0.02), ancf.Material(1e9, 1e3)
    one = scene.add_beam("thin", (0, 0), (1, 0.1), 10, section, material)
    two = scene.add_beam("thin", (1, 0.1), (2, 0), 10, section, material)
    scene.pin(one.start, as_constraint=as_constraint)
    scene.pin(two.end, as_constraint=as_constraint)
    scene.connect(one.end, two.start)
    scene.point_force(one.end, (0, -force))
    return scene, one


def test_an_arch_snaps_through():
    # Beyond the end of its path of equilibria: where it settles.
    scene, one = arch(1000.0)
    equilibrium = ancf.solve_static(scene)
    assert equilibrium.stable
    assert equilibrium.position(one.end)[1] < -0.1


@pytest.mark.parametrize("as_constraint", [False, True])
def test_multipliers_do_not_change_what_is_counted(as_constraint):
    scene, _ = arch(100.0, as_constraint=as_constraint)
    with pytest.warns(ancf.UnstableEquilibriumWarning):
        equilibrium = ancf.solve_static(scene)
    assert equilibrium.stats.negative_pivots == np.count_nonzero(eigenvalues(equilibrium) < 0.0) > 0


def test_moments_in_space_have_no_potential_and_no_warning():
    scene, rod = roll_up("thin", 16, dim=3)
    equilibrium = ancf.solve_static(scene)
    flat_scene, flat = roll_up("thin", 16)
    expected = ancf.solve_static(flat_scene).position(flat.end)
    np.testing.assert_allclose(equilibrium.position(rod.end)[:2], expected, rtol=0, atol=1e-7)


# What it needs and shows.


def test_an_unstable_equilibrium_serves_where_no_other_is_found(monkeypatch):
    def lost(_equations, state, load, _tolerance, **_options):
        raise NotFoundError("it does not come to rest", state, load)

    monkeypatch.setattr("ancfsparse.solve.statics.load_stepping.relax", lost)
    monkeypatch.setattr("ancfsparse.solve.statics.load_stepping.MIN_STEP", 1.0)
    scene, _ = column(1.5, 1e-3)
    with pytest.warns(ancf.UnstableEquilibriumWarning):
        equilibrium = ancf.solve_static(scene)
    assert equilibrium.stats.steps == 1
    assert unbalanced(equilibrium) < 1e-8
