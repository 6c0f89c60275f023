"""The compiled assembly against the same equations put together by hand."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from ancfsparse.system import System
from ancfsparse.system.assembly.sparsity_pattern import build_pattern
from tests.grids import grid
from tests.matrices import full
from tests.system.by_hand import ZOO, ByHand, state

TIME = 0.37


@pytest.fixture(params=ZOO)
def system(request):
    return System(ZOO[request.param]())


def amplitudes(system, t=TIME):
    return system.loads.amplitudes(np.array([t]))[0]


def residual(system, q, a, lam, t=TIME):
    rest = np.zeros_like(q)
    return system.assembly.residual(q, rest, a, lam, system.dead_load, amplitudes(system, t))


@pytest.mark.parametrize("t", [0.0, TIME])
def test_residual_is_mass_force_loads_and_constraints(system, t, rng):
    hand = ByHand(system)
    q, a, lam = state(system, rng)
    r, phi = residual(system, q, a, lam, t)
    expected = hand.residual(q, a, lam, t)
    assert np.abs(r - expected).max() <= 1e-8 * np.abs(expected).max()  # phi_q is by differences
    np.testing.assert_allclose(phi, hand.phi(q), rtol=0, atol=1e-13)
    r, _ = residual(system, q, a, np.zeros_like(lam), t)
    expected = hand.residual(q, a, np.zeros_like(lam), t)
    assert np.abs(r - expected).max() <= 1e-13 * np.abs(expected).max()


def test_parts_are_force_and_inertia(system, rng):
    hand = ByHand(system)
    q, a, _ = state(system, rng)
    for found, expected in (
        (system.assembly.force(q), hand.force(q)),
        (system.assembly.inertia(a), hand.mass @ a),
    ):
        assert np.abs(found - expected).max() <= 1e-13 * np.abs(expected).max()


def test_force_is_the_gradient_of_the_energy(system, rng):
    q, _, _ = state(system, rng)
    step = 1e-4
    gradient = np.zeros(system.n_all)
    for i, e in enumerate(np.eye(system.n_all)):
        for k, weight in ((1, 2 / 3), (2, -1 / 12)):
            ahead = system.assembly.strain_energy(q + k * step * e)
            behind = system.assembly.strain_energy(q - k * step * e)
            gradient[i] += weight * (ahead - behind) / step
    force = system.assembly.force(q)
    assert np.abs(gradient - force).max() <= 1e-8 * np.abs(force).max()


def test_mass_stands_on_the_pattern(system):
    n = system.n_free
    found = full(system, system.assembly.mass)
    hand = ByHand(system).mass
    assert np.abs(found[:n, :n] - hand[:n, :n]).max() <= 1e-14 * np.abs(hand).max()
    assert not found[n:].any()
    np.testing.assert_allclose(system.mass_diagonal, np.diag(hand)[:n], rtol=1e-14)


@pytest.mark.parametrize("stiffness_factor", [1.0, 6.25e-8, 0.0])
def test_matrix_is_the_derivative_of_the_residual(system, stiffness_factor, rng):
    n, m = system.n_free, system.n_multipliers
    q, a, lam = state(system, rng)
    derivative, step = np.zeros((n, n)), 1e-4
    for j in range(n):
        e = np.eye(system.n_all)[j]
        for k, weight in ((1, 2 / 3), (2, -1 / 12)):
            ahead, _ = residual(system, q + k * step * e, a, lam)
            behind, _ = residual(system, q - k * step * e, a, lam)
            derivative[:, j] += weight * (ahead - behind)[:n] / step
    # Moments about fixed axes in space have an unsymmetric derivative: its symmetric part is kept.
    if not (system.dim == 3 and system.loads.moment_place):
        assert np.abs(derivative - derivative.T).max() <= 1e-7 * np.abs(derivative).max()
    derivative = 0.5 * (derivative + derivative.T)
    hand = ByHand(system)
    phi_q = hand.phi_q(q)[:, :n]
    values = system.assembly.matrix(0.7, stiffness_factor, q, lam, amplitudes(system))
    found = full(system, values)
    expected = 0.7 * hand.mass[:n, :n] + stiffness_factor * derivative
    assert np.abs(found[:n, :n] - expected).max() <= 1e-8 * np.abs(expected).max()
    assert np.abs(found[n:, :n] - phi_q).max(initial=0.0) <= 1e-9
    assert not found[n:, n:].any()
    if m == 0:
        return
    # The regularization makes the constraint block negative, so that L D L^T exists.
    system.assembly.set_regularization(0.125)
    values = system.assembly.matrix(0.7, stiffness_factor, q, lam, amplitudes(system))
    np.testing.assert_array_equal(full(system, values)[n:, n:], -0.125 * np.eye(m))


def test_damping_is_a_force_and_its_derivative_by_the_velocities(system, rng):
    hand = ByHand(system)
    q, a, lam = state(system, rng)
    v, n = rng.normal(size=system.n_all), system.n_free
    viscous, loads = hand.damping(q), amplitudes(system)
    assert system.damped == bool(viscous.any())
    size = np.abs(viscous @ v).max()
    assert np.abs(system.assembly.damping(q, v) - viscous @ v).max() <= 1e-12 * size
    at_rest, _ = residual(system, q, a, lam)
    moving, _ = system.assembly.residual(q, v, a, lam, system.dead_load, loads)
    found = moving - at_rest
    assert np.abs(found - viscous @ v).max() <= 1e-12 * np.abs(at_rest).max() + 1e-12 * size
    power = system.dissipation(np.array([q, q]), np.array([v, 2 * v]), np.zeros((2, 0)))
    np.testing.assert_allclose(power, v @ viscous @ v * np.array([1, 4]), rtol=1e-12)
    for stiffness_factor in (0.0, 1e-3):
        plain, damped = (
            full(system, system.assembly.matrix(
                0.7, stiffness_factor, q, lam, loads, damping_factor=factor, v=v))[:n, :n]
            for factor in (0.0, 0.02)
        )  # fmt: skip
        expected = 0.02 * viscous[:n, :n]
        assert np.abs(damped - plain - expected).max() <= 1e-13 * np.abs(damped).max()


def test_operations_count_what_damping_adds():
    plain, damped = (System(ZOO[name]()) for name in ("planar thick", "planar thick, damped"))
    one, two = plain.kinds
    # Both beams have two elements; the first damps its strains, the second its mass too.
    of_strains = 2 * (one.operations["damping"] + two.operations["damping"])
    of_mass = 2 * two.operations["inertia"]
    more = damped.operations("residual") - plain.operations("residual")
    assert more == of_strains + of_mass
    assert damped.operations("force") == plain.operations("force")
    assert damped.operations("tangent") > plain.operations("tangent")


def test_jacobian_and_curvature_of_the_constraints(system, rng):
    q, v, _ = state(system, rng)
    hand = ByHand(system)
    phi_q = system.constraints.jacobian(q).toarray()
    np.testing.assert_allclose(phi_q, hand.phi_q(q), rtol=0, atol=1e-8)
    # (phi_q v)_q v is the second derivative of phi along a straight motion.
    phi = [hand.phi(q + t * v) for t in (-1.0, 0.0, 1.0)]
    expected = phi[0] - 2 * phi[1] + phi[2]
    found = system.constraints.curvature(q, v)
    np.testing.assert_allclose(found, expected, rtol=1e-12, atol=1e-10)


def test_pattern_holds_each_entry_once_and_the_whole_diagonal(system):
    p = system.pattern
    assert p.n == system.n_free + system.n_multipliers
    for j in range(p.n):
        rows = p.indices[p.indptr[j] : p.indptr[j + 1]]
        assert rows[0] == j  # the diagonal comes first, used or not
        assert (np.diff(rows) > 0).all()
    column = np.repeat(np.arange(p.n), np.diff(p.indptr))
    for pair in (column, p.indices), (p.indices, column):
        slots = p.slots(np.stack(pair, axis=1))  # the pairs (i, i), (j, i), (j, j)
        np.testing.assert_array_equal(slots[:, 1], np.arange(p.n_values))
        np.testing.assert_array_equal(slots[:, 0], p.indptr[pair[0]])


def test_entries_of_fixed_coordinates_go_to_the_bin():
    p = System(pendulum("l2t2", 2).scene).pattern
    found = p.slots(np.array([[-1, 0, 1]]))[0]
    assert found[[0, 1, 3]].tolist() == [p.n_values] * 3
    assert (found[[2, 4, 5]] < p.n_values).all()


def test_a_pattern_is_the_union_of_its_cliques(rng):
    cliques = [rng.integers(-1, 20, (5, 3)), rng.integers(-1, 20, (2, 4)), np.empty((0, 2), int)]
    p = build_pattern(20, cliques)
    expected = np.eye(20, dtype=bool)
    for row in (row[row >= 0] for table in cliques for row in table):
        expected[np.ix_(row, row)] = True
    found = np.zeros((20, 20), dtype=bool)
    found[p.indices, np.repeat(np.arange(20), np.diff(p.indptr))] = True
    np.testing.assert_array_equal(found, np.tril(expected))


def test_pattern_of_a_chain_grows_with_its_length():
    sizes = [System(pendulum("l2t2", n).scene).pattern.n_values for n in (100, 200, 400)]
    assert sizes[1] - sizes[0] == 100 * (10 + 16)  # one block of 4 and its coupling per element
    assert sizes[2] - sizes[1] == 200 * (10 + 16)


def test_energies_and_stiffness_are_those_of_the_state(system, rng):
    q, v, _ = state(system, rng)
    hand = ByHand(system)
    kinetic, elastic, potential, _ = system.energies(q[None], v[None])
    assert kinetic[0] == pytest.approx(0.5 * v @ hand.mass @ v, rel=1e-13)
    assert elastic[0] == system.assembly.strain_energy(q)
    field = np.zeros(system.n_all)
    for places in system.places:
        field[places[:, : system.dim]] = system.scene.gravity
    assert potential[0] == pytest.approx(-q @ hand.mass @ field, rel=1e-12)
    diagonal = np.diag(hand.tangent(q))[: system.n_free]
    if not system.loads.moment_place:
        error = system.stiffness_diagonal(q) - diagonal
        assert np.abs(error).max() <= 1e-12 * np.abs(diagonal).max()


def test_an_empty_scene_is_refused():
    with pytest.raises(ancf.InputError, match="no beam"):
        System(ancf.Scene())


def test_a_beam_of_another_scene_is_refused():
    scene, _ = pendulum("l2t2")
    _, other = pendulum("l2t2")
    with pytest.raises(ancf.InputError, match="not part of this scene"):
        System(scene).place(other.end)


def test_rayleigh_damping_is_alpha_m_plus_beta_k_at_rest(rng):
    """On a net whose edges are all of different length, nothing being strained."""
    n = 6
    nodes, edges, _ = grid(n)
    places = np.cumsum(rng.uniform(0.5, 1.5, n))[nodes.astype(int)]
    scene = ancf.Scene((0.0, 0.0))
    material = ancf.Material(1e6, 1000.0, rayleigh=(0.3, 0.02))
    scene.add_mesh(places, edges, "l2t2", ancf.Circle(0.1), material)
    system = System(scene)
    nothing = np.zeros(0)
    viscous = system.assembly.matrix(0.0, 0.0, system.q0, nothing, nothing, damping_factor=1.0)
    expected = system.assembly.matrix(0.3, 0.02, system.q0, nothing, nothing)
    assert np.abs(viscous - expected).max() <= 1e-13 * np.abs(expected).max()


def between(system, q0, q1, v, a, lam, t=TIME):
    return system.assembly.residual_between(
        q0, q1, v, a, lam, system.dead_load, amplitudes(system, t)
    )


def test_between_a_state_and_itself_the_residual_is_the_residual(system, rng):
    q, a, lam = state(system, rng)
    v = rng.normal(size=q.size)
    r, phi = between(system, q, q, v, a, lam)
    expected, where = system.assembly.residual(q, v, a, lam, system.dead_load, amplitudes(system))
    assert np.abs(r - expected).max() <= 1e-13 * np.abs(expected).max()
    np.testing.assert_array_equal(phi, where)


def test_between_two_states_the_work_of_the_residual_is_the_change_of_energy(system, rng):
    """Strain, dead loads, constraints; damping and loads that change are those in the middle."""
    (q0, _, lam), (q1, _, _) = state(system, rng), state(system, rng)
    rest = np.zeros_like(q0)
    way, middle = q1 - q0, 0.5 * (q0 + q1)
    r, phi1 = between(system, q0, q1, rest, rest, lam)
    _, phi0 = between(system, q0, q0, rest, rest, lam)
    strain = system.assembly.strain_energy(q1) - system.assembly.strain_energy(q0)
    none = np.zeros_like(lam)
    loads = system.assembly.residual(
        middle, rest, rest, none, system.dead_load, amplitudes(system)
    )[0] - system.assembly.force(middle)
    expected = strain + loads @ way + lam @ (phi1 - phi0)
    assert r @ way == pytest.approx(expected, rel=1e-11)
