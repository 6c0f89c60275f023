"""Energy that damped schemes add to the work of a load in the first step from rest."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.integrators.linear_step import Linear, first_step, gain, linearized

EVERYTHING = (np.eye(1), np.eye(1))  # of accelerations and their rates, as in the literature
SCHEMES = [
    ancf.Newmark(0.0), ancf.Newmark(0.05), ancf.HHT(0.05), ancf.HHT(0.3),
    *(ancf.GeneralizedAlpha(rho) for rho in (0.0, 0.2, 0.5, 0.8, 1.0)),
]  # fmt: skip
SECOND_ORDER = [scheme for scheme in SCHEMES if scheme.order == 2]


def random_system(rng, n=4):
    """Return matrices with frequencies around one radian per step, and two loads."""
    root = rng.normal(size=(3, n, n))
    mass, damping, stiffness = (each @ each.T + 0.1 * np.eye(n) for each in root)
    return Linear(mass, damping, stiffness, tuple(rng.normal(size=(2, n))))


def oscillator(omega, before, after):
    """Return a unit mass on a spring."""
    loads = (np.array([before]), np.array([after]))
    return Linear(np.eye(1), np.zeros((1, 1)), np.array([[omega**2]]), loads)


@pytest.mark.parametrize("scheme", SCHEMES, ids=repr)
def test_the_identity_of_the_energy_holds_in_the_first_step(scheme):
    # docs/theory.md; M a0 misses the load at the start by what the filter omits.
    m, f, beta, gamma = scheme.alpha_m, scheme.alpha_f, scheme.beta, scheme.gamma
    for k in range(5):
        linear, dt = random_system(np.random.default_rng(k)), 0.7
        step = first_step(linear, scheme, dt)
        mass, (a0, a1), (b0, b1) = linear.mass, step.a, step.b
        lag = (0.5 - f) * (a1 - a0 - b1 + b0) + (gamma - 0.5 + m - f) * (b1 - b0)
        stored = 0.5 * (b1 @ mass @ b1 - b0 @ mass @ b0)
        stored += (gamma - 0.5) * (b1 - b0) @ mass @ (b1 - b0)
        expected = step.q @ mass @ lag - (beta - 0.5 * gamma) * dt**2 * stored
        expected += 0.5 * step.q @ (mass @ a0 - linear.loads[0] - linear.damping @ step.v)
        assert gain(linear, step) == pytest.approx(expected, rel=1e-11)


@pytest.mark.parametrize("scheme", SECOND_ORDER, ids=repr)
def test_a_free_mass_gains_by_a_load_that_grows_against_it(scheme):
    dt, before, after = 0.3, 2.0, 1.1
    linear = oscillator(0.0, before, after)
    step = first_step(linear, scheme, dt)
    assert step.v[0] == pytest.approx(0.5 * dt * (before + after), rel=1e-14)
    expected = -0.25 * scheme.shift**2 * dt * (after - before) * step.v[0]
    assert gain(linear, step) == pytest.approx(expected, rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("scheme", SECOND_ORDER, ids=repr)
def test_the_gain_is_bounded_by_what_the_first_acceleration_stores(scheme):
    # With the start of the literature, at all frequencies and for all loads.
    for omega in np.logspace(-3, 3, 25):
        for angle in np.linspace(0.0, np.pi, 33):
            linear = oscillator(omega, np.cos(angle), np.sin(angle))
            step = first_step(linear, scheme, 1.0, EVERYTHING)
            stored = 0.5 * (scheme.beta - 0.5 * scheme.gamma) * step.b[0][0] ** 2
            assert gain(linear, step) <= stored + 1e-13


@pytest.mark.parametrize("scheme", SCHEMES, ids=repr)
@pytest.mark.parametrize("hold", ["clamp", "rods"])
def test_simulations_make_the_same_first_step_and_gain_the_same(scheme, hold):
    # So light that the beam hardly bends: its first step has 0.6 rad of the slowest vibration.
    dt, gravity = 0.02, -1e-6
    scene = ancf.Scene((0.0, gravity))
    section, material = ancf.Rectangle(0.004, 0.004), ancf.Material(7.5e9, 3500.0)
    rod = scene.add_beam("thin", (0.0, 0.0), (0.5, 0.0), 2, section, material)
    if hold == "clamp":
        scene.clamp(rod.start)
    else:
        scene.rod(rod.start, (0.1, 0.2))
        scene.rod(rod.end, (0.3, 0.3))
    load = np.array([0.0, -0.2 * gravity * 0.5 * section.area * material.density])
    scene.point_force(rod.end, lambda t: load * t / dt)
    path = ancf.simulate(
        scene, dt, dt, integrator=scheme, solver=ancf.Newton(), max_energy_gain=np.inf
    )
    linear = linearized(System(scene), dt)
    step = first_step(linear, scheme, dt)
    kinetic = 0.5 * step.v @ linear.mass @ step.v
    assert path.energy.kinetic[1] == pytest.approx(kinetic, rel=1e-5)
    energy, way = np.diff(path.energy.total)[0], np.diff(path.position(rod.end), axis=0)[0]
    expected = gain(linear, step)
    assert energy - 0.5 * load @ way == pytest.approx(expected, rel=1e-4, abs=1e-6 * kinetic)
    if scheme == ancf.GeneralizedAlpha(0.0) and hold == "clamp":
        assert expected > 0.1 * kinetic
