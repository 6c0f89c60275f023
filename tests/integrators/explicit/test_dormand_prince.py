"""The explicit method that takes damping and multipliers, against SciPy and by its formulas."""

import copy
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.integrators.explicit.explicit_methods import make_explicit
from ancfsparse.solve.linearization.matrices import mass_seed
from ancfsparse.solve.stepping.explicit_setup import check_multipliers
from ancfsparse.system import System

SECTION, METHOD = ancf.Rectangle(0.02, 0.02), ancf.DormandPrince()
DRY = ancf.Material(1e7, 2000.0)
WET = ancf.Material(1e7, 2000.0, axial_damping=2e-4, bending_damping=2e-3, rayleigh=(0.5, 0.0))


def swing(material=DRY, force=3.0):
    """A plank on two rods, one of them oblique, with a force that changes."""
    scene = ancf.Scene((0.0, -9.81))
    plank = scene.add_beam("thin", (0, 0), (1, 0), 4, SECTION, material, velocity=(0.5, 0.0))
    scene.rod(plank.start, (0.0, 1.0))
    scene.rod(plank.end, (1.0, 0.7))
    scene.point_force(plank.node(2), lambda t: (0.0, force * np.sin(9.0 * t) ** 2))
    return scene


def pinned(material=WET):
    scene = ancf.Scene((0.0, 0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 4, SECTION, material)
    scene.pin(rod.start, as_constraint=True)
    return scene


def damped():
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, SECTION, WET)
    scene.pin(rod.start)
    return scene


SCENES = [swing, lambda: swing(WET), pinned, damped]
IDS = ["rods", "damped rods", "pinned by multipliers", "damped"]


def rates(system):
    """Accelerations and multipliers, from dense matrices."""
    n, none = system.n_free, np.zeros(system.n_all)
    mass = np.array([system.assembly.inertia(unit)[:n] for unit in np.eye(system.n_all)[:n]])

    def rate(t, q, v):
        load = system.loads.amplitudes(np.array([t]))[0]
        lam = np.zeros(system.n_multipliers)
        r, _ = system.assembly.residual(q, v, none, lam, system.dead_load, load)
        G = system.constraints.jacobian(q).toarray()[:, :n]
        kkt = np.block([[mass, G.T], [G, np.zeros((len(G), len(G)))]])
        right = np.concatenate([-r[:n], -system.constraints.curvature(q, v)])
        a, lam = np.split(np.linalg.solve(kkt, right), [n])
        return np.append(a, none[n:]), lam

    return rate


def by_scipy(system, times):
    rate, n = rates(system), system.n_all
    y = np.concatenate([system.q0, system.v0])
    solved = solve_ivp(
        lambda t, y: np.concatenate([y[n:], rate(t, y[:n], y[n:])[0]]),
        (0.0, times[-1]), y, "DOP853", times, rtol=1e-10, atol=1e-12,
    )  # fmt: skip
    return solved.y[:n].T, solved.y[n:].T


@pytest.mark.parametrize("make", SCENES, ids=IDS)
def test_it_agrees_with_scipy(make):
    run = ancf.simulate(make(), 0.05, 1e-4, integrator=METHOD, save_every=100)
    q, v = by_scipy(run.system, run.t)
    np.testing.assert_allclose(run.q, q, rtol=0, atol=1e-9)
    np.testing.assert_allclose(run.v, v, rtol=0, atol=1e-6)
    rate = rates(run.system)
    for t, q, v, a, lam in zip(run.t, run.q, run.v, run.a, run.lam, strict=True):
        expected = rate(t, q, v)
        np.testing.assert_allclose(a, expected[0], rtol=0, atol=1e-9 * np.abs(a).max())
        np.testing.assert_allclose(lam, expected[1], rtol=0, atol=1e-9 * np.abs(lam).max(initial=1))


def swung(t, q, v):
    """Exact solution sin t, exp(-t), with forces of time, places and velocities."""
    x, w = np.array([np.sin(t), np.exp(-t)]), np.array([np.cos(t), -np.exp(-t)])
    far, fast = q[0] * q[1] - x[0] * x[1], v[0] * v[1] - w[0] * w[1]
    return np.array([-np.sin(t) - far + fast, np.exp(-t) - fast])


