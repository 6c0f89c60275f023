"""Runs to an accuracy under loads that jump, against SciPy restarted at each jump."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.system import System
from tests.solve.error_control.accuracy_problems import SECTION, distance, positions


def jumping(damped):
    wet = {"axial_damping": 1e-3, "bending_damping": 1e-2} if damped else {}
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, SECTION, ancf.Material(1e8, 4000.0, **wet))
    scene.pin(rod.start)
    scene.point_force(rod.end, lambda t: (0.0, 3.0 if 0.0731 <= t < 0.1519 else 0.0))
    return scene


def positions_by_scipy(system, times, jumps):
    n, none = system.n_free, np.zeros(system.n_all)
    mass = np.array([system.assembly.inertia(unit)[:n] for unit in np.eye(system.n_all)[:n]])
    inverse = np.linalg.inv(mass)

    def rate(t, y, load):
        q, v = system.q0.copy(), none.copy()
        q[:n], v[:n] = y[:n], y[n:]
        r, _ = system.assembly.residual(q, v, none, np.zeros(0), system.dead_load, load)
        return np.concatenate([y[n:], -inverse @ r[:n]])

    y, rows = np.concatenate([system.q0[:n], system.v0[:n]]), []
    ends = [0.0, *jumps, times[-1]]
    for begin, end in itertools.pairwise(ends):
        load = system.loads.amplitudes(np.array([0.5 * (begin + end)]))[0]
        mine = times[(times >= begin) & (times < end)]
        solved = solve_ivp(
            rate, (begin, end), y, "DOP853", [*mine, end], args=(load,), rtol=1e-9, atol=1e-11
        )
        rows.append(solved.y[:n, :-1])
        y = solved.y[:, -1]
    q = np.tile(system.q0, (len(times), 1))
    q[:, :n] = np.hstack([*rows, y[:n, None]]).T
    return np.concatenate([q[:, p[:, : system.dim]] for p in system.places], axis=1)


@pytest.mark.parametrize("damped", [False, True])
def test_loads_that_jump_cost_no_accuracy(damped):
    # The reference is begun anew at each jump, by SciPy.
    system, times = System(jumping(damped)), np.linspace(0.0, 0.2, 41)
    exact = positions_by_scipy(system, times, (0.0731, 0.1519))
    for accuracy in (1e-4, 1e-6, 1e-8):
        run = ancf.simulate(jumping(damped), 0.2, 0.005, accuracy=accuracy)
        assert distance(positions(run), exact) <= 1.5 * accuracy
        assert run.stats.steps < 15_000


SMOOTH = {
    "ramp": ancf.Ramp((1.0, 0.0), 0.5, smooth=True),
    "two ramps": ancf.Ramp((1.0, 0.0), 0.7, smooth=True)
    - ancf.Ramp((2.0, 0.0), 1.7, 0.6, smooth=True),
    "table": ancf.Table([0, 0.3, 0.9, 1.4], [(0, 0), (2, 0), (-1, 0), (1, 0)], "hold", smooth=True),
}


@pytest.mark.parametrize("signal", SMOOTH)
@pytest.mark.parametrize("slides", [False, True])
def test_higher_derivatives_that_jump_cost_no_accuracy(signal, slides):
    """Errors of a free body were up to 21 times the accuracy, by two motions that agreed."""
    force = SMOOTH[signal]
    scene = ancf.Scene((0.0, 0.0))
    body = scene.add_body(position=(0, 0), mass=1.0, inertia=0.1)
    if slides:
        scene.prismatic(body.origin, axis=(1, 0))
    scene.point_force(body.origin, force)
    ends = np.array(sorted({0.0, *force.time_scale.times, 2.0}))
    x, weights = np.polynomial.legendre.leggauss(8)
    half = 0.5 * np.diff(ends)[:, None]
    times = 0.5 * (ends[1:] + ends[:-1])[:, None] + half * x
    exact = np.sum(half * weights * (2.0 - times) * force(times.ravel())[:, 0].reshape(times.shape))
    for accuracy in (1e-5, 1e-7, 1e-8, 1e-9):
        run = ancf.simulate(scene, 2.0, accuracy=accuracy)
        assert abs(run.position(body.origin)[-1, 0] - exact) < accuracy


def test_the_energy_momentum_method_meets_an_accuracy_under_a_load_that_jumps():
    scene = ancf.Scene((0.0, -9.81))
    beam = scene.add_beam(
        "thin", (0.0, 0.0), (1.0, 0.0), 8, ancf.Circle(0.01), ancf.Material(1e8, 2e3)
    )
    scene.clamp(beam.start)
    scene.point_force(beam.end, ancf.Pulse((0.0, 0.5), 0.0203, 0.0507))
    fine = ancf.simulate(scene, 0.2, 1e-3, accuracy=1e-8, integrator=ancf.RungeKuttaNystrom(8))
    for accuracy in (1e-3, 1e-4, 1e-5):
        run = ancf.simulate(scene, 0.2, 1e-3, accuracy=accuracy, integrator=ancf.EnergyMomentum())
        error = np.abs(run.position(beam.end) - fine.position(beam.end)).max()
        assert 0.01 * accuracy < error < accuracy
