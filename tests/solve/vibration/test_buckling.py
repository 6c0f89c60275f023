"""Buckling loads against Euler's, Prandtl's and Timoshenko's formulas."""

import math

import matplotlib as mpl
import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import ApproximateModesWarning, InputError, SingularSceneError
from tests.beams import build_beam

mpl.use("Agg")

YOUNGS, DENSITY, SIDE, LENGTH = 2.1e11, 7800.0, 3e-4, 1.0
SECTION, STEEL = ancf.Rectangle(SIDE, SIDE), ancf.Material(YOUNGS, DENSITY)
EI = YOUNGS * SIDE**4 / 12.0
# Euler's four cases: roots of the load P L^2 / EI, pi squared over the square of the length factor.
CLAMPED_PINNED = 4.493409457909064  # tan x = x
EULER = {
    "free": (0.5 * math.pi) ** 2,
    "pinned": math.pi**2,
    "clamped and pinned": CLAMPED_PINNED**2,
    "clamped": (2.0 * math.pi) ** 2,
}


def column(ends, n, dim=2, element="thin"):
    """A column of which one end slides along its axis, under Euler's load EI / L^2."""
    z = (0.0,) * (dim - 1)
    scene, rod = build_beam(element, (0.0, *z), (LENGTH, *z), n, SECTION, STEEL, gravity=(0.0, *z))
    (scene.pin if ends == "pinned" else scene.clamp)(rod.start)
    if ends == "clamped":
        carriage = scene.add_body(
            mass=1.0, inertia=0.1 if dim == 2 else (0.1,) * 3, position=(LENGTH, *z)
        )
        scene.weld(carriage.origin, rod.end)
        scene.prismatic(carriage.origin, axis=(1.0, *z))
    elif ends != "free":
        # A long rod across the axis in the plane leaves the end free to move along it.
        far = 1e4 * LENGTH
        scene.rod(rod.end, (LENGTH, far, *z[1:]))
        if dim == 3:
            scene.rod(rod.end, (LENGTH, 0.0, far))
    scene.point_force(rod.end, (-EI / LENGTH**2, *z))
    return scene, rod


@pytest.mark.parametrize("ends", EULER)
@pytest.mark.parametrize("dim", [2, 3])
def test_eulers_columns_to_the_order_of_the_mesh(ends, dim):
    exact, off = EULER[ends], []
    for n in (4, 8, 16):
        found = ancf.buckling(column(ends, n, dim)[0])
        off.append(found.factors[0] / exact - 1.0)
    strain = exact * EI / LENGTH**2 / (YOUNGS * SIDE**2)  # what the formula leaves out
    # Cubic elements of length h are too stiff by (k h)^4 / 720 where the shape has the wave k.
    assert abs(off[2]) < 1.1 * (exact / 16**2) ** 2 / 720.0 + 10.0 * strain
    assert math.log2(off[0] / off[1]) == pytest.approx(4.0, abs=0.15)


def test_higher_loads_and_the_shapes():
    scene, rod = column("pinned", 40)
    found = ancf.buckling(scene, 4)
    np.testing.assert_allclose(found.factors, (math.pi * np.arange(1, 5)) ** 2, rtol=1e-4)
    for k in range(4):
        w = np.array([found.displacement(rod.node(i))[k, 1] for i in range(41)])
        wave = np.sin((k + 1) * math.pi * np.linspace(0.0, 1.0, 41))
        assert abs(w @ wave) > (1.0 - 1e-6) * np.linalg.norm(w) * np.linalg.norm(wave)
    assert "buckling 1, 39.48 times the loads" in found._name(1)
    ax = found.plot(0)
    mpl.pyplot.close(ax.figure)


def narrow(n, nu=0.3):
    """A cantilever in space, twenty times as high along z as wide along y."""
    section = ancf.Rectangle(0.02, 0.001)
    scene, rod = build_beam(
        "thick", (0, 0, 0), (LENGTH, 0, 0), n, section, ancf.Material(YOUNGS, DENSITY, nu), "clamp",
        gravity=(0.0, 0.0, 0.0), section_strain="nodal",
    )  # fmt: skip
    p = rod.parameters()
    return scene, rod, p["bending_stiffness_z"], p["torsion_stiffness"]


def test_lateral_buckling_of_a_narrow_cantilever():
    # Prandtl (1899): 4.0126 sqrt(EI GJ) / L^2, where the bending before is small.
    scene, rod, bending, torsion = narrow(32)
    unit = math.sqrt(bending * torsion) / LENGTH**2
    scene.point_force(rod.end, (0.0, 0.0, -unit))
    found = ancf.buckling(scene, 2)
    assert found.factors[0] == pytest.approx(4.0126, rel=3e-3)
    # It leaves the plane and twists.
    moved = found.displacement(rod.end)[0]
    assert abs(moved[1]) > 1e3 * abs(moved[2])


def test_about_an_equilibrium_the_load_is_that_of_the_state():
    scene, _ = column("free", 8)
    exact = EULER["free"]
    about = ancf.buckling(scene).factors[0]
    share = 0.95 * exact
    loaded = scene.replaced()
    loaded.point_force(loaded.beams[0].end, ((1.0 - share) * EI / LENGTH**2, 0.0))
    near = ancf.buckling(ancf.solve_static(loaded))
    assert near.factors[0] * share == pytest.approx(about, rel=1e-5)
    assert "times the loads" in repr(near)


def test_a_small_problem_and_a_large_one_agree():
    # 100 degrees of freedom separate a dense solution from a sparse one.
    few, many = (ancf.buckling(column("free", n)[0], 3).factors for n in (24, 48))
    np.testing.assert_allclose(few, many, rtol=1e-4)


def test_buckling_shapes_start_what_bends_a_column():
    scene, _ = column("free", 8)
    found = ancf.buckling(scene)
    start = found.state(0, 1e-3)
    moved = np.linalg.norm(start.q - found.about.q)
    assert 0.0 < moved < 1.0


def test_what_cannot_buckle_is_named():
    scene, rod = column("free", 4)
    none, beam = build_beam("thin", (0, 0), (1, 0), 4, SECTION, STEEL, "clamp", gravity=(0.0, 0.0))
    with pytest.raises(InputError, match="no loads that could make it buckle"):
        ancf.buckling(none)
    none.point_force(beam.end, (1.0, 0.0))
    pulled = ancf.buckling(none)
    assert len(pulled) == 0
    assert "none" in repr(pulled)
    scene.point_force(rod.end, (-5.0 * EI, 0.0))
    with pytest.warns(UserWarning, match="unstable"):
        rest = ancf.solve_static(scene)
    if not rest.stable:
        with pytest.raises(InputError, match="not stable"):
            ancf.buckling(rest)
    free = ancf.Scene((0.0, -9.81))
    free.add_beam("thin", (0, 0), (1, 0), 4, SECTION, STEEL)
    with pytest.raises(SingularSceneError):
        ancf.buckling(free)
    follower, tip = column("free", 4)
    follower.point_force(tip.end, (-1.0, 0.0), follow=True)
    with pytest.warns(ApproximateModesWarning):
        ancf.buckling(follower)
