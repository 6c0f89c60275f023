"""Equilibria of scenes that are hard for Newton: slack, slender, buckled, tiny and huge."""

import io
import math
from contextlib import redirect_stderr

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import chain, roll_up
from ancfsparse.system import System
from tests.beams import build_beam
from tests.solve.statics.equilibria import cable, square_net, unbalanced

SIZES = [1e-9, 1e-6, 1.0, 1e4, 1e9]
SECTION, SOFT = ancf.Circle(0.01), ancf.Material(1e8, 1000.0)


@pytest.mark.parametrize("element", ["thin", "thick"])
@pytest.mark.parametrize("hold", ["pins", "clamp"])
def test_a_scene_bends_alike_at_any_size(hold, element):
    found, counts = [], []
    for size in SIZES:
        material = ancf.Material(1e8 * size, 1000.0)
        scene, rod = build_beam(element, (0, 0), (size, 0), 4, ancf.Circle(size / 50), material)
        if hold == "clamp":
            scene.clamp(rod.start)
        else:
            scene.pin(rod.start)
            scene.pin(rod.end)
        equilibrium = ancf.solve_static(scene)
        node = rod.end if hold == "clamp" else rod.node(2)
        found.append(equilibrium.displacement(node) / size)
        counts.append(equilibrium.stats.factorizations)
        weight = rod.section.area * 1000.0 * 9.81 * size
        total = equilibrium.reaction(rod.start)
        if hold == "pins":
            total = total + equilibrium.reaction(rod.end)
        np.testing.assert_allclose(total / weight, [0.0, 1.0], atol=1e-8)
    assert abs(found[0][1]) > 1e-3
    np.testing.assert_allclose(found, [found[2]] * len(SIZES), rtol=1e-8, atol=1e-10)
    assert len(set(counts)) == 1


def test_a_light_thread_beside_a_heavy_beam_is_solved_as_by_itself():
    # Its forces are some 1e-13 of the loads of the scene.
    def thread(scene):
        section, material = ancf.Circle(1e-6), ancf.Material(1e9, 1000.0)
        rod = scene.add_beam("thin", (5, 0), (6, 0), 8, section, material)
        scene.pin(rod.start)
        scene.pin(rod.end)
        return rod

    alone = ancf.Scene()
    middle = thread(alone).node(4)
    expected = ancf.solve_static(alone).position(middle)
    scene = ancf.Scene()
    beam = scene.add_beam("thin", (0, 0), (2, 0), 4, ancf.Circle(0.3), ancf.Material(2e11, 7850.0))
    scene.clamp(beam.start)
    rod = thread(scene)
    found = ancf.solve_static(scene).position(rod.node(4))
    np.testing.assert_allclose(found, expected, rtol=0, atol=1e-10)


@pytest.mark.parametrize("far", [0.0, 1e3])
@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_where_slopes_alone_can_move_rounding_is_known_too(size, far):
    # Steel and so light that its forces are near their rounding.
    section, material = ancf.Circle(6e-3 * size), ancf.Material(7.5e10 * size, 600.0)
    start = np.array([far, -far]) * size
    scene, rod = build_beam(
        "thick", start, start + np.array([size, 0.0]), 1, section, material, "pin", "pin"
    )
    equilibrium = ancf.solve_static(scene)
    assert equilibrium.stable
    assert equilibrium.stats.factorizations <= 8
    sag = -equilibrium.displacement(rod.at(0.5 * size))[1] / size
    # Ends turn by w L^3 / (24 E I), and a cubic then sags by a quarter of that times L; less for
    # the tension.
    bending = 7.5e10 * np.pi * 6e-3**4 / 64
    expected = 600.0 * 9.81 * np.pi * 6e-3**2 / 4 / (96 * bending)
    assert sag == pytest.approx(expected, rel=0.03)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7])
def test_the_tolerance_bounds_what_is_unbalanced(tolerance):
    scene, _ = cable()
    equilibrium = ancf.solve_static(scene, tolerance=tolerance)
    assert unbalanced(equilibrium) <= tolerance
    fine = ancf.solve_static(scene, tolerance=1e-13)
    assert np.abs(equilibrium.q - fine.q).max() <= tolerance


def test_what_rounding_leaves_is_estimated():
    # So many elements that eps n^4 is not small: the rounding of forces moves the tip.
    tips, errors = [], []
    for n in (50, 5000):
        scene, rod = build_beam("thin", (0, 0), (1, 0), n, SECTION, SOFT, "clamp")
        equilibrium = ancf.solve_static(scene)
        tips.append(equilibrium.position(rod.end))
        errors.append(equilibrium.stats.error)
    assert errors[0] < 1e-9 < np.abs(tips[1] - tips[0]).max() < errors[1] + 1e-6


