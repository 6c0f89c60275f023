"""Natural frequencies against formulas: beams, strings, hanging chains, columns, springs."""

import itertools
import math

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import jn_zeros

import ancfsparse as ancf
from ancfsparse.errors import InputError, UnstableEquilibriumWarning
from tests.beams import build_beam

E, RHO, SIDE, LENGTH = 2.1e11, 7800.0, 0.01, 1.0
AREA, INERTIA = SIDE**2, SIDE**4 / 12.0
SECTION, STEEL = ancf.Rectangle(SIDE, SIDE), ancf.Material(E, RHO)
# The equation of beta L and brackets of its roots, for Euler and Bernoulli's beam.
ENDS = {
    ("", ""): (lambda x: math.cos(x) - 1.0 / math.cosh(x), [(4, 5), (7, 8)]),
    ("clamp", "clamp"): (lambda x: math.cos(x) - 1.0 / math.cosh(x), [(4, 5), (7, 8)]),
    ("clamp", ""): (lambda x: math.cos(x) + 1.0 / math.cosh(x), [(1, 3), (4, 5)]),
    ("pin", "pin"): (lambda x: math.sin(x), [(3, 4), (6, 7)]),
    ("clamp", "pin"): (lambda x: math.tan(x) - math.tanh(x), [(3.5, 4.5), (6.9, 7.8)]),
}


def beam(n, ends=(), dim=2, element="thin"):
    end = LENGTH * np.eye(dim)[0]
    return build_beam(element, 0 * end, end, n, SECTION, STEEL, *ends, gravity=0 * end)


@pytest.mark.parametrize("ends", ENDS)
@pytest.mark.parametrize("element", ["thin", "l2t2"])
def test_beams_vibrate_as_euler_and_bernoulli_say_to_the_order_of_the_mesh(ends, element):
    equation, brackets = ENDS[ends]
    roots = np.array([brentq(equation, *bracket, xtol=1e-14) for bracket in brackets])
    exact = roots**2 / (2.0 * math.pi * LENGTH**2) * math.sqrt(E * INERTIA / (RHO * AREA))
    rigid, errors = 0 if any(ends) else 3, []
    for n in (8, 16, 32):
        found = ancf.modes(beam(n, ends, element=element)[0], rigid + 2)
        assert (found.frequencies[:rigid] == 0.0).all()
        assert found.stable
        errors.append(found.frequencies[rigid:] / exact - 1.0)
    errors = np.array(errors)
    assert (errors > 0.0).all()  # conforming elements are too stiff
    orders = np.log2(errors[:-1] / errors[1:])
    np.testing.assert_allclose(orders[-1], 4.0, atol=0.05)
    assert errors[-1].max() < 5e-6


@pytest.mark.parametrize("n", [6, 60])
def test_a_free_beam_in_space_has_five_rigid_motions_and_pairs(n):
    # Six of a body, but a cable does not notice that it turns about itself.  Dense, and sparse.
    found = ancf.modes(beam(n, dim=3)[0], 9)
    planar = ancf.modes(beam(n)[0], 5)
    assert (found.frequencies[:5] == 0.0).all()
    np.testing.assert_allclose(
        found.frequencies[5:], np.repeat(planar.frequencies[3:], 2), rtol=1e-9
    )


def test_a_string_under_tension_that_resists_bending():
    slender, strain, n = 1e-3, 1e-6, 60
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), n, ancf.Rectangle(slender, slender), STEEL, "pin",
        gravity=(0.0, 0.0), strain="biot",
    )  # fmt: skip
    scene.drive(rod.end, lambda t: (1.0 + strain, 0.0))
    found = ancf.modes(ancf.solve_static(scene), 4)
    wave = math.pi * np.arange(1, 5)
    square = wave**2 * E * strain / RHO + wave**4 * E * slender**2 / 12.0 / RHO
    # Tension makes as much of the first as bending; the strain is what the formula leaves out.
    np.testing.assert_allclose(found.eigenvalues, square, rtol=2e-5)
    relaxed = ancf.modes(scene, 1).eigenvalues[0]
    np.testing.assert_allclose(found.eigenvalues[0] / relaxed, 1.0 + 12.0 / math.pi**2, rtol=1e-4)


def test_a_hanging_chain_has_the_zeros_of_a_bessel_function():
    def rope(hold):
        thread, material = ancf.Rectangle(1e-6, 1e-6), ancf.Material(1e9, 1000.0)
        return build_beam("thin", (0, 0), (0, -2), 40, thread, material, hold)[0]

    # A clamp holds it while it is not yet stretched.
    found = ancf.modes(rope("pin"), 5, at=ancf.solve_static(rope("clamp")))
    exact = 0.5 * jn_zeros(0, 5) * math.sqrt(9.81 / 2.0) / (2.0 * math.pi)
    np.testing.assert_allclose(found.frequencies, exact, rtol=1e-4)


