"""Numbers out of range, fractions and missing arguments of gears, winches, drives and friction."""

from fractions import Fraction

import numpy as np
import pytest

import ancfsparse as ancf

Z = (0.0, 0.0, 1.0)


def wheels():
    """Two wheels on hinges, and a beam whose end a rope can lead to."""
    scene = ancf.Scene((0.0, -9.81, 0.0))
    hinges = [
        scene.revolute(
            scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(x, 0, 0)).origin, axis=Z
        )
        for x in range(2)
    ]
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    rod = scene.add_beam("thin", (0, 2, 0), (1, 2, 0), 2, section, material)
    scene.clamp(rod.start)
    return scene, *hinges, rod


def ball(scene):
    return scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(3, 0, 0))


@pytest.mark.parametrize("ratio", [1e300, -1e300, 1e-300])
def test_a_gear_whose_squares_leave_the_range_of_numbers_is_refused(ratio):
    scene, one, other, _ = wheels()
    with pytest.raises(ancf.InputError, match=r"ratio of a gear.*1e-100 and"):
        scene.gear(one, other, ratio)


def test_radii_lengths_and_angles_may_be_fractions():
    scene, hinge, other, rod = wheels()
    scene.winch([(0, 3, 0), rod.end], drum=hinge, radius=Fraction(1, 3))
    scene.drive_joint(other, Fraction(0, 3))
    scene.winch([(1, 2 + Fraction(1, 3), 0), rod.end], length=Fraction(1, 3))
    assert ancf.simulate(scene, 2e-3, 1e-3).finished


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda s, hinge, rod: s.winch([(0, 3, 0), rod.end], drum=hinge, radius=1e300),
         r"radius of a drum.*1e-100 and"),
        (lambda s, hinge, rod: s.winch([(0, 3, 0), rod.end], length=1e300), "1e\\+100 m at t = 0"),
        (lambda s, hinge, rod: s.distance(rod.end, ball(s).origin, length=lambda t: 1e300),
         r"distance of.* at most 1e\+100 m at t = 0, got 1e\+300 m"),
        (lambda s, hinge, rod: s.joint_friction(hinge, 0.1, slip=None), "slip of the friction"),
        (lambda s, hinge, rod: s.replaced(rod, n_elements=np.zeros((2, 2))), "n_elements"),
    ],
)  # fmt: skip
def test_numbers_that_are_none_or_out_of_range_are_refused(change, message):
    scene, hinge, _, rod = wheels()
    with pytest.raises(ancf.InputError, match=message):
        change(scene, hinge, rod)


def test_a_distance_that_no_assembly_reaches_is_named_and_does_not_overflow():
    scene, _, _, rod = wheels()
    scene.distance(rod.end, ball(scene).origin, length=9e99)
    with pytest.raises(ancf.AssemblyError, match="stays violated"):
        ancf.assemble(scene)


@pytest.mark.parametrize("rope", ["winch", "rope"])
def test_a_rope_over_a_body_asks_for_one_of_its_points(rope):
    scene, _, _, rod = wheels()
    box = scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(0, 1, 0), name="box")
    for whole, called in ((box, "box"), (rod, rod.name)):
        points = [(0, 3, 0), whole]
        with pytest.raises(
            ancf.InputError, match=rf"point 1 of a {rope} .*, got {called}: .* hook\.at\(\.\.\.\)"
        ):
            scene.rope(points, stiffness=1.0) if rope == "rope" else scene.winch(points)


@pytest.mark.parametrize("kind", [np.float16, np.float32])
def test_lengths_of_ropes_with_few_digits_are_saved_as_they_are(kind, tmp_path):
    scene, _, _, rod = wheels()
    scene.rope([(0, 3, 0), rod.end], length=kind(0.1), stiffness=1e4)
    scene.save(tmp_path / "scene.json")
    assert ancf.Scene.load(tmp_path / "scene.json").digest() == scene.digest()
