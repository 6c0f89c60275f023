"""Friction between cables in equilibria and modes, against closed formulas."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import EquilibriumError, SingularSceneError
from ancfsparse.system import System
from tests.matrices import full

RADIUS, STIFFNESS, MU = 0.005, 1e6, 0.3
SECTION = ancf.Circle(2.0 * RADIUS)
MASS_PER_LENGTH = 5e3 * SECTION.area
WEIGHT = 0.6 * MASS_PER_LENGTH * 9.81


def across_rails(modulus=1e10, gravity=9.81, depth=5e-5, mu=MU, law=None):
    """A rod of 0.6 m across two rails 0.4 m apart, away from their nodes."""
    scene, wire = ancf.Scene((0.0, 0.0, -gravity)), ancf.Material(modulus, 5e3)
    rails = [
        scene.add_beam("thin", (-0.5, y, 0), (0.5, y, 0), 10, SECTION, wire) for y in (-0.2, 0.2)
    ]
    for rail in rails:
        scene.clamp(rail.start)
        scene.clamp(rail.end)
    height = 2.0 * RADIUS - depth
    rod = scene.add_beam("thin", (0.013, -0.3, height), (0.013, 0.3, height), 6, SECTION, wire)
    law = law or {"friction": mu}
    contacts = [scene.contact(rail, rod, stiffness=STIFFNESS, **law) for rail in rails]
    return scene, rod, contacts


def grip(depth):
    """Stiffness of the bristles of a right-angled crossing: k/10 over the length of the overlap."""
    return 0.1 * STIFFNESS * 2.0 * np.sqrt(2.0 * (2.0 * RADIUS - depth) * depth)


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_a_rod_across_rails_rests_under_less_than_the_friction(share):
    scene, rod, contacts = across_rails()
    scene.distributed_force(rod, (share * MU * WEIGHT / 0.6, 0.0, 0.0))
    rest = ancf.solve_static(scene)
    assert rest.stable
    for contact, s in zip(contacts, (0.1, 0.5), strict=True):
        force = rest.contact_force(contact)
        assert force.size == pytest.approx(0.5 * WEIGHT, rel=1e-2)  # rails sag, and are inclined
        np.testing.assert_allclose(
            force.force[[0, 2]], (0.5 * share * MU * WEIGHT, -0.5 * WEIGHT), atol=1e-6 * WEIGHT
        )
        way = rest.displacement(rod.at(s))[0]
        expected = 0.5 * share * MU * WEIGHT / grip(force.penetration)
        assert way == pytest.approx(expected, rel=2e-2)
    run = ancf.simulate(scene, 0.02, 1e-3, start=rest, integrator=ancf.GeneralizedAlpha(0.5))
    assert np.abs(run.q - rest.q).max() < 1e-8


def test_a_rod_that_is_pulled_with_more_is_refused():
    scene, rod, _ = across_rails()
    scene.distributed_force(rod, (1.1 * MU * WEIGHT / 0.6, 0.0, 0.0))
    with pytest.raises((EquilibriumError, SingularSceneError)):
        ancf.solve_static(scene)


def test_a_rod_that_is_drawn_to_and_fro_loses_the_work():
    """Friction is mu N against the motion, and N that of a crossing: 4/3 sqrt(2 d) k e^(3/2)."""
    depth, reach = 1e-4, 1e-3
    scene, rod, contacts = across_rails(1e13, 0.0, depth)
    times = [0.0, 1.0, 2.0, 3.0, 4.0]
    for end in (rod.start, rod.end):
        way = np.outer([0.0, reach, -reach, reach, -reach], (1.0, 0.0, 0.0))
        scene.drive(end, ancf.Table(times, (end.position + way).tolist(), smooth=True))
    run = ancf.quasi_static(scene, 4.0, 0.05)
    pull = sum(run.reaction(end)[:, 0] for end in (rod.start, rod.end))
    normal = 4.0 / 3.0 * np.sqrt(2.0 * (2.0 * RADIUS - depth)) * STIFFNESS * depth**1.5
    assert pull.max() == pytest.approx(2.0 * MU * normal, rel=1e-2)
    assert pull[21:].min() == pytest.approx(-2.0 * MU * normal, rel=1e-2)
    for contact in contacts:
        force = run.contact_force(contact)
        assert np.all(force.friction <= MU * force.size * (1.0 + 1e-9))
    energy, loop = run.energy, [40, 80]
    lost = 4.0 * reach * 2.0 * MU * normal
    # Less the way of 10 mu p / k in which the bristles turn over, twice.
    lost -= 4.0 * MU * normal * 2.0 * MU * normal / grip(depth)
    assert np.diff(energy.work[loop]) == pytest.approx(lost, rel=3e-2)


def side_by_side(mu):
    """Two free cables, nearly rigid, along each other with a penetration of 10 um."""
    scene, wire = ancf.Scene((0.0, 0.0, 0.0)), ancf.Material(1e13, 5e3)
    cables = [
        scene.add_beam("thin", (0, 0, z), (1, 0, z), 8, SECTION, wire)
        for z in (0.0, 2.0 * RADIUS - 1e-5)
    ]
    scene.contact(*cables, stiffness=1e4, friction=mu)
    return scene, cables


def test_cables_that_stick_vibrate_along_each_other():
    """Along: sqrt(2 k_t / mu) with k_t = k/10; across: k_t less the force over the distance F/d."""
    scene, _ = side_by_side(0.3)
    modes = ancf.modes(scene, 10)
    assert np.all(modes.growth == 0.0)
    push = 1e4 * 1e-5 / (2.0 * RADIUS - 1e-5)
    for stiffness in (1e3, 1e3 - push, 1e4):
        expected = np.sqrt(2.0 * stiffness / MASS_PER_LENGTH) / (2.0 * np.pi)
        assert np.isclose(modes.frequencies, expected, rtol=1e-6).any()
    free = ancf.modes(side_by_side(0.0)[0], 10)
    assert (free.growth > 0.0).sum() == 3  # test_two_free_cables_vibrate_against_each_other


def test_cables_that_slide_are_free_along_each_other():
    """In the saved state of a run bristles are at their limit; across it they do not slide."""
    scene, (_, upper) = side_by_side(0.3)
    scene = scene.replaced(upper, velocity=(0.5, 0.0, 0.0))
    run = ancf.simulate(scene, 2e-3, 1e-5, integrator=ancf.GeneralizedAlpha(0.9))
    sticking = np.sqrt(2e3 / MASS_PER_LENGTH) / (2.0 * np.pi)
    frequencies = ancf.modes(scene, 10, at=run.last).frequencies
    whole = ancf.modes(scene, 10).frequencies
    count = [np.count_nonzero(f > 0.5 * sticking) for f in (frequencies, whole)]
    assert count[0] == count[1] - 1


@pytest.mark.parametrize("way", [1e-5, 1e-3])
def test_the_tangent_of_equilibria_is_the_derivative(way, rng):
    """Where pairs stick without the change of their stiffness, and where they slide."""
    scene, *_ = across_rails(depth=2e-4)
    system = System(scene)
    n, none, rest = system.n_free, np.zeros(0), np.zeros(system.n_all)
    q = system.q0 + 1e-8 * rng.normal(size=system.n_all)
    q[system.vectors("r")[2][:, 0]] += way
    with system.equilibria(system.q0):

        def force(x):
            return system.assembly.residual(x, rest, rest, none, rest, none)[0][:n]

        columns = np.unique(system.vectors("r")[2])
        columns = columns[columns < n]
        expected = (
            np.array(
                [force(q + 1e-8 * e) - force(q - 1e-8 * e) for e in np.eye(system.n_all)[columns]]
            ).T
            / 2e-8
        )
        force(q)
        found = full(system, system.assembly.matrix(0.0, 1.0, q, none, none))[:n, :n]
        found = found + system.coupling_stiffness(q).toarray()
        missing = system.unsymmetric_stiffness(q)
    assert (missing is not None) == (way > 1e-4)
    if missing is not None:
        found = found + missing.toarray()
    # On the rails, away from the elements of the rod: their stiffness is far larger.
    rails = np.unique(np.concatenate(system.vectors("r")[:2]))
    rails = rails[rails < n]
    error = np.abs(found[np.ix_(rails, columns)] - expected[rails])
    assert error.max() < (2e-2 if way > 1e-4 else 0.2) * np.abs(expected[rails]).max()
