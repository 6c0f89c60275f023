"""Joints by multipliers hold what they should, with the forces they should."""

import re
from fractions import Fraction

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.initial_conditions.consistent_accelerations import (
    initial_acceleration,
    initial_jerk,
)
from ancfsparse.solve.initial_conditions.consistent_state import check_constraints, regularize
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from tests.beams import build_beam

NEWTON, TIGHT = ancf.Newton(), 1e-9
WEIGHT = np.array([0.0, -0.8 * 9.81])  # of the paper's pendulum: 4000 kg/m3, 1 cm2, 2 m


def momentum_rate(run):
    """Sum of M a over all positions: the work of the inertia on a translation."""
    places = run.system.places[0][:, : run.system.dim]
    return np.array([run.system.assembly.inertia(a)[places].sum(axis=0) for a in run.a])


def swung(as_constraint, solver=NEWTON):
    scene, rod = pendulum("l2t2", as_constraint=as_constraint)
    run = ancf.simulate(scene, 1.0, 5e-4, solver=solver, tolerance=TIGHT, save_every=20)
    return run, rod


@pytest.fixture(scope="module")
def by_number():
    return swung(as_constraint=False)


@pytest.mark.parametrize(
    "solver",
    [ancf.Newton(), *(ancf.QuasiNewton(u) for u in ("broyden", "davidon", "dfp", "bfgs")),
     ancf.QuasiNewton("broyden", 10)],
    ids=str,
)  # fmt: skip
def test_a_pin_by_constraint_is_a_pin_by_numbering(solver, by_number):
    path, held = by_number
    run, rod = swung(as_constraint=True, solver=solver)
    for s in (0.7, 2.0):
        found, expected = run.position(rod.at(s)), path.position(held.at(s))
        np.testing.assert_allclose(found, expected, rtol=0, atol=1e-8)
    assert np.abs(run.position(rod.start)).max() < 1e-13


def test_the_reaction_is_minus_the_multiplier(by_number):
    # phi = r puts phi_q^T lam = lam on the left side of the equations: on the beam acts -lam.
    path, held = by_number
    run, rod = swung(as_constraint=True)
    assert run.multipliers.shape == (len(run.t), 2)
    reaction = run.reaction(rod.start)
    np.testing.assert_array_equal(reaction, -run.multipliers)
    # The trapezoidal rule keeps rounding in the acceleration of a constraint for ever (numerics
    # 4.1); divided by beta dt^2 it is this large.
    np.testing.assert_allclose(reaction, path.reaction(held.start), rtol=0, atol=1e-4)


def test_the_reaction_moves_the_centre_of_mass(by_number):
    run, rod = by_number
    total = momentum_rate(run)
    np.testing.assert_allclose(run.reaction(rod.start), total - WEIGHT, rtol=0, atol=1e-6)


def test_reactions_of_a_spatial_thick_beam_balance():
    scene, rod = pendulum("thick", 4)
    run = ancf.simulate(scene, 0.1, 5e-4, solver=ancf.Newton(), save_every=10)
    expected = momentum_rate(run) - [0.0, -0.8 * 9.81, 0.0]
    np.testing.assert_allclose(run.reaction(rod.start), expected, rtol=0, atol=1e-5)


