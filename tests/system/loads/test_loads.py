"""Loads do the work they should on displacements that the elements hold exactly."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import full

SECTION, MATERIAL = ancf.Circle(0.02), ancf.Material(1e8, 1000.0)
START, END = np.array([1.0, 2.0, -1.0]), np.array([2.0, 0.0, 1.0])  # 3 m
GRAVITY = np.array([0.5, -1.0, 9.81])


def build(element="thin", n=5, gravity=GRAVITY, **options):
    dim = len(gravity)
    scene = ancf.Scene(gravity)
    rod = scene.add_beam(element, START[:dim], END[:dim], n, SECTION, MATERIAL, **options)
    return scene, rod


def linear(system, rod, matrix, shift):
    """Coordinates of the displacement matrix x + shift of the whole space."""
    dim = system.dim
    out = np.zeros(system.n_all)
    vectors = system.q0[system.places[0]]
    out[system.places[0][:, :dim]] = rod.positions @ matrix.T + shift
    for k in range(1, vectors.shape[1] // dim):
        columns = slice(dim * k, dim * (k + 1))
        out[system.places[0][:, columns]] = vectors[:, columns] @ matrix.T
    return out


def applied_moments(system, q):
    """Force of the moments of a system alone, and their amplitudes, at t = 0."""
    row, zero = system.loads.amplitudes(np.zeros(1))[0], np.zeros(system.n_all)
    with_it, without = (
        system.assembly.residual(q, zero, zero, np.zeros(0), system.dead_load, amplitudes)[0]
        for amplitudes in (row, np.zeros_like(row))
    )
    return without - with_it, row


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("element", ["thin", "thick"])
def test_gravity_weighs_the_beam_where_it_is(element, dim, rng):
    scene, rod = build(element, gravity=GRAVITY[:dim])
    system = System(scene)
    mass = SECTION.area * MATERIAL.density * rod.length
    # Translations: the weight.  All linear fields: its moments, so it acts at the middle.
    for d in range(dim):
        field = linear(system, rod, np.zeros((dim, dim)), np.eye(dim)[d])
        assert system.dead_load @ field == pytest.approx(mass * GRAVITY[d], rel=1e-13)
    matrix, shift = rng.normal(size=(dim, dim)), rng.normal(size=dim)
    middle = matrix @ (START + END)[:dim] / 2 + shift
    expected = mass * GRAVITY[:dim] @ middle
    assert system.dead_load @ linear(system, rod, matrix, shift) == pytest.approx(expected)
    np.testing.assert_array_equal(system.gravity_load, system.dead_load)


@pytest.mark.parametrize("element", ["thin", "thick"])
def test_a_distributed_force_is_its_resultant_in_the_middle(element, rng):
    scene, rod = build(element, gravity=np.zeros(3))
    value = np.array([3.0, -1.0, 2.0])
    scene.distributed_force(rod, value)
    system = System(scene)
    matrix, shift = rng.normal(size=(3, 3)), rng.normal(size=3)
    expected = value * rod.length @ (matrix @ (START + END) / 2 + shift)
    assert system.dead_load @ linear(system, rod, matrix, shift) == pytest.approx(expected)


def test_a_distributed_force_equals_gravity_of_the_same_size():
    scene, rod = build()
    weighed = System(scene).dead_load
    scene, rod = build(gravity=np.zeros(3))
    scene.distributed_force(rod, SECTION.area * MATERIAL.density * GRAVITY)
    np.testing.assert_allclose(System(scene).dead_load, weighed, rtol=1e-13)


@pytest.mark.parametrize("s", [0.0, 0.3, 1.2, 2.9, 3.0])
def test_a_point_force_works_on_the_point(s):
    # On a cubic displacement along the beam, held exactly by the interpolation.
    scene, rod = build(gravity=np.zeros(3))
    force = np.array([3.0, -1.0, 2.0])
    scene.point_force(rod.at(s), force)
    system = System(scene)
    cubic = np.polynomial.Polynomial([1.0, -2.0, 0.5, 0.25])
    arc = np.linspace(0, rod.length, rod.n_nodes)
    for d in range(3):
        field = np.zeros(system.n_all)
        field[system.places[0][:, d]] = cubic(arc)
        field[system.places[0][:, 3 + d]] = cubic.deriv()(arc)
        assert system.dead_load @ field == pytest.approx(force[d] * cubic(s), rel=1e-12)


def test_loads_at_one_place_add_up():
    scene, rod = build(gravity=np.zeros(3))
    for _ in range(3):
        scene.point_force(rod.end, (1.0, 2.0, 3.0))
    system = System(scene)
    np.testing.assert_array_equal(system.dead_load[system.place(rod.end)[:3]], [3.0, 6.0, 9.0])
    assert np.count_nonzero(system.dead_load) == 3


def test_changing_loads_follow_the_clock():
    scene, rod = build(gravity=np.zeros(3))
    scene.point_force(rod.at(0.3), lambda t: (t, 0.0, 1.0))
    scene.point_force(rod.at(0.3), (0.0, 5.0, 0.0))
    scene.distributed_force(rod, lambda t: (0.0, np.cos(t), 0.0))
    scene.point_moment(rod.end, (1.0, 0.0, 2.0))
    system = System(scene)
    times = np.array([0.0, 0.25, 1.5])
    table = system.loads.amplitudes(times)
    # The constant force needs no column; a moment does, because its force follows the slope.
    zero, one = np.zeros(3), np.ones(3)
    columns = [times, zero, one, zero, np.cos(times), zero, one, zero, 2 * one]
    expected = np.column_stack(columns)
    np.testing.assert_allclose(table, expected, rtol=1e-15)
    zero = np.zeros(system.n_all)
    for row, t in zip(table, times, strict=True):
        r, _ = system.assembly.residual(system.q0, zero, zero, np.zeros(0), system.dead_load, row)
        applied = system.assembly.force(system.q0) - r
        for d, expected in enumerate((t, 5.0 + np.cos(t) * rod.length, 1.0)):
            field = linear(system, rod, np.zeros((3, 3)), np.eye(3)[d])
            assert applied @ field == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_moment_works_on_rotations(dim, rng):
    # On a rigid turn w it works m.w, less the part along the slope, which a cable does not feel.
    scene, rod = build(gravity=np.zeros(dim))
    m = rng.normal(size=3) if dim == 3 else np.array([0.0, 0.0, 1.7])
    scene.point_moment(rod.node(2), m if dim == 3 else 1.7)
    system = System(scene)
    w = rng.normal(size=3) if dim == 3 else np.array([0.0, 0.0, 2.3])
    field = linear(system, rod, np.cross(w, np.eye(3)).T[:dim, :dim], np.zeros(dim))
    tangent = np.zeros(3)
    tangent[:dim] = rod.axes[0]
    expected = m @ w - (m @ tangent) * (w @ tangent)
    assert applied_moments(system, system.q0)[0] @ field == pytest.approx(expected, abs=1e-9)
    # The same from the power of the loads, which the energy balance uses.
    power = system.power(system.q0[None], field[None], np.zeros(1))
    assert power[0] == pytest.approx(expected)


@pytest.mark.parametrize("dim", [2, 3])
def test_a_moment_on_a_section_leaves_the_slope_alone_and_is_all_there(dim, rng):
    # However the section is strained, forces on r_y and r_z alone have the moment m about the node.
    scene, rod = build("thick", gravity=np.zeros(dim), curvature="section")
    m = rng.normal(size=3) if dim == 3 else np.array([0.0, 0.0, 1.7])
    scene.point_moment(rod.node(2), m if dim == 3 else 1.7)
    system = System(scene)
    q = system.q0 + 0.2 * rng.normal(size=system.n_all)
    force, _ = applied_moments(system, q)
    places = system.place(rod.node(2))
    total, scale = np.zeros(3), np.abs(system.assembly.force(q)).max()
    for k in range(1, dim):
        arm, push = np.zeros(3), np.zeros(3)
        where = places[dim * (k + 1) : dim * (k + 2)]
        arm[:dim], push[:dim] = q[where], force[where]
        total += np.cross(arm, push)
    np.testing.assert_allclose(total, m, rtol=0, atol=1e-15 * scale)
    force[places[2 * dim :]] = 0.0
    assert np.abs(force).max() <= 1e-15 * scale


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(
    "options",
    [{}, {"element": "thick"}, {"element": "thick", "curvature": "section"}],
    ids=["slope", "slope and twist", "section"],
)
def test_the_matrix_of_moments_is_the_derivative_of_their_forces(dim, options, rng):
    scene, rod = build(gravity=np.zeros(dim), n=2, **options)
    for node in (rod.node(1), rod.end):
        scene.point_moment(node, rng.normal(size=3) if dim == 3 else rng.normal())
    system = System(scene)
    q, none = system.q0 + 0.2 * rng.normal(size=system.n_all), np.zeros(0)
    _, row = applied_moments(system, q)

    def force(q):
        return -applied_moments(system, q)[0]

    # Central differences of fourth order, of the moments alone.
    step, expected = 1e-3, np.zeros((system.n_all, system.n_all))
    for j, e in enumerate(step * np.eye(system.n_all)):
        expected[:, j] = 8.0 * (force(q + e) - force(q - e)) - (force(q + 2 * e) - force(q - 2 * e))
    expected /= 12.0 * step
    found = full(system, system.assembly.matrix(0.0, 1.0, q, none, row))
    found -= full(system, system.assembly.matrix(0.0, 1.0, q, none, np.zeros_like(row)))
    size = np.abs(expected).max()
    assert size > 0.1
    if dim == 2:
        assert np.abs(expected - expected.T).max() <= 1e-7 * size
    # In space a fixed moment has no potential, and the matrix is the symmetric part.
    expected = 0.5 * (expected + expected.T)
    assert np.abs(found - expected).max() <= 1e-7 * size


@pytest.mark.parametrize("options", [{}, {"element": "thick", "curvature": "section"}])
def test_power_is_force_times_velocity(options, rng):
    scene, rod = build(**options)
    scene.point_force(rod.at(0.7), (1.0, 2.0, 3.0))
    scene.distributed_force(rod, lambda t: (t, -1.0, 0.0))
    scene.point_moment(rod.end, lambda t: (1.0, t, 2.0))
    system = System(scene)
    t = np.array([0.0, 0.4])
    q = system.q0 + 0.1 * rng.normal(size=(2, system.n_all))
    v = rng.normal(size=(2, system.n_all))
    table = system.loads.amplitudes(t)
    for k in range(2):
        r, _ = system.assembly.residual(
            q[k], v[k], np.zeros(system.n_all), np.zeros(0), system.dead_load, table[k]
        )
        applied = system.assembly.force(q[k]) - r - system.gravity_load
        assert system.power(q, v, t)[k] == pytest.approx(applied @ v[k], rel=1e-9)
