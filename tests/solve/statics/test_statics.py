"""Static equilibrium against published and independently computed shapes."""

import math
import tomllib

import numpy as np
import pytest
from scipy.optimize import brentq
from scipy.special import ellipe, ellipeinc, ellipk, ellipkinc

import ancfsparse as ancf
from ancfsparse.errors import SingularSceneError
from ancfsparse.problems import cantilever, elastica, roll_up
from ancfsparse.system import System
from tests.beams import build_beam
from tests.matrices import stiffness
from tests.paths import REFERENCES

REFERENCES = tomllib.loads((REFERENCES / "statics.toml").read_text(encoding="utf-8"))
ELEMENTS = {"biot": ("thin", {"strain": "biot"}), "green": ("thin", {}), "l2t2": ("l2t2", {})}


def tip_displacement(problem, **options):
    """Shortening and deflection of the tip; loads point down."""
    scene, rod = problem
    moved = ancf.solve_static(scene, **options).displacement(rod.end)
    return -moved[:2]


@pytest.mark.parametrize("n", [1, 4, 8])
@pytest.mark.parametrize("name", ELEMENTS)
def test_cantilever_digit_for_digit(name, n):
    element, options = ELEMENTS[name]
    table = REFERENCES["cantilever"]
    found = tip_displacement(cantilever(element, n, **options))
    np.testing.assert_allclose(found, table[name][str(n)], rtol=0, atol=table["tolerance"])


@pytest.mark.parametrize("name", ELEMENTS)
def test_cantilever_tends_to_its_limit(name):
    element, options = ELEMENTS[name]
    table = REFERENCES["cantilever"]
    errors = [
        np.abs(tip_displacement(cantilever(element, n, **options)) - table[name]["limit"]).max()
        for n in (4, 8, 32)
    ]
    assert errors[0] > errors[1] > errors[2]
    assert errors[2] < table["mesh_tolerance"]


@pytest.mark.parametrize("strain", ["green", "biot"])
def test_a_spatial_cable_bends_like_a_planar_one(strain):
    planar = tip_displacement(cantilever("thin", 4, strain=strain))
    scene, rod = cantilever("thin", 4, dim=3, strain=strain)
    equilibrium = ancf.solve_static(scene)
    moved = equilibrium.displacement(rod.end)
    np.testing.assert_allclose(-moved[:2], planar, rtol=0, atol=1e-9)
    assert abs(moved[2]) < 1e-12


def test_the_number_of_load_steps_does_not_matter():
    found = [tip_displacement(cantilever("thin", 4), load_steps=k) for k in (3, 10, 40)]
    np.testing.assert_allclose(found[1:], [found[0]] * 2, rtol=0, atol=1e-11)


def test_a_slender_beam_is_bent_by_its_whole_load_at_once():
    # It stretches far along the first, linear correction: a tangent with that stress is lost.
    scene, rod = elastica(10.0, "thin", 16, slenderness=1e4)
    equilibrium = ancf.solve_static(scene)
    fine = ancf.solve_static(scene, load_steps=80)
    ends = equilibrium.position(rod.end), fine.position(rod.end)
    np.testing.assert_allclose(*ends, rtol=0, atol=1e-9)
    assert equilibrium.stats.steps == 1
    assert equilibrium.stats.factorizations <= 25
    assert fine.stats.steps == 80


def test_an_oblique_cantilever_is_the_same_one_turned():
    # The clamp is then an equation with a multiplier, not a number.
    scene, rod = cantilever("thin", 4)
    straight = ancf.solve_static(scene).displacement(rod.end)
    c, s = np.cos(0.7), np.sin(0.7)
    turn = np.array([[c, -s], [s, c]])
    turned = ancf.Scene((0.0, 0.0))
    beam = turned.add_beam("thin", (0, 0), turn @ (2.0, 0.0), 4, rod.section, rod.material)
    turned.clamp(beam.start)
    turned.point_force(beam.end, turn @ scene.loads[0].at(0.0))
    equilibrium = ancf.solve_static(turned)
    assert equilibrium.lam.shape == (1,)
    np.testing.assert_allclose(equilibrium.displacement(beam.end), turn @ straight, atol=1e-9)