def test_a_free_node_has_no_reaction(by_number):
    run, rod = by_number
    with pytest.raises(ancf.InputError, match="no joint holds"):
        run.reaction(rod.end)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_rod_keeps_its_length(dim):
    scene, rod = pendulum("thin", 6, dim=dim)
    anchor = np.array([2.0, 1.0, 0.5][:dim])
    scene.rod(rod.end, anchor)
    length = np.linalg.norm(rod.end.position - anchor)
    for tolerance, bound in (("paper", 1e-6), ("default", 1e-9), (TIGHT, 1e-12)):
        run = ancf.simulate(
            scene, 0.5, 5e-4, integrator=ancf.Newmark(0.05), solver=ancf.Newton(),
            tolerance=tolerance,
        )  # fmt: skip
        now = np.linalg.norm(run.position(rod.end) - anchor, axis=1)
        assert np.abs(now - length).max() < bound
    # The force is along the rod; lam is its size because the gradient of phi has length one.
    along = (run.position(rod.end) - anchor) / length
    expected = -run.multipliers * along
    np.testing.assert_allclose(run.reaction(rod.end), expected, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("update", ["broyden", "davidon", "dfp", "bfgs"])
@pytest.mark.parametrize("memory", ["full", 10])
def test_nonlinear_constraints_are_no_obstacle(update, memory):
    # y on a nonlinear constraint makes the sign of s.y arbitrary (numerics 1.4).
    scene, rod = pendulum("l2t2", 10)
    scene.rod(rod.end, (2.0, 1.0))
    options = {"integrator": ancf.Newmark(0.05), "tolerance": 1e-7}
    paths = [
        ancf.simulate(scene, 0.3, 5e-4, solver=solver, **options).position(rod.end)
        for solver in (NEWTON, ancf.QuasiNewton(update, memory))
    ]
    np.testing.assert_allclose(*paths, rtol=0, atol=1e-7)


def test_a_rod_as_a_hanger_carries_the_weight():
    # Two rods hold a beam level: at the start each carries what statics says.
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (2, 0), 8, ancf.Rectangle(0.05, 0.05),
                         ancf.Material(2e11, 4000.0))  # fmt: skip
    scene.rod(rod.start, (0.0, 1.0))
    scene.rod(rod.end, (2.0, 1.0))
    scene.pin(rod.node(4), as_constraint=True)
    equilibrium = ancf.solve_static(scene)
    total = sum(equilibrium.reaction(node) for node in (rod.start, rod.node(4), rod.end))
    np.testing.assert_allclose(total, [0.0, 0.05**2 * 2 * 4000 * 9.81], rtol=1e-9, atol=1e-6)
    # Beam on three supports: 3/16, 10/16, 3/16 of the load.
    ends = equilibrium.reaction(rod.start)[1] / total[1]
    assert ends == pytest.approx(3 / 16, rel=1e-3)


def test_two_hinged_beams_swing_like_a_double_pendulum_start():
    # Stiff short beams in a row, released level, pinned at one end and hinged in the middle:
    # rigid double pendulum, alpha_1 = 9 g / 7 L down, alpha_2 = -3 g / 7 L (up), exactly.
    section, material = ancf.Rectangle(0.05, 0.05), ancf.Material(1e9, 4000.0)
    scene, one = build_beam("l2t2", (0, 0), (1, 0), 4, section, material)
    two = scene.add_beam("l2t2", (1, 0), (2, 0), 4, section, material)
    scene.pin(one.start)
    scene.connect(one.end, two.start)
    dt = 2e-3
    run = ancf.simulate(scene, 0.1, dt, integrator=ancf.Newmark(0.3), solver=ancf.Newton())
    np.testing.assert_array_equal(run.position(one.end), run.position(two.start))
    g, t = 9.81, run.t[-1]
    middle = run.position(one.end)[-1, 1] / (0.5 * t**2)
    tip = run.position(two.end)[-1, 1] / (0.5 * t**2)
    assert middle == pytest.approx(-9 * g / 7, rel=0.08)
    assert tip == pytest.approx(-6 * g / 7, rel=0.08)


@pytest.mark.parametrize("length", [0.4, 1.001, 3.0, 100.0])
@pytest.mark.parametrize("joint", ["rod", "distance", "winch"])
def test_violated_distances_are_reported_as_lengths(joint, length):
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, ancf.Circle(0.01), ancf.Material(1e8, 1000.0))
    scene.pin(rod.start)
    if joint == "rod":
        scene.rod(rod.end, (2, 0), length=lambda t: length)
    elif joint == "winch":
        scene.winch([(2.0, 0.0), rod.end], length=lambda t: length)
    else:
        ball = scene.add_body(position=(2, 0), mass=1.0, inertia=1.0)
        scene.pin(ball.origin)
        scene.distance(rod.end, ball.origin, length=lambda t: length)
    told = re.escape(f"by {abs(1.0 - length):.3g} m: move the start")
    with pytest.raises(ancf.InputError, match=told):
        ancf.simulate(scene, 0.1, 1e-3)
    if length > 1.0:
        return
    assert ancf.assemble(scene).violation == pytest.approx(1.0 - length)


