"""Motions with masses, springs and forces against formulas, a quadrature and each other."""

import ctypes as ct
import math

import numpy as np
import pytest
import scipy
from scipy.integrate import quad
from scipy.sparse.linalg import eigsh

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import full, stiffness, symmetric
from tests.solve.forces.carriers import NOTHING, carrier, law, oscillator

N, MASS, STIFFNESS, SPACING = 1000, 2.0, 5e4, 0.01


def chain(mode=None):
    """A thousand masses between two walls, and springs between them; all move along x."""
    length = (N + 1) * SPACING

    def sine(places):
        out = np.zeros_like(places)
        out[:, 0] = 0.1 * np.sin(mode * np.pi * places[:, 0] / length)
        return out

    scene, beam = carrier(
        N + 1,
        length,
        mass=NOTHING * N * MASS,
        stiffness=NOTHING * STIFFNESS,
        velocity=None if mode is None else sine,
    )
    scene.pin(beam.start)
    scene.pin(beam.end)
    for k in range(1, N + 1):
        scene.add_mass(beam.node(k), MASS)
    for k in range(N + 1):
        scene.spring(beam.node(k), beam.node(k + 1), stiffness=STIFFNESS)
    return scene, beam


def frequency(mode):
    """Of a chain between walls: 2 sqrt(k / m) sin(j pi / 2 (n + 1)) [rad/s]."""
    return 2.0 * math.sqrt(STIFFNESS / MASS) * math.sin(mode * math.pi / (2.0 * (N + 1)))


def test_a_chain_of_a_thousand_masses_has_its_analytic_modes():
    system = System(chain()[0])
    axial = np.unique(np.concatenate([p[:, [0, 2]].ravel() for p in system.places]))
    axial = axial[axial < system.n_free]
    mass = symmetric(system, system.assembly.mass)[axial][:, axial]
    elastic = stiffness(system, system.q0)[axial][:, axial]
    for first in (1, 500, 990):
        sigma = 0.0 if first == 1 else (0.5 * (frequency(first - 1) + frequency(first))) ** 2
        which = "LM" if first == 1 else "LA"
        squares = eigsh(elastic, 8, mass, sigma=sigma, which=which, return_eigenvectors=False)
        expected = [frequency(first + k) for k in range(8)]
        np.testing.assert_allclose(np.sqrt(np.sort(squares)), expected, rtol=1e-9)


@pytest.mark.parametrize("mode", [40, 700])
def test_a_chain_moves_in_its_analytic_mode(mode):
    scene, beam = chain(mode)
    omega = frequency(mode)
    dt = 0.05 / math.sqrt(STIFFNESS / MASS)
    t_end = 200 * dt
    run = ancf.simulate(scene, t_end, dt, integrator=ancf.RungeKuttaNystrom(8), save_every=200)
    assert not run.stats.events
    places = SPACING * np.arange(N + 2)
    shape = 0.1 / omega * np.sin(mode * np.pi * places / ((N + 1) * SPACING))
    expected = shape * math.sin(omega * t_end)
    found = np.array([run.position(beam.node(k))[-1, 0] for k in range(N + 2)]) - places
    assert np.abs(found - expected).max() <= 1e-9 * np.abs(shape).max()


LAW_TYPE = ct.CFUNCTYPE(ct.c_double, ct.c_double)


@pytest.mark.parametrize("compiled", [False, True])
def test_a_nonlinear_spring_swings_as_long_as_a_quadrature_says(compiled):
    speed = 30.0
    function = scipy.LowLevelCallable(LAW_TYPE(law)) if compiled else law
    # 1/2 m v^2 = U(x), U = 1e3 x^2 + 4e5 x^4: how far, and how long a quarter of the period takes.
    energy = 0.5 * 4.0 * speed**2
    square = (-1e3 + math.sqrt(1e6 + 4.0 * 4e5 * energy)) / (2.0 * 4e5)
    far = math.sqrt(square)

    def rate(angle):  # x = far sin(angle): the root at the end of the way cancels
        x = far * math.sin(angle)
        return 1.0 / math.sqrt(2.0 / 4.0 * (1e3 + 4e5 * (far**2 + x**2)))

    quarter, error = quad(rate, 0.0, 0.5 * math.pi, epsabs=1e-14, epsrel=1e-13)
    assert error < 1e-12
    scene, beam = oscillator(speed, function)
    run = ancf.simulate(scene, quarter, accuracy=1e-7)
    # The bar is so stiff that it is a mass: k / EA of it is left.
    assert run.position(beam.start)[-1, 0] == pytest.approx(far, abs=2e-6)
    assert run.energy.drift < 1e-5


