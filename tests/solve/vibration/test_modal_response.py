"""Sums of modes: exact for oscillators, and what they lose beside motions in time."""

import numpy as np
import pytest

import ancfsparse as ancf
from tests.beams import build_beam

SECTION = ancf.Rectangle(0.01, 0.01)
MATERIAL = ancf.Material(youngs_modulus=2e9, density=1000.0)


def oscillator(load, velocity=0.0):
    """A mass of 2 kg on a spring of 50 N/m along x: 5 rad/s."""
    scene = ancf.Scene(gravity=(0.0, 0.0, 0.0))
    body = scene.add_body(
        mass=2.0, inertia=np.eye(3), position=(1, 0, 0), velocity=(velocity, 0, 0)
    )
    scene.prismatic(body.origin, axis=(1, 0, 0))
    scene.spring(body.origin, (0, 0, 0), stiffness=50.0)
    scene.point_force(body.origin, load)
    return scene, body.origin


@pytest.mark.parametrize("damping", [0.0, 0.3, 1.0, 2.0])
def test_an_oscillator_is_exact_under_loads_linear_in_pieces(damping):
    """Steps of 0.7 s, of more than half a period, beside an integrator with tiny steps."""
    from scipy.integrate import solve_ivp

    table = ancf.Table([0.0, 0.7, 1.4, 3.5], [(0, 0, 0), (8, 0, 0), (-3, 0, 0), (5, 0, 0)])
    scene, mass = oscillator(table)
    run = ancf.modal_response(ancf.modes(scene, 1), 3.5, 0.7, damping=damping)

    def rate(t, state):
        force = float(table(t)[0])
        return [state[1], force / 2.0 - 25.0 * state[0] - 10.0 * damping * state[1]]

    exact = solve_ivp(rate, (0.0, 3.5), (0.0, 0.0), rtol=1e-11, atol=1e-13, t_eval=run.t,
                      max_step=0.05)  # fmt: skip
    np.testing.assert_allclose(run.position(mass)[:, 0] - 1.0, exact.y[0], atol=1e-8)
    np.testing.assert_allclose(run.velocity(mass)[:, 0], exact.y[1], atol=1e-7)


def cantilever(size, **options):
    """A beam that sags under its weight by a third of its length, and is pushed at its end."""
    material = ancf.Material(2e9, 1000.0, **options)
    scene, beam = build_beam("thin", (0, 0), (1, 0), 8, SECTION, material, "clamp")
    scene.point_force(beam.end, lambda t: (0.0, -size * np.sin(np.pi * t) ** 2))
    return ancf.solve_static(scene), beam.end


@pytest.mark.parametrize("size", [1e-3, 1e-2, 1e-1])
def test_what_linearity_loses_is_predicted(size):
    rest, end = cantilever(size)
    run = ancf.modal_response(ancf.modes(rest, 10), 1.0, 0.002)
    whole = ancf.simulate(rest.system.scene, 1.0, 1e-4, save_every=20, start=rest)
    off = np.linalg.norm(run.position(end) - whole.position(end), axis=1).max()
    moved = np.linalg.norm(np.ptp(whole.position(end), axis=0))
    assert off < 0.02 * moved
    assert 0.5 * off < run.stats.error < 2.0 * off
    # Of second order, here a half of the square of the share of the length that it moves.
    assert run.stats.error == pytest.approx(0.48 * moved**2, rel=0.1)


def test_the_damping_of_the_scene_is_taken_unless_ratios_are_given():
    rest, end = cantilever(1e-3, rayleigh=(2.0, 1e-3))
    modes = ancf.modes(rest, 10)
    whole = ancf.simulate(rest.system.scene, 2.0, 1e-3, save_every=10, start=rest)
    by_default = ancf.modal_response(modes, 2.0, 0.01).position(end)
    np.testing.assert_allclose(by_default, whole.position(end), atol=3e-6)
    same = ancf.modal_response(modes, 2.0, 0.01, damping=modes.damping).position(end)
    np.testing.assert_allclose(same, by_default, atol=1e-12)
    without = ancf.modal_response(modes, 2.0, 0.01, damping=0.0).position(end)
    assert np.abs(without - by_default).max() > 1e-5


def test_unbalanced_forces_and_velocities_of_the_state_set_it_in_motion():
    """From t = 0.1 s on, in the middle of a vibration about the new equilibrium at 0.2 m."""
    scene, mass = oscillator((10.0, 0.0, 0.0), velocity=0.4)
    begin = ancf.simulate(scene, 0.1, dt=1e-5, save_every=10000).last
    run = ancf.modal_response(ancf.modes(scene, 1, at=begin), 2.1, 0.5)
    x = 0.2 * (1.0 - np.cos(5.0 * run.t)) + 0.08 * np.sin(5.0 * run.t)
    np.testing.assert_allclose(run.position(mass)[:, 0] - 1.0, x, atol=1e-8)
    assert run.stats.error < 1e-12


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"modes": 3}, "needs the modes of a scene"),
        ({"dt": 0.3}, "does not divide"),
        ({"damping": -0.1}, r"a ratio from 0 to 1e\+100, or 1 of them"),
        ({"damping": [0.1, 0.2]}, r"a ratio from 0 to 1e\+100, or 1 of them"),
        ({"damping": np.inf}, r"a ratio from 0 to 1e\+100"),
    ],
)
def test_what_is_invalid_is_refused(change, words):
    modes = ancf.modes(oscillator((0, 0, 0))[0], 1)
    with pytest.raises(ancf.InputError, match=words):
        ancf.modal_response(**({"modes": modes, "t_end": 1.0, "dt": 0.1} | change))


def test_drives_are_refused():
    scene = ancf.Scene(gravity=(0.0, 0.0))
    beam = scene.add_beam("thin", (0, 0), (1, 0), 4, SECTION, MATERIAL)
    scene.clamp(beam.start)
    scene.drive(beam.end, lambda t: (1.0, 0.01 * t**3))
    with pytest.raises(ancf.InputError, match="takes no prescribed motions"):
        ancf.modal_response(ancf.modes(scene, 2), 1.0, 0.1)
