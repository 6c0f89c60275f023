"""Quadrature points of contacts with obstacles: exactness, distances, and free ends."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from ancfsparse.system.contributions.force_elements.penetrations import Penetration

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


def test_elements_that_require_too_many_points_are_refused():
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (0, 0.5), (1, 0.5), 4, SECTION, MATERIAL)
    with pytest.raises(ancf.InputError, match=r"an element of 0.25 m requires \d+ points, more th"):
        scene.contact(cable, ancf.Ball((0.5, 0), 0.3), radius=1e-12)


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


@pytest.mark.parametrize("is_on_body", [False, True])
def test_a_narrow_block_between_two_points_is_reported(is_on_body):
    """The axis is 7.5 mm from its side then; shorter elements touch it."""

    def run(n):
        scene = ancf.Scene((0.0, -9.81))
        cable = scene.add_beam("thin", (-0.5, 0.03), (0.5, 0.03), n, SECTION, MATERIAL)
        on = None
        if is_on_body:
            on = scene.add_body(mass=10.0, inertia=1.0, position=(0.19, -0.3), orientation=0.5)
            scene.pin(on.origin)
        block = ancf.Block((0.19, -0.3), (0.02, 0.6))
        contact = scene.contact(cable, block, stiffness=1e5, on=on)
        path = ancf.simulate(scene, 0.15, 5e-4, integrator=ancf.EnergyMomentum())
        return path.contact_force(contact).pressure.max()

    with pytest.warns(ancf.PenetrationWarning, match="between two points with forces") as caught:
        assert run(4) == 0.0
    assert "0.0075 m inside" in str(caught[0].message)
    assert run(40) > 0.0


@pytest.mark.parametrize("dim", [2, 3])
def test_depths_of_the_axis_are_those_in_the_frame_of_a_body_that_turns(dim):
    scene, z = ancf.Scene((0.0,) * dim), (0.02,) * (dim - 2)
    cable = scene.add_beam("thin", (-0.5, 0.1, *z), (0.5, 0.1, *z), 6, SECTION, MATERIAL)
    spin = {"inertia": 1.0, "angular_velocity": 2.0}
    if dim == 3:
        spin = {"inertia": (1.0, 1.0, 1.0), "angular_velocity": (1.0, -2.0, 1.5)}
    start = np.array((0.1, -0.3, *z))
    body = scene.add_body(mass=1.0, position=start, velocity=(0.2, 0.1, *z), **spin)
    block = ancf.Block((0.15, -0.2, *z), (0.3, 0.4, 0.2)[:dim], radius=0.05)
    scene.contact(cable, block, on=body, stiffness=1e-6)
    run = ancf.simulate(scene, 1.0, 0.05, integrator=ancf.EnergyMomentum(), max_energy_gain=np.inf)
    part = next(each for each in run.system.contributions if each.is_contact)
    origin = run.position(body.origin)
    axes = np.stack([run.position(body.at(unit)) - origin for unit in np.eye(dim)], axis=1)
    x = np.stack([run.position(cable.at(s)) for s in np.linspace(0.0, 1.0, 49)], axis=1)
    for k in range(0, 21, 5):
        local = start + (x[k] - origin[k]) @ axes[k].T
        depths = 1.0 - block.distances(local) / RADIUS
        found, _ = part._axis_depths.deepest(run.q[k : k + 2])
        assert found[0] == pytest.approx(depths.max(), rel=1e-7)


@pytest.mark.parametrize("peak", range(4996, 5105, 9))
def test_an_axis_that_is_inside_between_the_checked_states_is_found(peak):
    """Every hundredth one or so; the axis is inside for 40 of 10 000 states."""
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (-0.5, RADIUS), (0.5, RADIUS), 4, SECTION, MATERIAL)
    scene.contact(cable, ancf.HalfSpace((0.0, 0.0), (0.0, 1.0)))
    system = System(scene)
    part = next(each for each in system.contributions if each.is_contact)
    q = np.tile(system.q0, (10_000, 1))
    depth = 1.02 - 0.02 * ((np.arange(len(q)) - peak) / 20.0) ** 2
    q[:, 1::4] = (1.0 - depth[:, None]) * RADIUS
    touching = Penetration(0.5 * RADIUS, RADIUS, 1e5, "")
    (warning,) = part._axis_depths.warnings(q, touching, lambda row: f"in state {row}")
    assert f"{0.02 * RADIUS:.3g} m inside, in state {peak}" in str(warning)


def test_an_axis_without_any_point_that_may_touch_is_not_inside():
    """A clamp to the obstacle leaves out all points within the large radius."""
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (0.0, 0.0), (0.1, 0.0), 2, SECTION, MATERIAL)
    scene.clamp(cable.start)
    contact = scene.contact(cable, ancf.HalfSpace((0, 0), (0, 1)), radius=1.0, stiffness=1e3)
    run = ancf.simulate(scene, 0.01, 1e-3)
    assert not run.contact_force(contact).pressure.any()
