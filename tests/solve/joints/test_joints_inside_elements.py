"""Points inside elements are held, joined and driven, by equations."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError

G, SIDE = 9.81, 0.01
MATERIAL = ancf.Material(2e9, 1500.0, 0.0)


def two_spans(element, n, **options):
    """A beam of 2 m on three supports, the middle one inside an element, loaded evenly."""
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam(
        element, (0, 0), (2, 0), n, ancf.Rectangle(SIDE, SIDE), MATERIAL, **options
    )
    scene.pin(rod.start)
    middle = scene.pin(rod.at(1.0))
    roller = scene.add_body(mass=1e-3, inertia=1e-6, position=(2, 0))
    scene.connect(rod.end, roller.origin)
    scene.prismatic(roller.origin, axis=(1, 0))
    scene.distributed_force(rod, (0.0, -1e-3))
    return ancf.solve_static(scene).joint_force(middle)


def test_the_middle_support_of_two_spans_carries_five_quarters():
    """5 w L / 4; a cubic has no jump of its shear force inside, so the order is 3."""
    off = []
    for n in (9, 17, 33):
        found = two_spans("thin", n)
        off.append(found.force.ravel()[1] / 1.25e-3 - 1.0)
        assert abs(float(np.squeeze(found.moment))) < 1e-12
    assert off[2] < 1e-5
    assert np.all(np.diff(np.log2(np.abs(off))) < -2.5)
    # With shear: EI / (k G A L^2) is 4e-5.
    thick = two_spans("thick", 33, curvature="section").force.ravel()[1]
    assert thick == pytest.approx(1.25e-3, rel=3e-4)


def net_of_all(n_elements=5):
    """A cable pinned, connected, tied and roped at points inside its elements."""
    scene = ancf.Scene((0.0, 0.0, -G))
    rod = scene.add_beam(
        "thin", (0, 0, 0), (2, 0, 0), n_elements, ancf.Circle(SIDE), MATERIAL, name="rod"
    )
    pin = scene.pin(rod.at(0.3))
    box = scene.add_body(
        ancf.Box(length=0.1, width=0.1, height=0.1), mass=0.1, position=(1.1, 0, 0)
    )
    scene.connect(rod.at(1.1), box.origin)
    scene.rod(rod.at(1.7), (1.7, 0.5, 0.3))
    bob = scene.add_body(ancf.Sphere(0.05), mass=0.1, position=(1.5, 0, -0.5))
    apart = scene.distance(rod.at(1.5), bob.origin)
    scene.rope([rod.at(0.9), (0.9, 0, 0.5)], stiffness=10.0)
    return scene, rod, box, bob, pin, apart


def test_what_is_held_stays_and_energy_is_kept():
    scene, rod, box, bob, pin, apart = net_of_all()
    run = ancf.simulate(scene, 0.5, 2e-3, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    lengths = {
        0.0: run.position(rod.at(0.3)) - (0.3, 0, 0),
        np.sqrt(0.34): run.position(rod.at(1.7)) - (1.7, 0.5, 0.3),
        1e-300: run.position(rod.at(1.1)) - run.position(box.origin),
        0.5: run.position(rod.at(1.5)) - run.position(bob.origin),
    }
    for length, apart_by in lengths.items():
        np.testing.assert_allclose(np.linalg.norm(apart_by, axis=1), length, rtol=0, atol=1e-12)
    energy = run.energy.total
    assert np.ptp(energy[1:]) < 1e-10 * run.energy.kinetic.max()
    # The bob hangs on nothing else.
    pull = run.joint_force(apart).force
    np.testing.assert_allclose(
        np.cross(pull, run.position(rod.at(1.5)) - run.position(bob.origin)), 0.0, atol=1e-9
    )
    assert np.abs(run.joint_force(pin).moment).max() < 1e-12 * np.abs(pull).max()


@pytest.mark.parametrize("far", [0.0, 1e4])
def test_a_tied_point_far_from_the_origin_keeps_its_digits(far):
    scene = ancf.Scene((0.0, -G))
    rod = scene.add_beam(
        "thin", (far, 0), (far + 1, 0), 3, ancf.Rectangle(SIDE, SIDE), MATERIAL
    )  # fmt: skip
    scene.pin(rod.start)
    scene.rod(rod.at(0.5), (far + 0.5, 0.4))
    run = ancf.simulate(scene, 0.1, 1e-3, tolerance=1e-7)
    length = np.linalg.norm(run.position(rod.at(0.5)) - (far + 0.5, 0.4), axis=1)
    np.testing.assert_allclose(length, 0.4, rtol=0.0, atol=1e-14 + 1e-15 * far)


@pytest.mark.parametrize("integrator", [ancf.CentralDifference(), ancf.DormandPrince()], ids=repr)
def test_explicit_steps_hold_them_too(integrator):
    ends = []
    for method in (integrator, ancf.GeneralizedAlpha(1.0)):
        scene = ancf.Scene((0.0, -G))
        soft = ancf.Material(1e7, 1500.0, 0.0)
        rod = scene.add_beam("thin", (0, 0), (2, 0), 5, ancf.Rectangle(SIDE, SIDE), soft)
        scene.pin(rod.at(0.3))
        scene.rod(rod.at(1.5), (1.5, 0.7))
        run = ancf.simulate(scene, 0.1, 1e-4, integrator=method)
        ends.append(run.position(rod.end)[-1])
    np.testing.assert_allclose(*ends, atol=1e-6)


def test_a_driven_point_follows_and_vibrations_know_it():
    scene = ancf.Scene((0.0, -G))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 5, ancf.Rectangle(SIDE, SIDE), MATERIAL)
    way = ancf.Ramp((0.2, 0.1), 0.5, smooth=True)
    scene.drive(rod.at(0.33), way + (0.33, 0))  # noqa: RUF005
    run = ancf.simulate(scene, 1.0, 1e-3)
    np.testing.assert_allclose(run.position(rod.at(0.33))[-1], (0.53, 0.1), atol=1e-12)
    assert run.energy.drift < 1e-4
    free = ancf.modes(scene, 2).eigenvalues
    assert abs(free[0]) < 1e-6 * free[1]


def test_strings_and_meshes_are_held_inside():
    """A string of 1 m held 0.1 m from where it hangs has its weight on both sides."""
    scene = ancf.Scene((0.0, -G))
    nodes, edges = [(0, 0), (1, 0), (2, 0)], [(0, 1), (1, 2)]
    mesh = scene.add_mesh(nodes, edges, "string", ancf.Circle(SIDE), MATERIAL, n_elements=3)
    joints = [scene.pin(mesh.node(0)), scene.pin(mesh.at(1, 0.5)), scene.pin(mesh.node(2))]
    rest = ancf.solve_static(scene)
    np.testing.assert_allclose(rest.position(mesh.at(1, 0.5)), (1.5, 0.0), atol=1e-10)
    carried = sum(rest.joint_force(each).force.ravel()[1] for each in joints)
    weight = 1500.0 * ancf.Circle(SIDE).area * 2.0 * G
    assert carried == pytest.approx(weight, rel=1e-9)


def test_scenes_with_such_joints_are_refined():
    scene, _, _, bob, *_ = net_of_all()
    fine = scene.refined(2)
    by_hand, *_ = net_of_all(10)
    assert fine == by_hand
    end = ancf.solve_static(fine).position(fine.counterpart(bob.origin))
    np.testing.assert_allclose(end, ancf.solve_static(scene).position(bob.origin), atol=2e-2)


def test_what_they_do_not_have_is_named():
    scene = ancf.Scene((0.0, -G))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 5, ancf.Rectangle(SIDE, SIDE), MATERIAL)
    pin = scene.pin(rod.at(0.33))
    with pytest.raises(InputError, match="has none: take a revolute"):
        scene.drive_joint(pin, 0.0)
    with pytest.raises(InputError, match=r"is constrained twice: the pin at beam 0 at s = 0\.33 m"):
        scene.drive(rod.at(0.33), lambda t: (0.33, t**3))
    run = ancf.simulate(scene, 1e-3, 1e-3)
    with pytest.raises(InputError, match=r"s = 0.33 m .* ask for joint_force of the joint there"):
        run.reaction(rod.at(0.33))