def test_elements_whose_forces_are_lost_in_rounding_are_too_many():
    scene, _ = build_beam("thin", (0, 0), (5, 0), 50_000, SECTION, SOFT, "clamp")
    with pytest.raises(ancf.EquilibriumError, match="Take fewer elements: their forces round"):
        ancf.solve_static(scene)


# Slack and slender.


@pytest.mark.parametrize("youngs_modulus", [1e6, 1e8, 2e11])
@pytest.mark.parametrize("diameter", [1e-2, 1e-5])
def test_a_cable_with_hardly_any_bending_stiffness_hangs(diameter, youngs_modulus):
    # Sag of a shallow taut cable: y^3 = 3 w L^4 / (64 E A), to second order in its slope.
    section, material = ancf.Circle(diameter), ancf.Material(youngs_modulus, 1000.0)
    scene, rod = build_beam("thin", (0, 0), (1, 0), 20, section, material, "pin", "pin")
    equilibrium = ancf.solve_static(scene)
    assert equilibrium.stable
    assert equilibrium.stats.factorizations <= 25
    if diameter < 1e-3:
        sag = (3 * 1000.0 * 9.81 / (64 * youngs_modulus)) ** (1 / 3)
        assert -equilibrium.position(rod.node(10))[1] == pytest.approx(sag, rel=0.2 * sag + 2e-3)


def test_a_slack_thread_hangs_in_a_catenary():
    # Half the length is a sinh(1 / a), with the ends 2 m apart.
    n = 40
    t = np.linspace(-1, 1, n + 1)
    scene = ancf.Scene()
    nodes = np.stack([t, -0.8 * (1 - t**2)], 1)
    edges = np.stack([np.arange(n), np.arange(1, n + 1)], 1)
    mesh = scene.add_mesh(
        nodes, edges, "thin", ancf.Circle(1e-4), ancf.Material(1e9, 1e3), smooth=30
    )
    scene.pin(mesh.node(0))
    scene.pin(mesh.node(n))
    equilibrium = ancf.solve_static(scene)
    half = 0.5 * mesh.length
    low, high = 0.1, 10.0
    for _ in range(100):
        a = 0.5 * (low + high)
        low, high = (a, high) if a * math.sinh(1 / a) > half else (low, a)
    sag = a * (math.cosh(1 / a) - 1)
    assert -equilibrium.position(mesh.node(n // 2))[1] == pytest.approx(sag, rel=2e-3)
    assert equilibrium.stable


@pytest.mark.parametrize("youngs_modulus", [1e6, 2e11])
@pytest.mark.parametrize("diameter", [2e-2, 2e-4])
def test_a_net_without_tension_hangs(diameter, youngs_modulus):
    scene, middle = square_net(9, youngs_modulus=youngs_modulus, diameter=diameter)
    equilibrium = ancf.solve_static(scene)
    assert equilibrium.stable
    assert unbalanced(equilibrium) < 1e-7  # of steel threads rounding is 3e-8
    assert equilibrium.displacement(middle)[2] < 0.0


def test_the_cost_of_a_net_grows_with_its_factor_alone():
    stats = [ancf.solve_static(square_net(n)[0]).stats for n in (6, 12, 24)]
    factors = [each.factorizations for each in stats]
    assert max(factors) <= 12
    assert max(factors) - min(factors) <= 2
    assert max(each.solves for each in stats) <= 24


@pytest.mark.parametrize("n", [100, 1000, 10_000])
def test_the_cost_of_a_chain_grows_with_its_length_alone(n):
    scene, rod = chain(n)
    scene.pin(rod.end)
    equilibrium = ancf.solve_static(scene)
    assert equilibrium.stable
    assert equilibrium.stats.factorizations <= 25


@pytest.mark.parametrize("turns", [1.0, 2.0])
def test_a_beam_that_rolls_up_is_found_also_where_the_whole_load_is_too_much(turns):
    scene, rod = roll_up("l2t2", 32, turns=turns)
    whole = ancf.solve_static(scene)
    steps = ancf.solve_static(scene, load_steps=40)
    np.testing.assert_allclose(whole.position(rod.end), steps.position(rod.end), rtol=0, atol=1e-8)


def test_progress_is_drawn_where_it_is_asked_for():
    scene, _ = cable()
    for progress, drawn in ((True, True), (False, False)):
        screen = io.StringIO()
        with redirect_stderr(screen):
            ancf.solve_static(scene, progress=progress)
        assert ("factor" in screen.getvalue()) is drawn


def test_a_scene_that_cannot_fit_is_refused_before_it_is_set_up(monkeypatch):
    def never(*_):
        raise AssertionError("set up")

    monkeypatch.setattr(
        "ancfsparse.solve.preparation.memory_estimate.available_memory", lambda: 1e5
    )
    monkeypatch.setattr("ancfsparse.solve.statics.static_equilibrium.System", never)
    monkeypatch.setattr("ancfsparse.solve.stepping.stable_step.System", never)
    scene, _ = chain(1000)
    with pytest.raises(ancf.InputError, match=r"would need about .* GB.*fewer elements"):
        ancf.solve_static(scene)
    with pytest.raises(ancf.InputError, match=r"would need about .* GB.*fewer elements"):
        ancf.stable_step(scene, ancf.CentralDifference())


def test_memory_that_runs_out_is_named(monkeypatch):
    def full(*_):
        raise MemoryError("Unable to allocate 3 MiB")

    monkeypatch.setattr("ancfsparse.solve.statics.static_equilibrium.System", full)
    monkeypatch.setattr("ancfsparse.solve.stepping.stable_step.System", full)
    scene, _ = chain(10)
    expected = r"memory ran out \(Unable to allocate 3 MiB\), although about .* GB"
    with pytest.raises(ancf.InputError, match=expected):
        ancf.solve_static(scene)
    with pytest.raises(ancf.InputError, match=expected):
        ancf.stable_step(scene, ancf.CentralDifference())


def test_no_load_is_in_equilibrium_as_it_is():
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.01), ancf.Material(1e8, 1e3))
    scene.clamp(rod.start)
    equilibrium = ancf.solve_static(scene)
    assert equilibrium.stats.factorizations == 1
    assert (equilibrium.q == System(scene).q0).all()