@pytest.mark.parametrize("load", [1, 3, 10])
def test_elastica_table_is_eulers(load):
    # With k^2 = (1 + sin tip angle) / 2 and sin t = 1 / (k sqrt 2): sqrt(load) = K(k) - F(t, k).
    def root(square):
        t = np.arcsin(1 / np.sqrt(2 * square))
        return ellipk(square) - ellipkinc(t, square) - np.sqrt(load)

    square = brentq(root, 0.5 + 1e-12, 1 - 1e-12, xtol=1e-15)
    t = np.arcsin(1 / np.sqrt(2 * square))
    shortening = 1 - 2 * np.sqrt(square / load) * np.cos(t)
    deflection = 1 - 2 * (ellipe(square) - ellipeinc(t, square)) / np.sqrt(load)
    table = REFERENCES["elastica"]
    np.testing.assert_allclose([shortening, deflection], table[str(load)], atol=table["tolerance"])


@pytest.mark.parametrize("load", [1, 3, 10])
@pytest.mark.parametrize("name", ELEMENTS)
def test_elastica(name, load):
    element, options = ELEMENTS[name]
    slenderness = 1e3
    found = tip_displacement(elastica(load, element, 32, slenderness=slenderness, **options))
    # The beam stretches by up to load / slenderness^2; the rest is mesh.
    tolerance = 2 * load / slenderness**2 + 2e-6
    np.testing.assert_allclose(found, REFERENCES["elastica"][str(load)], rtol=0, atol=tolerance)


def circle(name, rod):
    """Stretch and rate of turn of a beam bent by a moment into a circle, by hand.

    With r' = stretch (cos phi s, sin phi s) the energy per length is 1/2 E A e^2 + 1/2 E I k^2 with
    e, k = (stretch^2 - 1) / 2, phi / stretch (green); stretch - 1, phi (biot);
    (stretch^2 - 1) / 2, stretch phi (l2t2), less M phi.  It is stationary in both.
    """
    p = rod.parameters()
    moment = 2 * math.pi * p["bending_stiffness"] / rod.length
    ratio = moment**2 / (p["axial_stiffness"] * p["bending_stiffness"])
    if name == "biot":
        stretch, curvature = 1.0, 1.0
    elif name == "green":
        stretch = math.sqrt(1 + 2 * ratio)
        curvature = stretch**2
    else:  # stretch^4 (1 - stretch^2) = 2 ratio, the root near 1
        square = max(np.roots([-1, 1, 0, -2 * ratio]).real)
        stretch, curvature = math.sqrt(square), 1 / square
    return stretch, curvature * moment / p["bending_stiffness"]


