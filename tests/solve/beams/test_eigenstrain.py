"""Beams that are free of stress where temperature or layers have strained and bent them."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from tests.solve.refusals import assert_refused

E, SIDE, LENGTH = 2e11, 0.01, 1.0
SECTION, STEEL = ancf.Rectangle(SIDE, SIDE), ancf.Material(E, 7800.0, 0.3)
AREA, EI = SIDE**2, E * SIDE**4 / 12.0
KINDS = [
    ("thin", 2, {}),
    ("thin", 2, {"strain": "biot"}),
    ("thick", 2, {"section_strain": "nodal"}),
    ("thick", 3, {}),
    ("thick", 3, {"section_strain": "nodal"}),
    ("thick", 3, {"curvature": "section"}),
]


def beam(element, dim, n=8, **options):
    z = (0.0,) * (dim - 1)
    scene = ancf.Scene((0.0, *z))
    rod = scene.add_beam(element, (0.0, *z), (LENGTH, *z), n, SECTION, STEEL, **options)
    return scene, rod


def about_z(dim, value):
    return value if dim == 2 else (0.0, value)


@pytest.mark.parametrize(("element", "dim", "options"), KINDS)
@pytest.mark.parametrize("turn", [0.3, -math.pi / 2])
def test_a_strip_of_two_layers_bends_into_an_arc(element, dim, options, turn):
    scene, rod = beam(element, dim, eigencurvature=about_z(dim, turn / LENGTH), **options)
    scene.clamp(rod.start)
    rest = ancf.solve_static(scene)
    for s in (0.25, 0.5, 1.0):
        angle = turn * s
        arc = np.array([math.sin(angle), 1.0 - math.cos(angle)]) / turn
        np.testing.assert_allclose(rest.position(rod.at(s))[:2], arc, atol=1e-9)
    assert rest.system.assembly.strain_energy(rest.q) < 1e-18 * E * AREA * LENGTH
    assert np.abs(rest.section_force(rod).M).max() < 1e-8 * EI * abs(turn)
    assert rest.stable


def test_a_strip_rolls_up_into_a_circle():
    scene, rod = beam("thin", 2, 16, eigencurvature=2.0 * math.pi / LENGTH)
    scene.clamp(rod.start)
    rest = ancf.solve_static(scene)
    np.testing.assert_allclose(rest.position(rod.end), 0.0, atol=1e-9)
    np.testing.assert_allclose(rest.position(rod.node(8)), (0.0, 1.0 / math.pi), atol=1e-9)


def test_in_space_it_bends_about_both_axes_of_the_section():
    scene, rod = beam("thick", 3, eigencurvature=(0.3, 0.4))
    scene.clamp(rod.start)
    tip = ancf.solve_static(scene).position(rod.end)
    arc = np.array([math.sin(0.5), 1.0 - math.cos(0.5)]) / 0.5
    # About 0.3 e_y + 0.4 e_z: towards 0.8 e_y - 0.6 e_z.
    np.testing.assert_allclose(tip, [arc[0], 0.8 * arc[1], -0.6 * arc[1]], atol=1e-8)


@pytest.mark.parametrize(("element", "dim", "options"), KINDS)
def test_a_heated_beam_grows_freely_and_pushes_where_it_is_held(element, dim, options):
    strain = 12e-6 * 5.0  # below what makes it buckle
    scene, rod = beam(element, dim, 16, eigenstrain=strain, **options)
    scene.clamp(rod.start)
    rest = ancf.solve_static(scene)
    # A clamp that holds r_x or the height of the section is felt close to it alone.
    near = 1e-10 if element == "thin" else 2e-3
    np.testing.assert_allclose(rest.strain(rod, 0.6 * LENGTH), strain, rtol=near)
    assert np.abs(rest.section_force(rod, 0.6 * LENGTH).N).max() < 1e-6 * E * AREA * strain
    held, other = beam(element, dim, 16, eigenstrain=strain, **options)
    held.clamp(other.start)
    held.pin(other.end)
    stuck = ancf.solve_static(held)
    force = [stuck.section_force(other, 0.6 * LENGTH).N[0], stuck.reaction(other.end)[0]]
    # Green's strain of the free shape is strain + strain^2 / 2, and clamps hold the section.
    np.testing.assert_allclose(force, -E * AREA * strain, rtol=1e-4 if element == "thin" else 0.03)


def test_a_strip_between_two_clamps_has_a_moment_and_does_not_move():
    bend = 0.2
    scene, rod = beam("thin", 2, eigencurvature=bend)
    scene.clamp(rod.start)
    scene.clamp(rod.end)
    rest = ancf.solve_static(scene)
    np.testing.assert_allclose(rest.q, rest.system.q_ref, atol=1e-12)
    np.testing.assert_allclose(rest.section_force(rod).M, -EI * bend, rtol=1e-6)


def test_heat_lowers_the_frequencies_of_a_pinned_beam():
    strain = 2e-5
    scene, rod = beam("thin", 2, 20, eigenstrain=strain, strain="biot")
    scene.pin(rod.start)
    scene.pin(rod.end)
    found = ancf.modes(ancf.solve_static(scene), 2)
    k = math.pi * np.array([1.0, 2.0]) / LENGTH
    square = (EI * k**4 - E * AREA * strain * k**2) / (7800.0 * AREA)
    np.testing.assert_allclose(found.eigenvalues, square, rtol=1e-4)


def test_a_gradient_along_the_beam():
    scene, rod = beam("thin", 2, 40, eigencurvature=lambda s: s)
    scene.clamp(rod.start)
    tip = ancf.solve_static(scene).position(rod.end)
    s = (np.arange(4000) + 0.5) / 4000
    angle = 0.5 * s**2  # the clothoid
    exact = np.mean(np.cos(angle)), np.mean(np.sin(angle))
    np.testing.assert_allclose(tip, exact, atol=1e-4)


def test_a_motion_from_the_straight_shape_keeps_its_energy():
    scene, rod = beam("thin", 2, 6, eigencurvature=0.5)
    scene.clamp(rod.start)
    run = ancf.simulate(scene, 0.05, 1e-4, integrator=ancf.EnergyMomentum())
    assert run.energy.elastic[0] == pytest.approx(0.5 * EI * 0.25 * LENGTH, rel=1e-3)
    assert run.energy.drift < 1e-9
    assert run.position(rod.end)[:, 1].max() > 0.2


def test_what_has_no_such_shape_and_bad_values_are_named():
    assert_refused("take 'thick', or 'thin' in the plane", beam, "thin", 3, eigenstrain=1e-3)
    assert_refused("take 'thick', or 'thin' in the plane", beam, "string", 2, eigenstrain=1e-3)
    assert_refused("above -1", beam, "thin", 2, eigenstrain=-1.5)
    assert_refused("two finite numbers in 1/m", beam, "thick", 3, eigencurvature=(0.1, math.nan))
    assert_refused("eigencurvature of beam 0", beam, "thin", 2, eigencurvature=(0.1, 0.2))
    with pytest.raises(InputError, match=r"failed at s = 0.0625 m: ZeroDivisionError"):
        beam("thin", 2, eigenstrain=lambda s: 1.0 / 0.0)