def test_violated_rates_of_distances_are_velocities():
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, ancf.Circle(0.01), ancf.Material(1e8, 1000.0))
    scene.pin(rod.start)
    scene.rod(rod.end, (2, 0), length=lambda t: 0.4 + 0.5 * t)
    start = ancf.assemble(scene)
    with pytest.raises(ancf.InputError, match=r"velocities violate the rod .* by 0\.5 m/s"):
        ancf.simulate(scene, 0.1, 1e-3, start=start)


def test_a_start_that_breaks_a_constraint_is_refused():
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, ancf.Circle(0.01), ancf.Material(1e8, 1000.0),
                         velocity=(0.0, 1.0))  # fmt: skip
    scene.rod(rod.end, (1.0, 1.0))
    with pytest.raises(ancf.InputError, match=r"initial velocit.* violate the rod .* by .* m/s"):
        ancf.simulate(scene, 0.1, 1e-3)


def test_the_constraint_form_starts_with_consistent_multipliers():
    scene, rod = pendulum("l2t2", as_constraint=True)
    run = ancf.simulate(scene, 5e-4, 5e-4)
    r, _ = run.system.assembly.residual(
        run.q[0], run.v[0], run.a[0], run.lam[0], run.system.dead_load, np.zeros(0)
    )
    assert np.abs(r).max() < 1e-12
    assert np.abs(run.acceleration(rod.start)[0]).max() < 1e-9


@pytest.mark.parametrize(
    ("length", "modulus", "dt"), [(1e-3, 1e11, 1e-3), (1.0, 1e8, 1e-3), (1e3, 1e11, 1e-2)]
)
def test_a_seed_from_finite_differences_at_every_scale(length, modulus, dt):
    scene, rod = _hung(length, modulus)
    solver = ancf.QuasiNewton("davidon", seed="finite-difference")
    run = ancf.simulate(scene, 5 * dt, dt, solver=solver)
    exact = ancf.simulate(scene, 5 * dt, dt, solver=ancf.Newton())
    fallen = np.abs(exact.position(rod.end) - (length, 0.0)).max()
    assert np.abs(run.position(rod.end) - exact.position(rod.end)).max() < 1e-4 * fallen


def test_a_seed_from_finite_differences_is_not_singular_where_steps_are_long():
    # So long that a millionth of a newton is rounding beside the forces.
    system = System(_hung(1e-3, 1e11)[0])
    solver = ancf.QuasiNewton("davidon", seed="finite-difference")
    prepare_implicit(system, 1.0, ancf.GeneralizedAlpha(0.9), solver, "default", 0.01)


def _hung(length, modulus):
    section, material = ancf.Circle(length / 50), ancf.Material(modulus, 1e3)
    scene, rod = build_beam("thin", (0, 0), (length, 0), 4, section, material)
    scene.pin(rod.start, as_constraint=True)
    return scene, rod


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum()])
def test_slopes_move_where_every_node_is_held(integrator):
    # A hinged beam in gravity, of one element: its ends turn against each other with
    # omega^2 = 120 E I / (rho A L^4), by consistent masses and cubic shape functions.
    section, material = ancf.Circle(0.01), ancf.Material(1e8, 1e3)
    scene, beam = build_beam(
        "thin", (0, 0), (1, 0), 1, section, material, "pin", "pin", gravity=(0.0, -1e-3)
    )
    run = ancf.simulate(scene, 1.0, 1e-3, integrator=integrator)
    slope = -run.slope(beam.start)[:, 1]
    omega = np.sqrt(120.0 * 1e8 * section.inertia_z / (1e3 * section.area))
    rest = 1e-3 * 1e3 * section.area / (24.0 * 1e8 * section.inertia_z)  # w L^3 / (24 E I)
    np.testing.assert_allclose(slope, rest * (1 - np.cos(omega * run.t)), atol=5e-3 * rest)


