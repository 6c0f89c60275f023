"""Quadrature points of contacts with obstacles: exactness, distances, and free ends."""

import numpy as np
import pytest

import ancfsparse as ancf

SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(1e7, 1e3)
RADIUS = 0.005


def contact_with(obstacle, n, length=1.0, **joints):
    """Return the contact of a level cable with an obstacle, with joints at the named ends."""
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (0, 0.5), (length, 0.5), n, SECTION, MATERIAL)
    for node in joints:
        scene.pin(getattr(cable, node))
    return scene.contact(cable, obstacle)


def positions(contact):
    return np.array([point.position[0] for point in contact.points])


FLOOR = ancf.HalfSpace((0, 0), (0, 1))


@pytest.mark.parametrize("obstacle", [FLOOR, ancf.Ball((0.5, 0), 0.3)], ids=repr)
@pytest.mark.parametrize("n", [3, 7, 40])
def test_polynomials_of_degree_five_are_integrated_exactly(obstacle, n):
    contact = contact_with(obstacle, n)
    for degree in range(6):
        assert contact.weights @ positions(contact) ** degree == pytest.approx(1 / (degree + 1))


@pytest.mark.parametrize("n", [2, 5, 30])
def test_the_axis_extends_beyond_its_last_points_by_less_than_the_radius(n):
    x = positions(contact_with(FLOOR, n))
    assert 0.0 < x[0] < 0.92 * RADIUS
    assert 0.0 < 1.0 - x[-1] < 0.92 * RADIUS


def test_ends_that_a_joint_holds_have_the_three_points_of_all_elements():
    x = positions(contact_with(FLOOR, 4, start=True))
    gauss = 0.5 + 0.5 * np.polynomial.legendre.leggauss(3)[0]
    assert x[:9] == pytest.approx(0.25 * np.add.outer(np.arange(3), gauss).ravel())
    assert len(x) > 12  # the other end is free


@pytest.mark.parametrize("size", [0.2, 0.5, 2.0])
def test_a_straight_axis_between_two_points_on_a_round_obstacle_is_not_inside(size):
    """Its depth below both is that of a chord, d^2 / (8 (R + r))."""
    for n in (4, 10, 40):
        x = positions(contact_with(ancf.Ball((0.5, -2.0), size), n, start=True, end=True))
        assert (np.diff(x) ** 2 / (8.0 * (size + RADIUS))).max() < 0.31 * RADIUS


def test_short_elements_have_three_points():
    contact = contact_with(ancf.Drum((0.5, 0), 0.3), 25)
    assert len(contact.points) == 75


@pytest.mark.parametrize("n", [4, 5, 9])
def test_a_coarse_cable_that_falls_on_a_drum_does_not_enter_it(n):
    """With three points on each element parts of it between them sink in by .74 radii."""
    size = 0.2
    deepest = 0.0
    for offset in (0.0, 0.04, 0.1):
        scene = ancf.Scene((0.0, -9.81))
        ends = (offset - 0.5, size + 0.05), (offset + 0.5, size + 0.05)
        cable = scene.add_beam("thin", *ends, n, SECTION, MATERIAL)
        scene.contact(cable, ancf.Drum((0, 0), size))
        run = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.EnergyMomentum())
        for s in np.linspace(0.0, 1.0, 16 * n + 1):
            distance = np.linalg.norm(run.position(cable.at(s)), axis=1) - size
            deepest = max(deepest, 1.0 - distance.min() / RADIUS)
    assert 0.0 < deepest < 0.3