@pytest.mark.parametrize("name", ELEMENTS)
def test_roll_up_tends_to_its_circle(name):
    element, options = ELEMENTS[name]
    errors = []
    for n in (8, 16, 32):
        scene, rod = roll_up(element, n, **options)
        stretch, turn = circle(name, rod)
        angle = turn * rod.length
        expected = stretch / turn * np.array([math.sin(angle), 1 - math.cos(angle)])
        equilibrium = ancf.solve_static(scene)
        errors.append(np.abs(equilibrium.position(rod.end) - expected).max())
        middle = equilibrium.slope(rod.node(n // 2))
    assert errors[0] > 8 * errors[1] > 64 * errors[2]  # at least third order
    assert errors[2] < 2e-4
    assert np.linalg.norm(middle) == pytest.approx(stretch, abs=2e-4)
    assert (stretch > 1, stretch < 1) == (name == "green", name == "l2t2")
    if name == "biot":
        np.testing.assert_allclose(expected, 0.0, atol=1e-14)
    elif name == "green":
        np.testing.assert_allclose(expected, [0.0325733, 0.0016848], atol=1e-7)


def test_reaction_balances_the_loads():
    scene, rod = cantilever("thin", 4)
    force = scene.loads[0].at(0.0)
    equilibrium = ancf.solve_static(scene)
    np.testing.assert_allclose(equilibrium.reaction(rod.start), -force, rtol=1e-9, atol=1e-3)
    # With gravity and a distributed force, on a beam between two pins.
    scene = ancf.Scene((1.0, -9.81))
    beam = scene.add_beam("l2t2", (0, 0), (1, 0.5), 6, rod.section, rod.material)
    scene.pin(beam.start)
    scene.pin(beam.end, as_constraint=True)
    scene.distributed_force(beam, (0.0, -1e4))
    scene.point_force(beam.at(0.3), (500.0, -700.0))
    equilibrium = ancf.solve_static(scene)
    weight = rod.section.area * rod.material.density * beam.length * scene.gravity
    load = weight + beam.length * np.array([0.0, -1e4]) + [500.0, -700.0]
    total = equilibrium.reaction(beam.start) + equilibrium.reaction(beam.end)
    np.testing.assert_allclose(total, -load, rtol=1e-9)
    np.testing.assert_allclose(equilibrium.reaction(beam.end), -equilibrium.multipliers, rtol=1e-12)


def test_a_rod_holds_a_cantilever_up():
    scene, rod = cantilever("thin", 4)
    scene.rod(rod.end, (2.0, 1.5))
    equilibrium = ancf.solve_static(scene)
    length = np.linalg.norm(equilibrium.position(rod.end) - [2.0, 1.5])
    assert length == pytest.approx(1.5, abs=1e-12)
    total = equilibrium.reaction(rod.start) + equilibrium.reaction(rod.end)
    np.testing.assert_allclose(total, -scene.loads[0].at(0.0), rtol=1e-8, atol=1e-2)


def test_elastic_energy_is_the_work_of_a_linear_load():
    # Small load: half of force times displacement.
    scene, rod = cantilever("thin", 4, load=1e-4)
    equilibrium = ancf.solve_static(scene)
    work = 0.5 * scene.loads[0].at(0.0) @ equilibrium.displacement(rod.end)
    assert equilibrium.elastic_energy == pytest.approx(work, rel=1e-6)


# The thick beam.


def thick_beam(n, length=1.0, **options):
    """A clamped beam of steel in space."""
    section, material = ancf.Rectangle(0.1, 0.1), ancf.Material(2.1e11, 7850.0, 0.3)
    options["gravity"] = (0.0, 0.0, 0.0)
    return build_beam("thick", (0, 0, 0), (length, 0, 0), n, section, material, "clamp", **options)


def thick_cantilever(n, length=1.0, load=1e-5, **options):
    """Tip deflection over Euler-Bernoulli's, for a load that bends by about 1e-5."""
    scene, rod = thick_beam(n, length, **options)
    stiffness = rod.parameters()["bending_stiffness"]
    scene.point_force(rod.end, (0.0, -load * stiffness / length**2, 0.0))
    moved = ancf.solve_static(scene, load_steps=1).displacement(rod.end)
    return -moved[1] / (load * length / 3)


@pytest.mark.parametrize("n", [1, 2, 4, 8])
def test_thick_bending_tends_to_euler_bernoulli(n):
    table = REFERENCES["thick"]["bending"]
    assert thick_cantilever(n) == pytest.approx(table[str(n)], abs=table["tolerance"])


@pytest.mark.parametrize("n", [4, 16, 64])
def test_thick_bending_with_section_curvature_tends_to_timoshenko(n):
    table = REFERENCES["thick"]["shear"]
    found = thick_cantilever(n, 0.2, curvature="section")
    assert found == pytest.approx(table[str(n)], abs=table["tolerance"])
    k = 10 * 1.3 / (12 + 11 * 0.3)
    limit = 1 + 0.25 * 0.1**2 * 2.6 / (k * 0.2**2)
    assert limit == pytest.approx(table["limit"], abs=table["tolerance"])
    assert abs(found - limit) < 0.3 / n**2


@pytest.mark.parametrize("curvature", ["axis", "section"])
def test_a_planar_thick_beam_bends_like_a_spatial_one(curvature):
    found = []
    for dim in (2, 3):
        scene, rod = cantilever("thick", 4, dim=dim, nu=0.0, curvature=curvature)
        found.append(ancf.solve_static(scene).displacement(rod.end)[:2])
    np.testing.assert_allclose(found[1], found[0], rtol=0, atol=1e-8)


@pytest.mark.parametrize("options", [{}, {"curvature": "section"}, {"section_strain": "nodal"}])
def test_torsion_is_exact_with_one_element(options):
    # The linear problem itself: a couple of forces on the section vectors of the free end.
    scene, rod = thick_beam(1, **options)
    system = System(scene)
    k = stiffness(system, system.q0).toarray()
    f, end = np.zeros(len(k)), system.place(rod.end)
    moment = 3.0
    f[end[6 + 2]], f[end[9 + 1]] = moment / 2, -moment / 2  # on r_y along z, on r_z along -y
    u = np.linalg.solve(k, f)
    twist = moment * rod.length / rod.parameters()["torsion_stiffness"]
    np.testing.assert_allclose([u[end[8]], -u[end[10]]], twist, rtol=1e-10)
    assert np.abs(u[end[:6]]).max() < 1e-12 * abs(twist)


def test_a_twisting_moment_on_a_thick_beam_twists_it():
    scene, rod = thick_beam(1)
    moment = 30.0
    scene.point_moment(rod.end, (moment, 0.0, 0.0))
    equilibrium = ancf.solve_static(scene)
    r_y = equilibrium.q[System(scene).place(rod.end)[6:9]]
    twist = moment * rod.length / rod.parameters()["torsion_stiffness"]
    assert np.arctan2(r_y[2], r_y[1]) == pytest.approx(twist, rel=1e-3)


# What cannot be solved says so.


@pytest.mark.parametrize("element", ["l2t2", "thin", "thick"])
def test_statics_without_joints_names_the_free_motion(element):
    along, down = np.eye(3 if element == "thick" else 2)[:2]
    section, material = ancf.Circle(0.01), ancf.Material(1e8, 4000.0)
    scene, rod = build_beam(element, 0 * along, along, 4, section, material, gravity=-9.81 * down)
    with pytest.raises(SingularSceneError, match=r"not held: .* free, .*translation along"):
        ancf.solve_static(scene)
    scene.pin(rod.start)
    with pytest.raises(SingularSceneError, match=r"rotation about .* of beam 0.*clamp"):
        ancf.buckling(scene)


def test_an_oblique_spatial_cable_on_a_clamp_is_held():
    section, material = ancf.Circle(0.02), ancf.Material(2e9, 4000.0)
    scene, rod = build_beam(
        "thin", (0, 0, 0), (1, 2, 3), 4, section, material, "clamp", gravity=(0.0, 0.0, -9.81)
    )
    equilibrium = ancf.solve_static(scene)
    weight = section.area * material.density * rod.length * 9.81
    np.testing.assert_allclose(equilibrium.reaction(rod.start), [0, 0, weight], atol=1e-6 * weight)


def test_no_equilibrium_is_named_with_its_place(monkeypatch):
    monkeypatch.setattr("ancfsparse.solve.statics.newton_and_relaxation.MAX_FACTORS", 1)
    monkeypatch.setattr("ancfsparse.solve.statics.newton_and_relaxation.MAX_RELAXATION_FACTORS", 1)
    scene, rod = cantilever("thin", 2)
    with pytest.raises(ancf.EquilibriumError) as caught:
        ancf.solve_static(scene)
    with pytest.raises(ancf.EquilibriumError, match="try smaller loads, or take a finer mesh"):
        ancf.plan(scene, quantity=ancf.static_deflection(rod.end), error="1 %")
    failure = caught.value
    assert failure.load_fraction == 1.0
    assert failure.where.startswith(rod.name)
    for part in ("% of the load", "does not come to rest", "reached 0 %", failure.where):
        assert part in str(failure)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"load_steps": 2.5}, "load_steps must be an integer"),
        ({"tolerance": 0.0}, "tolerance must be positive"),
        ({"tolerance": float("nan")}, "tolerance must be finite"),
        ({"tolerance": 1.0}, "tolerance is the largest residual.* from 1e-14 to 0.001, got 1"),
        ({"tolerance": 1e-16}, "tolerance is the largest residual over the loads.*got 1e-16"),
        ({"load_steps": 10**20}, "load_steps must be at most 100000, got 1000"),
        ({"progress": "no"}, "progress must be True or False"),
    ],
)
def test_bad_settings(options, message):
    scene, _ = cantilever("thin", 2)
    with pytest.raises(ancf.InputError, match=message):
        ancf.solve_static(scene, **options)


def test_statics_of_nothing():
    with pytest.raises(ancf.InputError, match="no beam"):
        ancf.solve_static(ancf.Scene())