def test_its_tableau_is_of_order_eight():
    t = METHOD.tableau
    errors = []
    for n in (3, 6, 12):  # 24 leave rounding
        dt, q, v = 2.0 / n, np.array([0.0, 1.0]), np.array([1.0, -1.0])
        for k in range(n):
            a = np.zeros((len(t.b), 2))
            for i in range(len(t.b)):
                place = q + dt * t.c[i] * v + dt**2 * t.A[i] @ a
                a[i] = swung(dt * (k + t.c[i]), place, v + dt * t.B[i] @ a)
            q, v = q + dt * v + dt**2 * t.A[-1] @ a, v + dt * t.b @ a
        errors.append(np.abs(q - [np.sin(2.0), np.exp(-2.0)]).max())
    assert np.log2(errors[1] / errors[2]) == pytest.approx(8.0, abs=0.5)


def test_nothing_that_dies_out_grows_within_its_interval():
    t = METHOD.tableau
    s = len(t.b) - 1

    def growth(z):  # of y' = z y
        rates = np.linalg.solve(np.eye(s) - z * t.B[:s, :s], np.ones(s))
        return abs(1.0 + z * t.B[s, :s] @ rates)

    angles = np.linspace(0.5, 1.0, 41) * np.pi
    for share in np.linspace(0.05, 1.0, 60):
        z = share * t.interval * np.exp(1j * angles)
        assert max(growth(each) for each in z) < 1.0 + 1e-9
    assert growth(1.01j * t.interval) > 1.0


def test_constraints_are_left_by_no_more_than_steps_are_off():
    run = ancf.simulate(swing(force=0.0), 2.0, 1.25e-4, integrator=METHOD, save_every=400)
    lengths = np.linalg.norm(run.q[:, :2] - (0.0, 1.0), axis=1)
    assert np.abs(lengths - 1.0).max() < 1e-9
    energy = run.energy
    assert np.abs(energy.total - energy.total[0]).max() < 1e-7 * energy.kinetic.max()


@pytest.mark.parametrize("make", [lambda: swing(WET), damped], ids=["damped rods", "damped"])
def test_its_stable_step_is_where_steps_begin_to_grow(make):
    limit = ancf.stable_step(make(), METHOD)
    steps = np.ceil(0.5 / limit * 1.02)
    ancf.simulate(make(), 0.5, 0.5 / steps, integrator=METHOD)
    with pytest.raises(ancf.InputError, match="above the stable step of DormandPrince"):
        ancf.simulate(make(), 0.5, 0.5 / np.floor(0.5 / limit), integrator=METHOD)


def test_what_creeps_bounds_the_step_too():
    creeping = ancf.Material(1e7, 2000.0, axial_damping=0.05)
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, SECTION, creeping)
    scene.pin(rod.start)
    limit = ancf.stable_step(scene, METHOD)
    assert limit < 0.1 * ancf.stable_step(damped(), METHOD)
    run = ancf.simulate(scene, 0.01, 0.01 / np.ceil(0.01 / limit), integrator=METHOD, save_every=50)
    q, _ = by_scipy(run.system, run.t)
    np.testing.assert_allclose(run.q, q, rtol=0, atol=1e-6)


def test_many_multipliers_move_as_few_do():
    """Beyond twelve the matrix with all constraints is factored."""
    runs = []
    for count in (6, 7):
        scene = ancf.Scene((0.0, -9.81))
        for k in range(count):
            rod = scene.add_beam("thin", (0, k), (1, k), 1, SECTION, DRY)
            scene.pin(rod.start, as_constraint=True)
        run = ancf.simulate(scene, 0.1, 1e-4, integrator=METHOD)
        runs.append(run.position(scene.beams[0].end))
    np.testing.assert_allclose(*runs, rtol=0, atol=1e-10)


def test_constraints_that_repeat_one_another_have_no_multipliers():
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, SECTION, DRY)
    scene.rod(rod.start, (0.0, 1.0))
    system = System(scene)
    twice, once = copy.deepcopy(system.constraints), system.constraints
    places = zip(once.coefficient, once.i, once.j, strict=True)
    twice.add("rod again", once.offset[0], *places, about=once.about)
    state = system.q0, system.v0, np.zeros(0), mass_seed(system), np.inf, 0.0, 0.0
    for constraints, finite in ((once, True), (twice, False)):
        known = SimpleNamespace(
            capsule=system.capsule,
            parts=system.parts,
            dead_load=system.dead_load,
            constraints=constraints,
            prescribed=system.prescribed,
        )
        loop = make_explicit(known, 1e-4, METHOD, *state)
        assert loop.finite == finite
    with pytest.raises(ancf.InputError, match="repeats another constraint"):
        check_multipliers(system, loop, METHOD)
