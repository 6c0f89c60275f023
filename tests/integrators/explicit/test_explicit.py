"""Explicit methods: order, stability, and what they keep."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.integrators.explicit.explicit_methods import make_explicit
from ancfsparse.problems import pendulum
from ancfsparse.seeds import SparseSeed
from ancfsparse.seeds.dense.block_inverse import BlockInverse
from ancfsparse.system import System
from benchmarks.common.first_order import FirstOrder, integrate
from tests.integrators.points import assert_saved_seldom, orders

METHODS = [ancf.CentralDifference(), ancf.RungeKuttaNystrom(4), ancf.RungeKuttaNystrom(8)]
SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


by_method = pytest.mark.parametrize("method", METHODS, ids=repr)


def step(method, acceleration, t, q, v, dt):
    """One step, written as the formulas stand."""
    A, b, c = method.tableau.A, method.tableau.b, method.tableau.c
    rates = []
    for i in range(len(b)):
        place = q + c[i] * dt * v
        for j in range(i):
            place = place + dt**2 * A[i, j] * rates[j]
        rates.append(acceleration(t + c[i] * dt, place))
    return place, v + dt * sum(w * a for w, a in zip(b, rates, strict=True))


def kepler(_, q):
    return -q / np.linalg.norm(q) ** 3


def pushed(t, q):
    """Exact solution sin t in the first component, exp(-t) in the second."""
    x = np.array([np.sin(t), np.exp(-t)])
    coupled = np.array([x[0] * x[1] - q[0] * q[1], x[1] ** 2 - q[1] ** 2])
    return np.array([-np.sin(t), np.exp(-t)]) + coupled


@by_method
def test_the_tableau_has_its_order_on_a_circle(method):
    counts = {2: (100, 200, 400), 4: (50, 100, 200), 8: (12, 24, 48)}[method.tableau.order]
    errors = []
    for n in counts:
        q, v = np.array([1.0, 0.0]), np.array([0.0, 1.0])
        for k in range(n):
            q, v = step(method, kepler, k * 4.0 / n, q, v, 4.0 / n)
        exact = np.array([np.cos(4.0), np.sin(4.0)]), np.array([-np.sin(4.0), np.cos(4.0)])
        errors.append(max(np.abs(q - exact[0]).max(), np.abs(v - exact[1]).max()))
    assert orders(errors)[-1] == pytest.approx(method.tableau.order, abs=0.25)


@by_method
def test_the_tableau_keeps_its_order_when_forces_change_with_time(method):
    counts = {2: (100, 200, 400), 4: (40, 80, 160), 8: (6, 12, 24)}[method.tableau.order]
    errors = []
    for n in counts:
        q, v = np.array([0.0, 1.0]), np.array([1.0, -1.0])
        for k in range(n):
            q, v = step(method, pushed, k * 2.0 / n, q, v, 2.0 / n)
        errors.append(np.abs(q - [np.sin(2.0), np.exp(-2.0)]).max())
    assert orders(errors)[-1] == pytest.approx(method.tableau.order, abs=0.35)


@by_method
def test_vibrations_grow_beyond_the_interval_and_not_within(method):
    t = method.tableau

    def growth(z):
        return np.abs(np.linalg.eigvals(t.transfer(z))).max() - 1.0

    # The double eigenvalue of a symplectic step is known to the root of the rounding only.
    assert max(growth(z) for z in np.linspace(1e-3, t.interval - 1e-6, 4001)) < 1e-7
    assert max(growth(z) for z in np.linspace(t.interval, t.interval + 0.01, 101)) > 1e-4


def test_transfer_is_the_step():
    method, z, dt = ancf.RungeKuttaNystrom(8), 1.3, 0.1
    omega = z / dt
    q, v = step(method, lambda t, q: -(omega**2) * q, 0.0, np.array([0.3]), np.array([-2.0]), dt)
    expected = method.tableau.transfer(z) @ [0.3, -2.0 * dt]
    np.testing.assert_allclose([q[0], dt * v[0]], expected, rtol=1e-12)


def loop_of(scene, method, dt, dense, state=None):
    """A system and its compiled loop, which starts from `state` or from rest."""
    system = System(scene)
    pattern = system.pattern
    seed = SparseSeed(pattern.indptr, pattern.indices, system.n_free)
    seed.factor(system.assembly.mass)
    q, v = (system.q0, system.v0) if state is None else state
    load = system.loads.amplitudes(np.zeros(1))[0]
    mass = BlockInverse(pattern.indptr, pattern.indices, system.assembly.mass) if dense else seed
    return system, make_explicit(system, dt, method, q, v, load, mass, np.inf, 0.0, 0.0)


def go(system, loop, method, n, amplitudes=None):
    """Take n steps without keeping any but the last."""
    if amplitudes is None:
        amplitudes = np.zeros((n * method.tableau.forces, 0))
    tables = [np.zeros((2, system.n_all)) for _ in range(3)]
    assert loop.advance(None, n, amplitudes, n, 0, *tables, np.zeros((2, 0))) == (n, 0)
    return loop.state


@pytest.mark.parametrize("dense", [True, False], ids=["blocks", "sweep"])
@pytest.mark.parametrize("element", ["l2t2", "thin"])
@by_method
def test_the_compiled_loop_makes_the_steps_of_the_formulas(method, element, dense):
    scene, rod = pendulum(element, 5)
    scene.point_force(rod.end, lambda t: (50.0 * np.sin(300 * t), 20.0 * t))
    scene.point_moment(rod.node(3), lambda t: 0.2 * np.cos(100 * t))
    dt, n = 1e-4, 7
    system, loop = loop_of(scene, method, dt, dense)
    inertia = np.array([system.assembly.inertia(e) for e in np.eye(system.n_all)])
    free = slice(system.n_free)

    def acceleration(t, q):
        a = np.zeros(system.n_all)
        load = system.loads.amplitudes(np.array([t]))[0]
        r, _ = system.assembly.residual(q, a, a, np.zeros(0), system.dead_load, load)
        a[free] = -np.linalg.solve(inertia[free, free], r[free])
        return a

    q, v = system.q0, system.v0
    for k in range(n):
        q, v = step(method, acceleration, k * dt, q, v, dt)
    times = dt * (np.arange(n)[:, None] + method.tableau.c[1:])
    found = go(system, loop, method, n, system.loads.amplitudes(times.ravel()))
    for x, y in zip(found, (q, v, acceleration(n * dt, q)), strict=False):
        np.testing.assert_allclose(x, y, rtol=0, atol=1e-11 * np.abs(y).max())
    np.testing.assert_array_equal(found[0][system.n_free :], system.q0[system.n_free :])


def exact_tips(element, times):
    """Tip positions by SciPy's method of order 8 at its tightest."""
    scene, rod = pendulum(element)
    system = System(scene)
    run = integrate(FirstOrder(system), "DOP853", np.concatenate([[0.0], times]), 1e-13, 1e-13)
    places = system.point(rod.end)[0].ravel()
    return run.q[1:, places]