def test_nets_whose_nodes_are_all_held_can_be_run():
    scene = ancf.Scene()
    nodes, edges = [(0, 0), (1, 0), (0, 1)], [(0, 1), (1, 2), (2, 0)]
    net = scene.add_mesh(nodes, edges, "thin", ancf.Circle(0.01), ancf.Material(1e8, 1e3))
    for k in range(3):
        scene.pin(net.node(k))
    runs = [
        ancf.simulate(scene, 0.01, 1e-4, integrator=each, solver=solver)
        for each in (ancf.GeneralizedAlpha(1.0), ancf.EnergyMomentum())
        for solver in ("auto", ancf.Newton())
    ]
    for run in runs:
        assert run.energy.drift < 1e-3
        np.testing.assert_allclose(run.q[-1], runs[0].q[-1], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("start", [(0.0, 0.0), (1e-9, 0.0), (3.0, 4.0)])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
def test_a_rod_is_not_broken_by_rounding_wherever_its_node_lies(start, scale):
    # At the origin nothing but the anchor says how large rounding is.
    for angle in np.linspace(0.1, 3.0, 20):
        section, material = ancf.Circle(0.02 * scale), ancf.Material(1e8 * scale, 1e3)
        place = scale * np.array(start)
        end = place + np.array([scale, 0.0])
        scene, rod = build_beam("thin", place, end, 2, section, material)
        scene.rod(rod.start, place + 0.7 * scale * np.array([np.cos(angle), np.sin(angle)]))
        check_constraints(System(scene))


def test_a_rod_far_from_the_origin_is_as_exact_as_one_near_it():
    # In squares of 10 km the length of a metre would be lost below 1e-8 m.
    far = 1e4
    scene = ancf.Scene((0.0, -9.81))
    beam = scene.add_beam(
        "thin", (0, 0), (far, 0), 2, ancf.Rectangle(0.01, 0.01), ancf.Material(2.1e11, 7850.0)
    )
    scene.pin(beam.start)
    scene.rod(beam.end, (far, 1.0))
    system = System(scene)
    q, rest = system.q0.copy(), np.zeros(system.n_all)
    places = system.point(beam.end)[0][:, 0]
    q[places] += (3e-4, -7e-4)
    _, phi = system.assembly.residual(q, rest, rest, np.zeros(1), system.dead_load, np.zeros(0))
    x, y = (Fraction(float(value)) for value in q[places])
    exact = ((x - Fraction(far)) ** 2 + (y - 1) ** 2 - 1) / 2
    assert abs(phi[0] - float(exact)) < 1e-15
    row = system.constraints.jacobian(q).toarray()[0]
    assert row[places] == pytest.approx([3e-4, -1.0007], rel=1e-8)


@pytest.mark.parametrize("solver", [ancf.Newton(), "auto"], ids=str)
def test_a_steel_chain_of_ten_thousand_hangs_on_a_rod(solver):
    # Newton failed at step 6, and others took many corrections: the rod was all rounding.
    section, steel = ancf.Rectangle(0.01, 0.01), ancf.Material(2.1e11, 7850.0)
    scene, chain = build_beam("thin", (0, 0), (2000, 0), 10_000, section, steel, "pin")
    scene.rod(chain.end, (2000, 1))
    run = ancf.simulate(scene, 0.015, 5e-4, solver=solver, save_nodes=[chain.end])
    assert run.stats.recoveries == 0
    assert run.stats.iterations_per_step < 3.0
    lengths = np.linalg.norm(run.position(chain.end) - (2000, 1), axis=1)
    np.testing.assert_allclose(lengths, 1.0, rtol=0, atol=1e-9)


@pytest.mark.parametrize("unit", [2.0**-40, 1.0, 2.0**40])
def test_how_a_motion_bends_constraints_does_not_depend_on_the_unit_of_time(unit):
    # Velocities and accelerations are of different units: their sum loses the smaller of them.
    scene = ancf.Scene((0.0, -9.81 / unit**2))
    rod = scene.add_beam(
        "thin", (0, 0), (1, 0), 2, ancf.Rectangle(0.01, 0.01), ancf.Material(1e7 / unit**2, 1e3),
        velocity=lambda x: np.outer(3.0 * x[:, 0] / unit, (0.0, 1.0)),
    )  # fmt: skip
    scene.pin(rod.start)
    scene.rod(rod.end, (2.0, 0.0))
    system = System(scene)
    regularize(system, 1e-6 * unit**2)
    pattern = system.pattern
    seed = SparseSeed(pattern.indptr, pattern.indices, system.n_free)
    seed.factor(system.assembly.matrix(1.0, 0.0, system.q0, np.zeros(1), np.zeros(0)))
    a, lam = initial_acceleration(system, seed, system.v0)
    found = initial_jerk(system, seed, system.v0, a, lam, 1e-3 * unit) * unit**3
    # phi = (|d|^2 - 1) / 2 up to a factor, d from the anchor to the end: 0 = d.jerk + 3 v.a.
    point, weights = system.point(rod.end)
    d, v, acceleration, jerk = (
        np.asarray(x)[point] @ weights for x in (system.q0, system.v0 * unit, a * unit**2, found)
    )
    d = d - (2.0, 0.0)
    assert d @ jerk == pytest.approx(-3.0 * v @ acceleration, rel=1e-9)
    assert abs(v @ acceleration) > 1.0


def roped(add_joint):
    """A beam whose end hangs on a winch, with one joint more."""
    material = ancf.Material(1e7, 1000.0)
    scene, beam = build_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.01), material)
    scene.winch([(0, 1), beam.end])
    add_joint(scene, beam)
    return scene