@pytest.mark.parametrize("anchor", [(1.0, 1.0), (0.3, 1.0)])
def test_rods_and_pins_by_multipliers_hold_their_share_of_the_weight(anchor):
    # An anchor of ones once more: terms of its equation cancel at coordinates of one.
    section, material = ancf.Circle(0.02), ancf.Material(1e9, 1000.0)
    scene, rod = build_beam("thin", (0, 0), (1, 0), 6, section, material)
    scene.pin(rod.start, as_constraint=True)
    scene.rod(rod.end, anchor)
    equilibrium = ancf.solve_static(scene)
    total = equilibrium.reaction(rod.start) + equilibrium.reaction(rod.end)
    np.testing.assert_allclose(total, [0.0, section.area * 1000.0 * 9.81], atol=1e-8)
    length = np.linalg.norm(np.subtract(rod.end.position, anchor))
    hung = np.linalg.norm(equilibrium.position(rod.end) - anchor)
    assert hung == pytest.approx(length, rel=1e-13)
    assert equilibrium.stable


def test_stress_that_is_there_at_the_start_is_let_go():
    # A bent line of straight elements, held at one end alone, becomes straight.
    t = np.linspace(0, np.pi, 21)
    scene = ancf.Scene((0.0, 0.0))
    nodes = np.stack([np.cos(t), np.sin(t)], 1)
    edges = np.stack([np.arange(20), np.arange(1, 21)], 1)
    mesh = scene.add_mesh(nodes, edges, "thin", SECTION, SOFT, smooth=30)
    scene.clamp(mesh.node(0))
    equilibrium = ancf.solve_static(scene)
    before = equilibrium.system.assembly.strain_energy(equilibrium.system.q0)
    assert equilibrium.elastic_energy < 1e-18 * before
    along = equilibrium.position(mesh.node(20)) - nodes[0]
    assert np.linalg.norm(along) == pytest.approx(mesh.length, rel=1e-9)


@pytest.mark.parametrize("begin", [0.0, 0.37])
def test_two_cables_at_a_kept_distance_hang_as_two_that_meet(begin):
    """Its gradients cancel where all coordinates are equal, and were missing from the matrix."""
    material = ancf.Material(1e8, 1e-3)

    def clamped(begin, apart):
        scene, left = build_beam("thin", (begin, 0), (begin + 1, 0), 6, SECTION, material, "clamp")
        meet = begin + 1.0 + apart
        right = scene.add_beam("thin", (meet, 0), (meet + 1, 0), 6, SECTION, material)
        scene.clamp(right.end)
        return scene, left.end, right.start

    scene, *ends = clamped(begin, 0.4)
    scene.distance(*ends)
    for end in ends:
        scene.point_force(end, (0.0, -15.0))
    joined, one, other = clamped(0.0, 0.0)
    joined.connect(one, other)
    joined.point_force(one, (0.0, -30.0))
    found, expected = ancf.solve_static(scene), ancf.solve_static(joined)
    np.testing.assert_allclose(found.displacement(ends[0]), expected.displacement(one), atol=1e-9)


def test_a_modulus_whose_square_overflows_keeps_the_shape_without_stress():
    scene = ancf.Scene((0.0, -9.81))
    beam = scene.add_beam("thin", (0, 0), (1, 0.3), 3, ancf.Circle(0.01), ancf.Material(1e292, 1e3))
    scene.clamp(beam.start)
    equilibrium = ancf.solve_static(scene)
    np.testing.assert_allclose(equilibrium.position(beam.end), (1.0, 0.3), rtol=1e-12)
