"""Paths past limit points: a truss by formula, Williams' frame by its differential equation."""

import math

import matplotlib as mpl
import numpy as np
import pytest
from scipy.integrate import solve_bvp

import ancfsparse as ancf
from tests.solve.refusals import assert_refused

mpl.use("Agg")


def truss(force, *, size=1.0):
    """Two hinged bars that meet at an apex, of one element each."""
    scene = ancf.Scene((0.0, 0.0))
    inertia = 1e-4 * size**4  # so large that no bar buckles by itself
    section = ancf.Section(1e-4 * size**2, inertia, inertia, inertia)
    material = ancf.Material(1e9, 1000.0)
    left = scene.add_beam("thin", (-size, 0.0), (0.0, 0.2 * size), 1, section, material)
    right = scene.add_beam("thin", (size, 0.0), (0.0, 0.2 * size), 1, section, material)
    scene.connect(left.end, right.end)
    scene.pin(left.start)
    scene.pin(right.start)
    scene.point_force(left.end, (0.0, -force))
    return scene, left, left.parameters()["axial_stiffness"]


def snap(height, stiffness):
    """Force down on the apex at a height: two bars with Green's strain, by their energy."""
    length = math.hypot(1.0, 0.2)
    strain = (height**2 - 0.2**2) / (2.0 * length**2)
    return -2.0 * stiffness * strain * height / length


@pytest.mark.parametrize("size", [1.0, 1e-4, 1e3])
def test_two_bars_snap_through_as_their_energy_says(size):
    scene, left, stiffness = truss(1.0, size=size)
    top = snap(0.2 / math.sqrt(3.0), stiffness)
    scene, left, stiffness = truss(1.2 * snap(0.2 / 3**0.5, stiffness), size=size)
    path = ancf.load_path(scene)
    heights = path.position(left.end)[:, 1] / size
    force = 1.2 * top
    np.testing.assert_allclose(path.factors * force, snap(heights, stiffness), atol=1e-7 * force)
    np.testing.assert_allclose(path.limits, [1.0 / 1.2, -1.0 / 1.2], rtol=1e-9)
    assert path.complete
    assert path.factors[-1] == 1.0
    unstable = np.abs(heights) < 0.2 / math.sqrt(3.0) * (1.0 - 1e-6)
    assert not path.stable[unstable].any()
    assert path.stable[np.abs(heights) > 0.2 / math.sqrt(3.0) * (1.0 + 1e-6)].all()
    assert heights[-1] < -0.2


RISE, HALF = 0.386, 12.943  # of Williams' frame [in]
EA, EI = 1.885e6, 9.274e3  # lb, lb in^2


def williams(apex):
    """Load on the apex of Williams' toggle for its deflections, by its differential equation.

    Half of the frame: clamped at one end, guided at the apex, which has no turn.
    """
    slope, length = math.atan2(RISE, HALF), math.hypot(HALF, RISE)
    loads, guess = [], None
    for down in apex:
        # State: angle, curvature, x, y over s, and the constant forces H and V as parameters.
        def rate(s, state, forces):
            angle, curvature, _x, _y = state
            h, v = forces
            normal = h * np.cos(angle) + v * np.sin(angle)
            stretch = 1.0 + normal / EA
            across = -h * np.sin(angle) + v * np.cos(angle)
            way = stretch * np.cos(angle), stretch * np.sin(angle)
            return np.stack([curvature, -across * stretch / EI, *way])

        def ends(a, b, forces, down=down):
            at = [a[0] - slope, a[2], a[3]]
            return np.array([*at, b[0] - slope, b[2] - HALF, b[3] - (RISE - down)])

        if guess is None:
            s = np.linspace(0.0, length, 41)
            start = np.stack([np.full_like(s, slope), 0 * s, np.cos(slope) * s, np.sin(slope) * s])
            guess = s, start, np.array([-1.0, -1.0])
        found = solve_bvp(rate, ends, guess[0], guess[1], p=guess[2], tol=1e-9, max_nodes=20000)
        assert found.success
        guess = found.x, found.y, found.p
        loads.append(-2.0 * found.p[1])
    return np.array(loads)