def test_a_tip_mass_and_a_rotary_inertia_lower_the_frequency_as_by_hand():
    """A cantilever of no mass: K = EI/l^3 [12, -6l; -6l, 4l^2], M = diag(m, J)."""
    length, mass, inertia = 2.0, 3.0, 1.5
    scene = ancf.Scene(gravity=(0.0, 0.0))
    section = ancf.Rectangle(0.02, 0.02)
    beam = scene.add_beam("l2t2", (0, 0), (length, 0), 1, section, ancf.Material(1e9, 1e-9))
    scene.clamp(beam.start)
    scene.add_mass(beam.end, mass, inertia=inertia)
    system = System(scene)
    stiff, heavy = stiffness(system, system.q0).toarray(), full(system, system.assembly.mass)
    across = system.place(beam.end)[[1, 3]]  # of r and of r_x, which here turns by what it moves
    pairs = np.ix_(across, across)
    found = np.sort(scipy.linalg.eigh(stiff[pairs], heavy[pairs], eigvals_only=True))
    bending = 1e9 * section.inertia_z / length**3
    by_hand = bending * np.array([[12.0, -6.0 * length], [-6.0 * length, 4.0 * length**2]])
    expected = scipy.linalg.eigh(by_hand, np.diag([mass, inertia]), eigvals_only=True)
    np.testing.assert_allclose(found, expected, rtol=1e-8)


def test_a_damper_takes_what_the_formula_says():
    """x = v / w e^(-z t) sin(w t) of a damped oscillator, z = c / 2 m; energy is balanced."""
    speed, stiffness, damping, mass = 0.02, 400.0, 8.0, 4.0
    scene, beam = oscillator(speed, stiffness, damping=damping)
    decay = damping / (2.0 * mass)
    omega = math.sqrt(stiffness / mass - decay**2)
    run = ancf.simulate(scene, 2.0, 1e-3)
    expected = speed / omega * np.exp(-decay * run.t) * np.sin(omega * run.t)
    assert np.abs(run.position(beam.start)[:, 0] - expected).max() < 1e-5 * speed
    assert run.energy.drift < 1e-4
    assert run.energy.dissipated[-1] > 0.9 * run.energy.kinetic[0]


@pytest.mark.parametrize(
    ("integrator", "drift"),
    [
        (ancf.EnergyMomentum(), 1e-9),
        (ancf.GeneralizedAlpha(0.9), 1e-3),
        (ancf.Newmark(0.0), 1e-3),
        (ancf.DormandPrince(), 1e-7),
        (ancf.CentralDifference(), 1e-3),
        (ancf.RungeKuttaNystrom(4), 1e-5),
    ],
)
def test_every_integrator_keeps_the_energy_of_springs_in_motion(integrator, drift):
    """Bars on a linear and a hardening spring turn about and stretch them."""
    scene = ancf.Scene(gravity=(0.0, 0.0))
    section, material = ancf.Rectangle(0.02, 0.02), ancf.Material(1e7, 1000.0)
    beam = scene.add_beam(
        "l2t2", (1, 0), (2, 0), 2, section, material, velocity=lambda x: np.c_[-x[:, 1], x[:, 0]]
    )
    scene.add_mass(beam.end, 1.0)
    scene.spring(beam.start, (0, 0), stiffness=300.0)
    scene.spring(beam.end, (0, 0), stiffness=lambda e: 100.0 * e + 5e3 * e**3)
    step, tolerance = 1e-3, {"tolerance": 1e-9}
    if isinstance(integrator, (ancf.CentralDifference, ancf.RungeKuttaNystrom, ancf.DormandPrince)):
        step, tolerance = 1.0 / math.ceil(2.0 / ancf.stable_step(scene, integrator)), {}
    run = ancf.simulate(scene, 1.0, step, integrator=integrator, **tolerance)
    assert run.energy.drift < drift


def test_stable_step_counts_springs():
    """Two masses on a spring: omega^2 = k (1/m + 1/m), and central differences allow 2 / omega."""
    scene, beam = carrier(1, 0.5, mass=1e-6, stiffness=1e-3)
    for node in (beam.start, beam.end):
        scene.add_mass(node, 2.0)
    before = ancf.stable_step(scene, ancf.CentralDifference())
    scene.spring(beam.start, beam.end, stiffness=1e9)
    assert ancf.stable_step(scene, ancf.CentralDifference()) == pytest.approx(
        2.0 / math.sqrt(1e9), rel=1e-6
    )
    assert before > 1e2 / math.sqrt(1e9)


def test_statics_of_springs_is_where_forces_balance():
    """A weight between two springs in a line: k1 x = k2 (d - x) + m g."""
    scene, beam = carrier(1, 0.5, mass=1e-3, stiffness=1e6, gravity=-10.0)
    scene.add_mass(beam.start, 2.0)
    scene.add_mass(beam.end, 2.0)
    for node, x in ((beam.start, 0.0), (beam.end, 0.5)):
        scene.spring(node, (x, 1.0), stiffness=500.0, length=0.5)
        scene.spring(node, (x, -1.0), stiffness=law, length=1.0)
    rest = ancf.solve_static(scene)
    y = rest.position(beam.start)[1]
    weight = 0.5 * (4.0 + 1e-3) * 10.0
    assert 500.0 * (0.5 - y) - law(y) - weight == pytest.approx(0.0, abs=1e-6)
