"""Quantities against what a run gives, and what is refused."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.asking import checked
from ancfsparse.plans.wanted import wanted
from ancfsparse.problems import pendulum


@pytest.fixture(scope="module")
def motion():
    scene, rod = pendulum("thin", 6)
    return scene, rod, ancf.simulate(scene, 0.2, 1e-3)


def test_values_are_those_of_the_run(motion):
    _, rod, run = motion
    for quantity, values in (
        (ancf.position(rod.end), run.position(rod.end)),
        (ancf.velocity(rod.end), run.velocity(rod.end)),
        (ancf.reaction(rod.start), run.reaction(rod.start)),
        (ancf.strain(rod.at(0.4)), run.strain(rod, 0.4)),
        (ancf.section_force(rod.at(0.4), "N"), run.section_force(rod, 0.4).N),
        (ancf.section_force(rod.at(0.4)), run.section_force(rod, 0.4).M),
        (ancf.energy("kinetic"), run.energy.kinetic[:, None]),
    ):
        # Points by handle and by arc length differ by rounding.
        assert np.allclose(quantity.value(run), values, rtol=0.0, atol=1e-12 * np.abs(values).max())


def test_the_slope_angle_is_the_rotation_of_a_rigid_turn():
    scene = ancf.Scene((0.0, 0.0))
    steel = ancf.Material(1e11, 1000)

    def spin(r):
        return np.stack([-20.0 * r[:, 1], 20.0 * r[:, 0]], axis=1)

    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, ancf.Circle(0.1), steel, velocity=spin)
    scene.pin(rod.start)
    run = ancf.simulate(scene, 1.0, 1e-3)
    angle = ancf.slope_angle(rod.end).value(run)[:, 0]
    assert angle[-1] == pytest.approx(20.0, rel=1e-2)
    assert np.diff(angle).min() > 0.0


def test_times_are_chosen(motion):
    _, rod, run = motion
    speeds = np.linalg.norm(run.velocity(rod.end), axis=1)
    assert ancf.velocity(rod.end, at="largest").value(run) == [[speeds.max()]]
    end = ancf.velocity(rod.end, at="end")
    assert np.array_equal(end.value(run), run.velocity(rod.end)[-1:])
    assert "at the end" in repr(end)


def test_relative_errors_refer_to_the_size(motion):
    scene, rod, run = motion
    quantity = ancf.position(rod.end)
    (each,) = wanted(checked(quantity, scene), "1 %")
    moved = np.linalg.norm(run.position(rod.end) - run.position(rod.end)[0], axis=1).max()
    assert each.tolerance(quantity.history(run)) == pytest.approx(0.01 * moved)
    (absolute,) = wanted((quantity,), 2e-3)
    assert absolute.tolerance(quantity.history(run)) == 2e-3


def test_bad_input_gets_a_sentence(motion):
    scene, rod, _ = motion
    other = pendulum("thin", 6).rod
    for make, words in (
        (lambda: ancf.position("tip"), "a position needs a point"),
        (lambda: ancf.position(rod.end, at="middle"), "unknown at of a quantity"),
        (lambda: ancf.section_force(rod.end, "P"), "unknown part of a section force"),
        (lambda: ancf.energy("heat"), "unknown part of the energy"),
        (lambda: checked(ancf.position(other.end), scene), "of another scene"),
        (lambda: checked(ancf.reaction(rod.end), scene), "no joint holds that point"),
        (lambda: checked("position", scene), "quantity must be"),
        (lambda: checked([], scene), "quantity is empty"),
        (lambda: wanted((ancf.position(rod.end),), "1"), "relative error must be a text"),
        (lambda: wanted((ancf.position(rod.end),), "x %"), "relative error must be a text"),
        (lambda: wanted((ancf.position(rod.end),), -1.0), "must be positive"),
        (lambda: wanted((ancf.position(rod.end),), None), "needs an error"),
        (lambda: wanted((ancf.position(rod.end),), [1.0, 2.0]), "2 entries for 1"),
    ):
        with pytest.raises(ancf.InputError, match=words):
            make()