def toggle(n, force):
    """Williams' frame in inches and pounds."""
    scene = ancf.Scene((0.0, 0.0))
    section = ancf.Section(EA / 1e7, EI / 1e7, EI / 1e7, 1e-3)  # for E = 1e7 lb/in^2
    material = ancf.Material(1e7, 1.0)
    left = scene.add_beam("thin", (0, 0), (HALF, RISE), n, section, material, strain="biot")
    right = scene.add_beam("thin", (2 * HALF, 0), (HALF, RISE), n, section, material, strain="biot")
    scene.clamp(left.start)
    scene.clamp(right.start)
    scene.weld(left.end, right.end)
    scene.point_force(left.end, (0.0, -force))
    return scene, left


def test_williams_frame_against_its_differential_equation():
    scene, left = toggle(10, 60.0)
    path = ancf.load_path(scene)
    down = -path.displacement(left.end)[:, 1]
    chosen = np.flatnonzero((down > 0.02) & (down < 0.75))[::4]
    exact = williams(down[chosen])
    np.testing.assert_allclose(60.0 * path.factors[chosen], exact, atol=2e-3 * 34.0)
    assert len(path.limits) == 2
    # Williams (1964) and those after him: a limit load near 34 lb.
    assert 60.0 * path.limits[0] == pytest.approx(34.0, rel=0.02)
    assert not path.stable[path.turns[0] + 1]
    assert path.stable[-1]


def test_a_path_without_limit_ends_where_statics_does():
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 10, ancf.Circle(0.01), ancf.Material(1e8, 1000.0))
    scene.clamp(rod.start)
    scene.point_force(rod.end, (0.0, 2.0))
    path = ancf.load_path(scene)
    rest = ancf.solve_static(scene)
    np.testing.assert_allclose(path.q[-1], rest.q, atol=1e-9)
    assert not len(path.limits)
    assert (np.diff(path.factors) > 0.0).all()
    assert path.stable.all()


def test_a_path_with_a_body_and_multipliers():
    # The truss with a rigid bar for its left half: only the right bar is elastic.
    scene = ancf.Scene((0.0, 0.0))
    section, material = ancf.Circle(0.01), ancf.Material(1e9, 1000.0)
    right = scene.add_beam("thin", (1.0, 0.0), (0.0, 0.2), 1, section, material)
    scene.pin(right.start)
    scene.rod(right.end, (-1.0, 0.0))
    scene.point_force(right.end, (0.0, -600.0))
    path = ancf.load_path(scene)
    places = path.position(right.end)
    radius = math.hypot(1.0, 0.2)
    np.testing.assert_allclose(np.hypot(places[:, 0] + 1.0, places[:, 1]), radius, rtol=1e-10)
    assert len(path.limits) == 2
    # By the energy: the apex on a circle, at the angle a, stores EA L e^2 / 2.
    angle = np.linspace(0.3, -0.6, 20001)
    x, y = radius * np.cos(angle) - 1.0, radius * np.sin(angle)
    strain = ((x - 1.0) ** 2 + y**2 - radius**2) / (2.0 * radius**2)
    energy = 0.5 * right.parameters()["axial_stiffness"] * radius * strain**2
    force = -np.gradient(energy, angle) / np.gradient(y, angle)
    inside = np.abs(angle) < math.atan(0.2)
    assert path.limits[0] * 600.0 == pytest.approx(force[inside].max(), rel=1e-4)


def test_pictures_states_and_bad_input():
    scene, left, stiffness = truss(1.0)
    scene, left, stiffness = truss(1.1 * snap(0.2 / math.sqrt(3.0), stiffness))
    path = ancf.load_path(scene, points=8)
    assert not path.complete
    assert "not complete" in repr(path)
    ax = path.plot(left.end)
    assert "load factor" in ax.get_ylabel()
    mpl.pyplot.close(ax.figure)
    assert path.state(-1).q.shape == path.q[0].shape
    assert_refused("point counts from 0 to 7", path.state, 8)
    assert_refused("to", ancf.load_path, scene, to=-1.0)
    assert_refused("at least 1e-06, got 1e-300", ancf.load_path, scene, to=1e-300)
    empty = ancf.Scene((0.0, 0.0))
    rod = empty.add_beam("thin", (0, 0), (1, 0), 2, ancf.Circle(0.01), ancf.Material(1e8, 1000.0))
    empty.clamp(rod.start)
    assert_refused("no loads", ancf.load_path, empty)