@pytest.fixture(scope="module", params=["l2t2", "thin"])
def exact(request):
    return request.param, exact_tips(request.param, np.array([0.25, 0.5]))


def tip_error(method, dt, exact):
    element, expected = exact
    scene, rod = pendulum(element)
    run = ancf.simulate(scene, 0.5, dt, integrator=method, save_every=round(0.25 / dt))
    return np.abs(run.position(rod.end)[1:] - expected).max()


def test_order_eight_agrees_with_scipy(exact):
    assert tip_error(METHODS[2], 4e-4, exact) < 1e-11


def test_central_differences_are_of_second_order(exact):
    errors = [tip_error(METHODS[0], dt, exact) for dt in (2.5e-4, 1.25e-4, 6.25e-5)]
    assert np.abs(orders(errors) - 2).max() < 0.1
    assert errors[0] < 1e-5


def test_runge_kutta_nystrom_is_of_fourth_order(exact):
    errors = [tip_error(METHODS[1], dt, exact) for dt in (5e-4 / 1.25, 2.5e-4, 1.25e-4)]
    ratio = np.log(np.array(errors[:-1]) / errors[1:]) / np.log([1.6, 2.0])
    assert np.abs(ratio - 4).max() < 0.2
    assert errors[0] < 5e-8


@pytest.mark.parametrize(("method", "dts"), [(0, (1e-4, 5e-5)), (1, (2e-4, 1e-4))])
def test_changing_loads_keep_the_order(method, dts):
    found = []
    for integrator, dt in [(METHODS[2], 1e-4), *((METHODS[method], dt) for dt in dts)]:
        scene, rod = pendulum()
        # They set in smoothly, or waves as short as an element would run along the rod.
        scene.point_force(rod.end, lambda t: (20.0 * np.sin(10 * t) ** 8, 0.0))
        scene.point_moment(rod.node(5), lambda t: 0.5 * np.sin(8 * t) ** 8)
        run = ancf.simulate(scene, 0.4, dt, integrator=integrator, save_every=round(0.1 / dt))
        found.append(run.position(rod.end))
    errors = [np.abs(path - found[0]).max() for path in found[1:]]
    assert orders(errors)[0] == pytest.approx(METHODS[method].tableau.order, abs=0.2)


