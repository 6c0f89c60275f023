"""Slides along an axis of space beside the ground hold coordinates, and no motion depends on it."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import SingularSceneError
from ancfsparse.system import System

G = 9.81


def crank_drive(angle):
    """Return an elastic rod that pushes a slider uphill, the scene turned by an angle."""
    c, s = math.cos(angle), math.sin(angle)
    turn = np.array([[c, -s], [s, c]])
    scene = ancf.Scene(tuple(turn @ (1.0, -G)))
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    rod = scene.add_beam("thin", turn @ (0, 0.5), turn @ (1, 0), 4, section, material)
    slider = scene.add_body(
        mass=0.5, inertia=1e-3, centre=(0.1, 0.05), position=turn @ (1, 0), orientation=angle
    )
    scene.pin(rod.start)
    scene.connect(rod.end, slider.origin)
    slide = scene.prismatic(slider.origin, axis=turn @ (1, 0))
    return scene, rod, slide, turn


def test_a_coordinate_is_held_where_the_axis_is_one_of_space():
    scene, rod, slide, _ = crank_drive(0.0)
    assert System(scene).n_multipliers == 0
    skew, same_rod, same_slide, turn = crank_drive(0.3)
    assert System(skew).n_multipliers == 1
    runs = [ancf.simulate(each, 0.5, 1e-3, tolerance=1e-9) for each in (scene, skew)]
    np.testing.assert_allclose(
        runs[0].position(rod.end) @ turn.T, runs[1].position(same_rod.end), rtol=0, atol=1e-9
    )
    one, other = (run.joint_force(j) for run, j in zip(runs, (slide, same_slide), strict=True))
    size = np.abs(other.force).max()
    np.testing.assert_allclose(one.force @ turn.T, other.force, rtol=0, atol=1e-6 * size)
    np.testing.assert_allclose(one.moment, other.moment, rtol=0, atol=1e-6 * size)


@pytest.mark.parametrize("name", ["prismatic", "cylindrical"])
@pytest.mark.parametrize("axis", np.eye(3).tolist())
def test_slides_in_space_along_its_axes_hold_coordinates(name, axis):
    """A cylindrical joint leaves two vectors, and three equations of six that keep them rigid."""
    scene = ancf.Scene((0.0, 0.0, -G))
    body = scene.add_body(ancf.Box(length=0.5, width=0.2, height=0.3), mass=2.0, position=(0, 0, 0))
    getattr(scene, name)(body.origin, axis=axis)
    system = System(scene)
    moving = system.n_free - system.n_multipliers
    assert moving == (1 if name == "prismatic" else 2)
    assert not any("across" in label for label in system.constraints.labels)
    assert system.n_free == 1 + (6 if name == "cylindrical" else 0)


@pytest.mark.parametrize("x", [0.0, 0.4])
def test_what_repeats_a_slide_is_named(x):
    scene = ancf.Scene((3.0, -G))
    door = scene.add_body(ancf.Box(length=1.0, width=0.1, height=0.2), mass=1.0, position=(0, 0))
    scene.prismatic(door.origin, axis=(1, 0))
    scene.prismatic(door.at((x, 0.0)), axis=(1, 0))
    with pytest.warns(ancf.RedundantConstraintsWarning, match="follows from the prismatic joint"):
        run = ancf.simulate(scene, 0.1, 0.01)
    assert run.position(door.origin)[-1] == pytest.approx([0.015, 0.0], abs=1e-12)


def test_a_slide_of_what_is_pinned_is_refused():
    scene = ancf.Scene((0.0, -G))
    one, other = (
        scene.add_body(ancf.Box(length=1.0, width=0.1, height=0.2), mass=1.0, position=(0, y))
        for y in (0.0, 1.0)
    )
    scene.pin(one.origin)
    scene.pin(other.origin)
    scene.prismatic(one.origin, axis=(1, 0))
    with pytest.raises(SingularSceneError, match="across 1 constrains no free coordinate"):
        ancf.simulate(scene, 0.1, 0.01)
