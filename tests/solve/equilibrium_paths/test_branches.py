"""Equilibria on branches: Euler's elastica beyond its load, a frame, and what has no branch."""

import numpy as np
import pytest

import ancfsparse as ancf
from tests.beams import build_beam
from tests.solve.equilibrium_paths.elastica import elastica

STEEL = ancf.Material(2.07e11, 7850.0)
SIZES = [1e-3, 1.0, 1e3]


def column(n=16, size=1.0, **options):
    """A cantilever as slender as 500 under the load of Euler along its axis."""
    section, zero = ancf.Circle(4.0 * size / 500.0), (0.0, 0.0)
    scene, rod = build_beam(
        "thin", zero, (size, 0), n, section, STEEL, "clamp", gravity=zero, **options
    )
    stiffness = rod.parameters()["bending_stiffness"]
    scene.point_force(rod.end, (-(np.pi**2) / 4.0 * stiffness / size**2, 0.0))
    return scene, rod


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("size", SIZES)
def test_a_column_follows_the_elastica(size, side):
    scene, rod = column(size=size, strain="biot")
    path = ancf.load_path(scene, to=1.5, branch=side)
    assert path.complete
    assert path.stable.all()
    (fork,) = path.forks
    assert path.factors[fork] == pytest.approx(1.0, abs=1e-3)
    found = path.position(rod.end) / size
    after = np.flatnonzero(path.factors > 1.01)
    assert len(after) > 5
    expected = np.array([elastica(path.factors[k]) for k in after])
    expected[:, 1] *= np.sign(found[-1, 1])
    # It stretches by 1e-5 of its length.
    np.testing.assert_allclose(found[after], expected, rtol=0.0, atol=2e-3)
    np.testing.assert_allclose(found[-1], expected[-1], rtol=0.0, atol=2e-4)
    other = ancf.load_path(scene, to=1.5, branch=-side)
    np.testing.assert_allclose(other.position(rod.end)[-1] / size, found[-1] * [1, -1], atol=1e-7)


def test_the_path_goes_straight_on_without_a_branch():
    scene, rod = column()
    path = ancf.load_path(scene, to=1.5)
    assert not len(path.forks)
    assert not path.stable[-1]
    assert np.abs(path.position(rod.end)[:, 1]).max() < 1e-9
    assert "leaves" not in repr(path)
    assert "leaves its branch at 1.0000" in repr(ancf.load_path(scene, to=1.1, branch=1))


@pytest.mark.parametrize("branch", [2, 1.0, True, "1", None, np.ones(2)])
def test_odd_branches_are_refused(branch):
    scene, _ = column(4)
    with pytest.raises(ancf.InputError, match="branch must be 1, -1 or 0"):
        ancf.load_path(scene, branch=branch)


def test_an_arch_sways_before_it_snaps_through():
    """Its symmetric path is left between two points where it loses its stability.

    On the branch the load falls and the crown moves sideways, which it does not on the path.
    """
    section, soft = ancf.Rectangle(0.02, 0.02), ancf.Material(1e9, 1000.0)
    scene, left = build_beam("thin", (0, 0), (1, 0.1), 6, section, soft, gravity=(0.0, 0.0))
    right = scene.add_beam("thin", (1, 0.1), (2, 0), 6, section, soft)
    scene.weld(left.end, right.start)
    scene.pin(left.start)
    scene.pin(right.end)
    scene.point_force(left.end, (0.0, -100.0))
    straight = ancf.load_path(scene)
    lost = int(np.argmin(straight.stable))
    path = ancf.load_path(scene, branch=1, points=14)
    (fork,) = path.forks
    assert straight.factors[lost - 1] <= path.factors[fork] <= straight.factors[lost]
    assert np.abs(straight.displacement(left.end)[:, 0]).max() < 1e-9
    sway = path.displacement(left.end)[:, 0]
    assert np.abs(sway[: fork + 1]).max() < 1e-9
    assert (np.abs(sway[fork + 1 :]) > 1e-4).all()
    assert (np.diff(path.factors[fork:]) < 0.0).all()
    # The path that leads back to where it began, and on to loads of the other sign, is ended.
    whole = ancf.load_path(scene, branch=1)
    assert not whole.complete
    assert -100.0 < whole.factors[-1] < -10.0
    assert len(whole) < 100