def test_central_differences_keep_the_energy_for_ever():
    wander = []
    for dt in (2e-4, 1e-4):
        scene = ancf.Scene((0.0, 0.0))
        rod = scene.add_beam(
            "thin", (0, 0), (2, 0), 10, SECTION, MATERIAL,
            velocity=lambda x: np.stack([0.0 * x[:, 0], 0.1 * x[:, 0] ** 2], axis=1),
        )  # fmt: skip
        scene.clamp(rod.start)
        every = round(0.01 / dt)
        energy = ancf.simulate(scene, 20.0, dt, integrator=METHODS[0], save_every=every).energy
        away = np.abs(energy.total - energy.total[0]) / energy.kinetic.max()
        assert away[1000:].max() < 1.1 * away[:1000].max()  # 20 s are no worse than 10 s
        wander.append(away.max())
    assert wander[0] < 1e-4
    assert wander[0] / wander[1] == pytest.approx(4, abs=0.5)


def test_central_differences_run_backwards():
    method, n = METHODS[0], 2000
    system, loop = loop_of(pendulum().scene, method, 2.5e-4, dense=True)
    q, v, _, _ = go(system, loop, method, n)
    assert np.abs(q - system.q0).max() > 0.5
    system, back = loop_of(pendulum().scene, method, 2.5e-4, True, (q, -v))
    found = go(system, back, method, n)
    np.testing.assert_allclose(found[0], system.q0, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found[1], system.v0, rtol=0, atol=1e-8)


@by_method
@pytest.mark.parametrize(("dim", "element"), [(2, "l2t2"), (3, "thin")])
def test_free_fall_is_exact(dim, element, method):
    gravity, velocity = np.array([0.5, -9.81, 0.25])[:dim], np.array([1.0, 2.0, -3.0])[:dim]
    scene = ancf.Scene(tuple(gravity))
    start, end = (0.0,) * dim, (2.0, 0.5, -0.5)[:dim]
    rod = scene.add_beam(element, start, end, 10, SECTION, MATERIAL, velocity=velocity)
    run = ancf.simulate(scene, 1.0, 2e-4, integrator=method, save_every=1000)
    path = rod.end.position + np.outer(run.t, velocity) + np.outer(run.t**2 / 2, gravity)
    np.testing.assert_allclose(run.position(rod.end), path, rtol=0, atol=1e-10)
    fall = velocity + np.outer(run.t, gravity)
    np.testing.assert_allclose(run.velocity(rod.end), fall, rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.acceleration(rod.end)[0], gravity, rtol=0, atol=1e-9)


@by_method
def test_saved_accelerations_balance_the_saved_states(method):
    scene, rod = pendulum()
    scene.point_force(rod.end, lambda t: (2.0 * np.sin(40 * t), 0.0))
    run = ancf.simulate(scene, 0.1, 2e-4, integrator=method, save_every=50)
    system = run.system
    for t, q, a in zip(run.t, run.q, run.a, strict=True):
        load = system.loads.amplitudes(np.array([t]))[0]
        r, _ = system.assembly.residual(q, a, a, np.zeros(0), system.dead_load, load)
        assert np.abs(r[: system.n_free]).max() < 1e-10


@by_method
def test_counts(method):
    scene, _ = pendulum()
    stats = ancf.simulate(scene, 0.2, 2e-4, integrator=method).stats
    assert stats.steps == 1000
    assert stats.residual_evaluations == stats.solves == 1000 * method.tableau.forces
    assert (stats.iterations, stats.factorizations, stats.recoveries) == (0, 1, 0)
    assert "of the stable step" in stats.solver
    assert "blocks" in stats.solver


def test_saving_seldom_saves_the_same_states():
    scene, rod = pendulum("l2t2", 2)
    scene.point_force(rod.end, lambda t: (np.sin(5 * t), 0.0))
    assert_saved_seldom(scene, (7, 4000), integrator=METHODS[1])


@pytest.mark.parametrize("order", [2, 3, 6, 12, True, "4", 4.5])
def test_an_order_there_is_not_is_refused(order):
    with pytest.raises(ancf.InputError, match="order 4 or 8"):
        ancf.RungeKuttaNystrom(order)
