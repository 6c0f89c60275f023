"""Wheels under generalised-alpha: a loss of third order, and a root that rotation drives out."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import andrews, four_bar, heavy_top, spatial_pendulum


def step(x, scheme):
    """One step of length 1 for u, v, a, b of a wheel; the constraint is solved exactly."""
    u, v, a, b = x.reshape(4, 2)
    m, f = scheme.alpha_m, scheme.alpha_f
    share = scheme.beta / (1.0 - m)
    w = u + v + (0.5 - scheme.beta) * b + share * (f * a - m * b)
    size = np.linalg.norm(w)
    u1 = w / size
    a1 = -(size - 1.0) / (share * (1.0 - f)) * u1
    b1 = ((1.0 - f) * a1 + f * a - m * b) / (1.0 - m)
    return np.concatenate([u1, v + (1.0 - scheme.gamma) * b + scheme.gamma * b1, a1, b1])


def rotation(theta, scheme):
    """Steady rotation by theta [rad] in a step, and the phase that it lacks."""
    m, f, gamma, beta = scheme.alpha_m, scheme.alpha_f, scheme.gamma, scheme.beta
    e = np.exp(1j * theta)
    lag = ((1.0 - f) * e + f) / ((1.0 - m) * e + m)
    push = 1.0 - gamma + gamma * e + (0.5 - beta + beta * e) * (e - 1.0)
    mu = -((e - 1.0) ** 2 / (lag * push)).real
    b = -mu * lag
    v = b * (1.0 - gamma + gamma * e) / (e - 1.0)
    x = np.array([1.0, 0.0, v.real, v.imag, -mu, 0.0, b.real, b.imag])
    return x, np.angle(lag * push / e)


def alternating(theta, scheme):
    """Size of the most negative root of a step about steady rotation."""
    x, _ = rotation(theta, scheme)
    c, s = np.cos(theta), np.sin(theta)
    back = np.kron(np.eye(4), [[c, s], [-s, c]])
    columns = [
        (step(x + d, scheme) - step(x - d, scheme)) / 2e-6 for d in 1e-6 * np.eye(8)
    ]  # fmt: skip
    return -np.min(np.linalg.eigvals(back @ np.array(columns).T).real)


@pytest.mark.parametrize(
    ("rho", "limit"), [(0.95, 0.035), (0.9, 0.072), (0.8, 0.152), (0.5, 0.448), (0.3, 0.716)]
)
def test_rotation_drives_the_root_of_constraints_out(rho, limit):
    """The table of docs/theory.md."""
    scheme = ancf.GeneralizedAlpha(rho)
    assert alternating(1e-6, scheme) == pytest.approx(rho, abs=2e-3)
    assert alternating(limit - 2e-3, scheme) < 1.0 < alternating(limit + 2e-3, scheme)


def wheel(speed):
    scene = ancf.Scene((0.0, -9.81))
    body = scene.add_body(mass=1.0, inertia=0.5, position=(0, 0), angular_velocity=speed)
    scene.pin(body.origin)
    return scene, body


def test_runs_follow_these_roots():
    """At 0.06 rad a step 4000 of them are calm, at 0.09 the check of the energy stops the run.

    The default is another method there.
    """
    scene, body = wheel(6.0)
    run = ancf.simulate(scene, 40.0, 0.01, save_every=100, tolerance=1e-13)
    assert run.settings["integrator"] == "GeneralizedAlpha(rho_inf=0.9)"
    speed = run.body(body).angular_velocity
    assert np.all(np.diff(speed) < 1e-12)
    scene, _ = wheel(9.0)
    scheme = ancf.GeneralizedAlpha(0.9)
    with pytest.raises(ancf.EnergyIncreaseError):
        ancf.simulate(scene, 40.0, 0.01, save_every=100, tolerance=1e-13, integrator=scheme)
    run = ancf.simulate(scene, 40.0, 0.01, save_every=100, tolerance=1e-13)
    assert run.settings["integrator"] == "EnergyMomentum()"
    assert np.ptp(run.energy.total) < 1e-9 * run.energy.total[0]


@pytest.mark.parametrize("rho", [0.9, 0.5])
def test_the_loss_of_energy_is_that_of_the_phase(rho):
    scheme, theta = ancf.GeneralizedAlpha(rho), 0.05
    scene, body = wheel(5.0)
    run = ancf.simulate(scene, 10.0, 0.01, integrator=scheme, tolerance=1e-13)
    speed = run.body(body).angular_velocity
    lost = 1.0 - (speed[-1] / speed[200]) ** 2
    _, phase = rotation(theta, scheme)
    assert lost == pytest.approx(2.0 * theta * phase * 800, rel=0.02)


@pytest.mark.parametrize("integrator", [ancf.EnergyMomentum(), ancf.CentralDifference()], ids=repr)
def test_others_keep_a_fast_wheel(integrator):
    """0.5 rad in a step."""
    scene, body = wheel(50.0)
    run = ancf.simulate(scene, 10.0, 0.01, integrator=integrator)
    np.testing.assert_allclose(run.body(body).angular_velocity, 50.0, rtol=1e-6)


@pytest.mark.parametrize(
    ("problem", "t_end", "dt"),
    [
        (four_bar, 5.0, 2e-3),  # from rest
        (spatial_pendulum, 4.0, 2e-3),
        (heavy_top, 0.5, 4e-4),
        (andrews, 0.05, 2e-5),
    ],
)
@pytest.mark.parametrize("integrator", [ancf.Newmark(0.0), ancf.GeneralizedAlpha(1.0)], ids=repr)
def test_undamped_integrators_restart_before_forces_alternate(problem, t_end, dt, integrator):
    """They stopped after .1 to 4 s, with multipliers 3 to 700 times as large as the exact ones."""
    position_errors, force_errors = [], []
    scene = problem().scene
    exact = ancf.simulate(scene, t_end, 0.5 * dt, integrator=ancf.DormandPrince())
    largest = np.abs(exact.lam).max()
    for every in (2, 1):
        run = ancf.simulate(scene, t_end, 0.5 * dt * every, integrator=integrator, tolerance=1e-9)
        position_errors.append(np.abs(run.q - exact.q[::every]).max())
        force_errors.append(np.abs(run.lam - exact.lam[::every]).max() / largest)
    assert position_errors[1] < position_errors[0] / 3.0
    assert force_errors[1] < force_errors[0] / 1.5 < 2e-2