@pytest.mark.parametrize(
    ("add_joint", "named"),
    [
        (lambda s, b: s.rod(b.end, (0, 1)), r"rod at beam 0 .* follows from the winch"),
        (lambda s, b: s.winch([(0, 1), b.end]), r"winch of beam 0 .* follows from the winch"),
        (lambda s, b: s.pin(b.end, as_constraint=True), r"pin at beam 0 .* follows from the winch"),
    ],
    ids=["rod", "winch", "pin"],
)
def test_what_repeats_at_beams_is_named(add_joint, named):
    with pytest.warns(ancf.RedundantConstraintsWarning, match=named):
        ancf.simulate(roped(add_joint), 0.01, 1e-3)


def test_what_does_not_repeat_is_not_warned_of():
    ancf.simulate(roped(lambda s, b: s.rod(b.end, (1, 1))), 0.01, 1e-3)
    ancf.simulate(roped(lambda s, b: s.winch([(0, 1), b.start])), 0.01, 1e-3)


def two_wheels(angles):
    """Two discs on pins, of which a gear makes the first turn twice as far as the second."""
    scene = ancf.Scene((0.0, 0.0))
    pins = [scene.pin(scene.add_body(mass=1, inertia=1, position=(x, 0)).origin) for x in (0, 1)]
    for pin, angle in zip(pins, angles, strict=True):
        scene.drive_joint(pin, ancf.Ramp(angle, 1.0, smooth=True), as_constraint=True)
    scene.gear(*pins, 2.0)
    return scene


@pytest.mark.filterwarnings("ignore::ancfsparse.RedundantConstraintsWarning")
def test_joints_whose_motions_contradict_each_other_are_named():
    with pytest.raises(ancf.StepError) as found:
        ancf.simulate(two_wheels(angles=(1.0, 1.0)), 0.5, 0.01)
    text = str(found.value)
    assert "The joints contradict each other: the " in text
    assert all(
        name in text
        for name in ("gear of the pin of body 0", "angle of the pin of body 0", "of body 1")
    )
    assert "GeneralizedAlpha" not in text
    scene = two_wheels(angles=(2.0, 1.0))
    run = ancf.simulate(scene, 0.5, 0.01)
    assert run.body(scene.bodies[0]).angles[-1] == pytest.approx(1.0, abs=1e-6)


@pytest.mark.filterwarnings("ignore::ancfsparse.RedundantConstraintsWarning")
def test_a_rope_and_a_rod_of_other_length_contradict_each_other():
    scene = ancf.Scene((0.0, -9.81))
    load = scene.add_body(mass=1, inertia=1, position=(0, 0))
    scene.winch([(0, 3), load.origin])
    scene.rod(load.origin, (0, 3), length=ancf.Ramp(0.1, 1.0, smooth=True) + 3.0)
    with pytest.raises(ancf.StepError, match=r"contradict each other: .*rod.*winch"):
        ancf.simulate(scene, 0.1, 0.01)
