"""Contacts that cannot be computed are refused in one sentence, with the remedy in numbers."""

import itertools
import math
import re

import numpy as np
import pytest

import ancfsparse as ancf

RADIUS = 0.005
SECTION, MATERIAL = ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 5e3)
FLOOR = ancf.HalfSpace((0.0, 0.0), (0.0, 1.0))
MASS = MATERIAL.density * 0.25 * math.pi * SECTION.diameter**2  # per length
CORNERS = np.array([(x, y, z) for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
SIDES = np.array([
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
])  # fmt: skip


def cable(height=0.02, n=10):
    scene = ancf.Scene((0.0, -9.81))
    return scene, scene.add_beam("thin", (0.0, height), (1.0, height), n, SECTION, MATERIAL)


def onto_floor(stiffness, friction=None):
    scene, rod = cable(0.008)
    scene.contact(rod, FLOOR, stiffness=stiffness, **(friction or {}))
    return scene


def onto_cable(stiffness):
    scene, rod = cable(0.03)
    other = scene.add_beam("thin", (0.0, 0.012), (1.0, 0.012), 10, SECTION, MATERIAL)
    scene.contact(rod, other, stiffness=stiffness)
    return scene


@pytest.mark.parametrize(("build", "lines"), [(onto_floor, 1), (onto_cable, 2)])
@pytest.mark.parametrize("integrator", [ancf.CentralDifference(), ancf.DormandPrince()])
def test_an_explicit_step_that_does_not_resolve_the_stiffness(build, lines, integrator):
    """The limit is that of a mass on a spring: 2 / omega for central differences."""
    stiffness, phase = 1e11, integrator.tableau.interval
    assert phase == 2.0 or isinstance(integrator, ancf.DormandPrince)
    longest = phase / math.sqrt(lines * stiffness / MASS)
    with pytest.raises(ancf.InputError, match="does not resolve the contact of beam 0") as refusal:
        ancf.simulate(build(stiffness), 1e-4, 2e-5, integrator=integrator)
    number = float(re.search("at most (.*) s; take", str(refusal.value)).group(1))
    assert number == pytest.approx(longest, rel=0.01)
    n = math.ceil(1e-4 / number) + 1
    assert ancf.simulate(build(stiffness), 1e-4, 1e-4 / n, integrator=integrator).finished
    assert ancf.simulate(build(stiffness), 1e-4, 1e-5).finished  # implicit


@pytest.mark.parametrize(("build", "lines"), [(onto_floor, 1), (onto_cable, 2)])
def test_an_implicit_run_that_fails_states_the_step_that_resolves_the_contact(build, lines):
    """A sixth of an impact, pi sqrt(mass / (lines k)); shorter steps get no such advice."""
    stiffness = 1e9
    longest = math.pi / math.sqrt(lines * stiffness / MASS) / 6.0
    for dt, is_long in ((1e-3, True), (0.9 * longest, False)):
        scene, calls = build(stiffness), itertools.count()

        def alternate(x, v, t, calls=calls):
            return np.full((1, 2), 1e3 * (-1.0) ** next(calls))

        scene.force([scene.beams[0].end], alternate)  # steps with this force do not converge
        with pytest.raises(ancf.StepError) as failure:
            ancf.simulate(scene, 10 * dt, dt, max_halvings=0)
        found = re.search("a dt of at most (.*) s, which resolves the impacts", str(failure.value))
        assert bool(found) == is_long
        if found:
            assert float(found[1]) == pytest.approx(longest, rel=0.05)


@pytest.mark.parametrize(
    ("make", "sentence"),
    [
        (lambda: ancf.Ball((0, 0), 0.0), "radius of a ball must be positive, got 0 m"),
        (lambda: ancf.Drum((0, 0), -0.1), "radius of a drum must be positive"),
        (lambda: ancf.Block((0, 0), (0.1, 0.0)), "length of a block must be positive"),
        (lambda: ancf.Capsule((0, 0), (0, 0), 0.1), "a capsule has zero length"),
        (lambda: ancf.Torus((0, 0), 0.05, 0.1), "which leaves no hole"),
        (lambda: ancf.HalfSpace((0, 0), (0, 0)), "must have a direction"),
        (lambda: ancf.HeightField((0, 0), [0.0, 1.0], 0.0), "spacing of a height field must be"),
        (lambda: ancf.TriangleMesh((0, 0, 0), CORNERS, SIDES[:-1]), "a mesh has a hole: 3 of"),
        (
            lambda: ancf.TriangleMesh((0, 0, 0), CORNERS, np.vstack([SIDES, [(1, 1, 3)]])),
            r"triangle 12 \(1, 1, 3\) of a mesh has one vertex twice: leave it out",
        ),
        (lambda: ancf.TriangleMesh((0, 0, 0), CORNERS, SIDES[:, ::-1]), "inside out: its volume"),
        (
            lambda: ancf.TriangleMesh((0, 0, 0), CORNERS * (1, 1, 0), SIDES),
            "a mesh of 1 m has no volume",
        ),
        (lambda: ancf.TriangleMesh((0, 0, 0), 0.0 * CORNERS, SIDES), "has no volume"),
        (
            lambda: ancf.TriangleMesh((0, 0, 0), CORNERS * (1, 1, 0.01), SIDES),
            "a cell of 0.015625 m rounds off a mesh whose smallest side is 0.01 m",
        ),
    ],
)
def test_shapes_without_size_or_inside_out(make, sentence):
    with pytest.raises(ancf.InputError, match=sentence):
        make()


@pytest.mark.parametrize("reversed_ones", [[0], [11], [4, 5], [2, 7, 9]])
def test_triangles_with_another_orientation_are_named_one_after_the_other(reversed_ones):
    sides = SIDES.copy()
    sides[reversed_ones] = sides[reversed_ones, ::-1]
    named = []
    for _ in reversed_ones:
        with pytest.raises(ancf.InputError, match="has another orientation than its") as refusal:
            ancf.TriangleMesh((0, 0, 0), CORNERS, sides)
        message = str(refusal.value)
        wrong, right = (int(k) for k in re.findall(r"triangle (\d+)", message))
        assert f"triangle {wrong} {tuple(sides[wrong].tolist())} of a mesh" in message
        assert len(set(sides[wrong]) & set(sides[right])) == 2  # they are neighbours
        sides[wrong] = sides[wrong, ::-1]
        named.append(wrong)
    assert sorted(named) == reversed_ones
    ancf.TriangleMesh((0, 0, 0), CORNERS, sides)


def test_elements_that_are_too_long_for_a_shape():
    """A quarter of the circumference at the axis: pi (0.02 + 0.005) / 2 m, of 0.1 m elements."""
    ball = ancf.Ball((0.5, -0.1), 0.02)
    scene, rod = cable(n=10)
    needed = 10 * math.ceil(0.1 / (0.5 * math.pi * 0.025))
    with pytest.raises(ancf.InputError, match=rf"at least 3 times as many elements, {needed}$"):
        scene.contact(rod, ball)
    scene, rod = cable(n=needed)
    scene.contact(rod, ball)


def test_friction_without_a_normal_force():
    scene, rod = cable()
    for stiffness in (0.0, -1.0):
        with pytest.raises(ancf.InputError, match=r"stiffness of the contact .* must be positive"):
            scene.contact(rod, FLOOR, stiffness=stiffness, friction=0.3)
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0.0, 0.1), (1.0, 0.1), 4, SECTION, MATERIAL)
    scene.contact(rod, FLOOR, friction=0.3)
    with pytest.raises(ancf.InputError, match=r"stiffness of the contact .* is needed"):
        ancf.simulate(scene, 0.01, 1e-3)


def test_a_slip_speed_without_friction():
    scene, rod = cable()
    for other in (FLOOR, rod):
        with pytest.raises(
            ancf.InputError,
            match=r"slip_speed of the contact of beam 0 of 0.1 m/s is for friction, and this "
            r"contact has none: give it friction=, or leave slip_speed out",
        ):
            scene.contact(rod, other, slip_speed=0.1)
    scene.contact(rod, FLOOR, friction=0.1, slip_speed=0.1)