@pytest.mark.parametrize("n", [16, 40])
def test_a_column_beyond_its_buckling_load_grows_as_the_formula_says(n):
    side = 1e-3
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), n, ancf.Rectangle(side, side), STEEL)
    strain = 5.0 * math.pi**2 * side**2 / 12.0  # five times Euler's load
    scene.pin(rod.start)
    scene.drive(rod.end, lambda t: (1.0 - strain, 0.0))
    with pytest.warns(UnstableEquilibriumWarning):
        rest = ancf.solve_static(scene)
    found = ancf.modes(rest, 4)
    wave = math.pi * np.arange(1, 5)
    square = E / RHO * (wave**4 * side**2 / 12.0 - wave**2 * strain)
    assert rest.stats.negative_pivots == 2
    assert not found.stable
    assert np.count_nonzero(found.eigenvalues < 0.0) == 2
    np.testing.assert_allclose(found.eigenvalues, np.sort(square), rtol=2e-3)
    np.testing.assert_allclose(found.growth[:2], np.sqrt(-np.sort(square)[:2]), rtol=1e-3)
    assert (found.frequencies[:2] == 0.0).all()


@pytest.mark.parametrize("n", [6, 40])
def test_rigid_bodies_on_stretched_springs_vibrate_like_a_loaded_string(n):
    # Beads at equal distances: springs give 2 sqrt(k/m) sin along, their tension the same across.
    mass, stiffness, apart, natural = 0.3, 50.0, 0.1, 0.06
    scene = ancf.Scene((0.0, 0.0))
    shape = ancf.Box(length=0.02, width=0.01, height=0.01)
    beads = [scene.add_body(shape, mass=mass, position=(apart * (k + 1), 0.0)) for k in range(n)]
    points = [(0.0, 0.0), *(bead.origin for bead in beads), (apart * (n + 1), 0.0)]
    for a, b in itertools.pairwise(points[1:]):
        scene.spring(a, b, stiffness=stiffness, length=natural)
    scene.spring(points[1], points[0], stiffness=stiffness, length=natural)
    found = ancf.modes(scene, n + 5)
    sines = np.sin(math.pi * np.arange(1, n + 1) / (2 * (n + 1)))
    across = 2.0 * math.sqrt(stiffness * (apart - natural) / (mass * apart)) * sines
    along = 2.0 * math.sqrt(stiffness / mass) * sines
    exact = np.sort(np.concatenate([across, along]))[:5] / (2.0 * math.pi)
    assert (found.frequencies[:n] == 0.0).all()  # each may spin
    np.testing.assert_allclose(found.frequencies[n:], exact, rtol=1e-8)


def test_a_rigid_pendulum_on_a_spring():
    mass, inertia, arm, hold, stiffness = 2.0, 0.05, 0.3, 0.5, 40.0
    scene = ancf.Scene((0.0, -9.81))
    body = scene.add_body(mass=mass, inertia=inertia, centre=(0.0, -arm), position=(0.0, 0.0))
    scene.pin(body.origin)
    scene.spring(body.at((0.0, -hold)), (1.0, -hold), stiffness=stiffness)
    rest = ancf.simulate(scene, 0.01, 0.01).last
    found = ancf.modes(scene, 1, at=rest)
    square = (stiffness * hold**2 + mass * 9.81 * arm) / (inertia + mass * arm**2)
    np.testing.assert_allclose(found.frequencies, math.sqrt(square) / (2.0 * math.pi), rtol=1e-12)


def test_mechanisms_of_many_coordinates_and_few_motions():
    # Pendulums, each with five equations for its six coordinates.
    mass, inertia, n = 2.0, 0.05, 60
    scene, arms = ancf.Scene((0.0, -9.81)), np.linspace(0.05, 1.0, n)
    for k, arm in enumerate(arms):
        body = scene.add_body(mass=mass, inertia=inertia, position=(k, -arm))
        scene.pin(body.at((0.0, arm)))
    rest = ancf.simulate(scene, 0.01, 0.01).last
    found = ancf.modes(scene, n, at=rest)
    square = np.sort(mass * 9.81 * arms / (inertia + mass * arms**2))
    np.testing.assert_allclose(found.eigenvalues, square, rtol=1e-10)
    with pytest.raises(InputError, match="at most 60"):
        ancf.modes(scene, n + 1, at=rest)
