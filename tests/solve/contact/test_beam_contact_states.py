"""Modes and equilibria of cables that touch each other, against closed formulas."""

import numpy as np
import pytest

import ancfsparse as ancf

RADIUS, STIFFNESS = 0.005, 1e4  # m, N/m2
SECTION = ancf.Circle(2.0 * RADIUS)
MASS_PER_LENGTH = 5e3 * SECTION.area  # kg/m


def side_by_side(modulus=1e13, stiffness=STIFFNESS):
    """Two cables, nearly rigid, along each other with a penetration of 10 um."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    cables = [
        scene.add_beam("thin", (0, 0, z), (1, 0, z), 8, SECTION, ancf.Material(modulus, 5e3))
        for z in (0.0, 2.0 * RADIUS - 1e-5)
    ]
    scene.contact(*cables, stiffness=stiffness)
    return scene, cables


def test_two_free_cables_vibrate_against_each_other():
    """Both share the spring k per length, as translation and as rotation: sqrt(2 k / mu).

    Across it the force F per length at the distance d pushes them off each other, and motions grow
    with the rate sqrt(2 F / mu d).  When both rotate by an angle a, their pressures rotate with
    them: each is pushed along itself by F a, and their relative displacement u along each other
    rotates them with the moment F u, by which one motion grows and one vibrates.
    """
    scene, _ = side_by_side()
    modes = ancf.modes(scene, 10)
    frequencies = modes.frequencies
    assert np.all(frequencies[:7] < 1e-3)
    force, distance = STIFFNESS * 1e-5, 2.0 * RADIUS - 1e-5
    growth = np.sqrt(2.0 * force / (MASS_PER_LENGTH * distance))
    np.testing.assert_allclose(np.sort(modes.growth)[-2:], growth, rtol=1e-6)
    # Masses mu / 2 and mu / 6, stiffnesses F between u and a, and F d of a.
    couple, own = np.array([np.sqrt(12.0), 3.0 * distance]) * force / MASS_PER_LENGTH
    assert np.sort(modes.growth)[-3] == pytest.approx(
        np.sqrt(np.hypot(couple, own) - own), rel=1e-3
    )
    slow = np.sqrt(np.hypot(couple, own) + own) / (2.0 * np.pi)
    assert frequencies[7] == pytest.approx(slow, rel=1e-3)
    expected = np.sqrt(2.0 * STIFFNESS / MASS_PER_LENGTH) / (2.0 * np.pi)
    np.testing.assert_allclose(frequencies[8:], expected, rtol=1e-6)


def test_a_cable_vibrates_on_one_that_is_held():
    """With multipliers: sqrt(k / mu), less the bending of the lower one, of 176 Hz."""
    scene, (lower, _) = side_by_side()
    for end in (lower.start, lower.end):
        scene.pin(end, as_constraint=True)
    frequencies = ancf.modes(scene, 8).frequencies
    expected = np.sqrt(STIFFNESS / MASS_PER_LENGTH) / (2.0 * np.pi)
    assert np.count_nonzero(np.abs(frequencies / expected - 1.0) < 1e-2) == 2


def crossed(friction=0.0):
    """Two cables, each pinned at its ends, the upper one across the lower."""
    scene, wire = ancf.Scene((0.0, 0.0, -9.81)), ancf.Material(1e8, 5e3)
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 10, SECTION, wire)
    upper = scene.add_beam("thin", (0, -0.5, 0.0099), (0, 0.5, 0.0099), 10, SECTION, wire)
    for cable in (lower, upper):
        scene.pin(cable.start)
        scene.pin(cable.end)
    scene.distributed_force(upper, (0.0, 0.0, -2.0))
    contact = scene.contact(lower, upper, stiffness=1e7, friction=friction)
    return scene, (lower, upper), contact


def test_cables_that_carry_each_other_have_an_equilibrium():
    """Without the stiffness between them no load step converged."""
    scene, (lower, upper), contact = crossed()
    rest = ancf.solve_static(scene)
    assert rest.stable
    assert rest.stats.factorizations <= 10
    between = rest.position(upper.at(0.5))[2] - rest.position(lower.at(0.5))[2]
    forces = rest.contact_force(contact)
    # The largest penetration is at a quadrature point near the middle.
    assert between == pytest.approx(2.0 * RADIUS - forces.penetration, abs=1e-7)
    held = sum(rest.reaction(end)[2] for end in (upper.start, upper.end))
    load = (9.81 * MASS_PER_LENGTH + 2.0) * 1.0
    assert held - forces.force[2] == pytest.approx(load, rel=1e-3)


def test_cables_that_stick_where_nodes_cross_have_an_equilibrium_and_stiffer_modes():
    """Rounding does not decide there which elements touch; bristles add to the stiffness."""
    free, stuck = (
        ancf.modes(ancf.solve_static(crossed(friction)[0]), 6).frequencies
        for friction in (0.0, 0.3)
    )
    assert np.all(stuck > (1.0 - 1e-6) * free)
    assert np.any(stuck > 1.01 * free)


def test_explicit_steps_resolve_the_vibration_against_each_other():
    """Soft cables: sqrt(2 k / mu) is the highest frequency, and sqrt(k / mu) if one is alone."""
    scene, _ = side_by_side(modulus=1e3, stiffness=1e8)
    step = ancf.stable_step(scene, ancf.CentralDifference())
    assert step == pytest.approx(2.0 / np.sqrt(2e8 / MASS_PER_LENGTH), rel=0.1)
