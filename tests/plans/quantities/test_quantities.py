"""Quantities against what a run gives, and what is refused."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.quantities.tolerances import check_goals, check_quantities
from ancfsparse.plans.trial_runs.trial_runs import as_trajectory
from ancfsparse.problems import pendulum
from tests.beams import build_beam


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
    steel = ancf.Material(1e11, 1000)

    def spin(r):
        return np.stack([-20.0 * r[:, 1], 20.0 * r[:, 0]], axis=1)

    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), 2, ancf.Circle(0.1), steel, "pin", gravity=(0.0, 0.0), velocity=spin
    )
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
    (each,) = check_goals(check_quantities(quantity, scene), "1 %")
    moved = np.linalg.norm(run.position(rod.end) - run.position(rod.end)[0], axis=1).max()
    assert each.tolerance(quantity.history(run)) == pytest.approx(0.01 * moved)
    (absolute,) = check_goals((quantity,), 2e-3)
    assert absolute.tolerance(quantity.history(run)) == 2e-3


def test_bad_input_gets_a_sentence(motion):
    scene, rod, _ = motion
    other = pendulum("thin", 6).rod
    for make, words in (
        (lambda: ancf.position("tip"), "a position needs a point"),
        (lambda: ancf.position(rod.end, at="middle"), "unknown at of a quantity"),
        (lambda: ancf.section_force(rod.end, "P"), "unknown part of a section force"),
        (lambda: ancf.energy("heat"), "unknown part of the energy"),
        (lambda: check_quantities(ancf.position(other.end), scene), "belongs to another scene"),
        (lambda: check_quantities(ancf.reaction(rod.end), scene), "no joint holds that point"),
        (lambda: check_quantities("position", scene), "quantity must be"),
        (lambda: check_quantities([], scene), "quantity is empty"),
        (lambda: check_goals((ancf.position(rod.end),), "1"), "relative error must be a string"),
        (lambda: check_goals((ancf.position(rod.end),), "x %"), "relative error must be a string"),
        (lambda: check_goals((ancf.position(rod.end),), -1.0), "must be positive"),
        (lambda: check_goals((ancf.position(rod.end),), None), "needs an error"),
        (lambda: check_goals((ancf.position(rod.end),), [1.0, 2.0]), "2 entries for 1"),
    ):
        with pytest.raises(ancf.InputError, match=words):
            make()


SHEARED = {"curvature": "section", "section_strain": "nodal"}


def loaded(element, n, gravity=-9.81, **options):
    scene = ancf.Scene((0.0, gravity))
    made = ancf.Rectangle(0.05, 0.05), ancf.Material(2e8, 1000.0, 0.3)
    rod = scene.add_beam(element, (0, 0), (1, 0), n, *made, **options)
    scene.clamp(rod.start)
    return scene, rod


@pytest.mark.parametrize(("element", "options", "own"), [("thin", {}, 4), ("thick", SHEARED, 2)])
@pytest.mark.parametrize("part", ["M", "Q", "N"])
def test_forces_in_sections_converge_as_plans_take_them_to(element, options, own, part):
    """The largest error along a cantilever under its weight, to 8 times as many elements."""

    def along(n):
        scene, rod = loaded(element, n, **options)
        scene.point_force(rod.end, (1.0, 0.5))
        run = as_trajectory(ancf.solve_static(scene))
        forces = (ancf.section_force(rod.at(s), part) for s in np.linspace(0.03, 0.97, 48))
        return np.array([each.history(run)[0, 0] for each in forces])

    fine = along(256)
    coarse, finer = (np.abs(along(n) - fine).max() for n in (4, 32))
    known = ancf.section_force(loaded(element, 4, **options)[1].end, part).order(own)
    assert np.log2(coarse / finer) / 3.0 == pytest.approx(known, abs=0.3)


@pytest.mark.parametrize(("element", "options", "own"), [("thin", {}, 4), ("thick", SHEARED, 2)])
def test_reactions_converge_as_positions_do(element, options, own):
    def held(n):
        scene, rod = loaded(element, n, 0.0, **options)
        scene.point_force(rod.end, lambda t: (0.0, 10.0 * np.sin(4.0 * t) ** 4))
        run = ancf.simulate(scene, 0.6, 1e-3)
        return ancf.reaction(rod.start).history(run), ancf.reaction(rod.start).order(own)

    fine, order = held(32)
    coarse, finer = (np.abs(held(n)[0] - fine).max() for n in (4, 8))
    assert order == own
    assert np.log2(coarse / finer) >= 0.9 * own


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(
    "make",
    [
        lambda rod: ancf.position(rod.end),
        lambda rod: ancf.velocity(rod.at(0.5), at="largest"),
        lambda rod: ancf.slope_angle(rod.end, at="end"),
        lambda rod: ancf.strain(rod.at(0.5)),
        lambda rod: ancf.reaction(rod.start),
        lambda rod: ancf.section_force(rod.at(0.5), "N"),
        lambda rod: ancf.section_force(rod.at(0.5), "M"),
    ],
)
def test_rounding_of_a_beam_at_rest_has_no_relative_error(make, dim):
    """Alone, and beside a beam that falls."""
    material, end = ancf.Material(1e8, 4000.0), np.array([1.0, 0.7, 0.2])[:dim]
    for falls in (False, True):
        scene = ancf.Scene(gravity=np.zeros(dim))
        rod = scene.add_beam("auto", 0.0 * end, end, "auto", ancf.Rectangle(0.01, 0.01), material)
        scene.pin(rod.start)
        goals, errors = [make(rod)], ["1 %"]
        if falls:
            other = scene.add_beam(
                "thin", 2.0 * end, 3.0 * end, 4, ancf.Rectangle(0.01, 0.01), material
            )
            scene.point_force(other.end, 0.1 * end)
            goals, errors = [ancf.position(other.end), *goals], ["1 %", *errors]
        with pytest.raises(ancf.InputError, match="does not change by more than rounding, "):
            ancf.plan(scene, 0.3, goals, errors)
