"""Temperatures that change with time: slowly they are static, fast they start waves."""

from __future__ import annotations

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.scene import bodies
from ancfsparse.system import System

LENGTH, SIDE = 1.0, 0.02
SECTION = ancf.Rectangle(SIDE, SIDE)
STEEL = ancf.Material(2.1e11, 7800.0)
AREA, EI = SIDE**2, 2.1e11 * SIDE**4 / 12.0
SPEED = math.sqrt(2.1e11 / 7800.0)
KINDS = [
    ("thin", 2, {"strain": "green"}),
    ("thin", 2, {"strain": "biot"}),
    ("thick", 2, {"curvature": "section"}),
    ("thick", 3, {"curvature": "axis", "section_strain": "nodal"}),
]


def beam(element, dim, n=8, material=STEEL, **options):
    z = (0.0,) * (dim - 1)
    scene = ancf.Scene((0.0, *z))
    rod = scene.add_beam(element, (0.0, *z), (LENGTH, *z), n, SECTION, material, **options)
    return scene, rod


@pytest.mark.parametrize(("element", "dim", "options"), KINDS)
def test_at_each_time_it_is_the_static_eigenstrain_of_that_value(element, dim, options):
    bend = 0.3 if dim == 2 else (0.1, 0.3)
    heat, turn = ancf.Ramp(1e-3, 2.0), ancf.Ramp(bend, 2.0)
    scene, rod = beam(element, dim, 5, eigenstrain=heat, eigencurvature=turn, **options)
    still, other = beam(
        element, dim, 5, eigenstrain=5e-4, eigencurvature=np.multiply(0.5, bend), **options
    )
    scene.clamp(rod.start)
    still.clamp(other.start)
    found, expected = System(scene), System(still)
    q = expected.q_ref + 1e-3 * np.cos(np.arange(expected.n_all))
    loads = found.loads.amplitudes(np.array([1.0]))[0]
    energies = [found.assembly.strain_energy(q, loads), expected.assembly.strain_energy(q)]
    assert energies[0] == pytest.approx(energies[1], rel=1e-12)
    forces = [
        system.assembly.residual(q, 0 * q, 0 * q, np.zeros(0), 0 * q, given)[0]
        for system, given in ((found, loads), (expected, np.zeros(0)))
    ]
    np.testing.assert_allclose(forces[0], forces[1], rtol=1e-11, atol=1e-9 * np.abs(forces).max())


def test_slow_heat_bends_a_strip_as_statics_does():
    turn = ancf.Ramp(0.5, 1.0, smooth=True)
    scene, rod = beam("thin", 2, 6, eigencurvature=turn, strain="biot")
    scene.clamp(rod.start)
    run = ancf.simulate(scene, 1.0, 0.005)
    for row in (100, 200):
        angle = float(turn(run.t[row])) * LENGTH
        arc = np.array([math.sin(angle), 1.0 - math.cos(angle)]) / angle
        np.testing.assert_allclose(run.position(rod.end)[row], arc, atol=1e-4)
    # Free to bend, it takes up no moment, and the heat does no work but for the small motion.
    assert np.abs(run.section_force(rod).M[-1]).max() < 2e-3 * EI * 0.5
    assert abs(run.energy.work[-1]) < 1e-4 * 0.5 * EI * 0.25


def test_fast_heat_makes_a_cantilever_swing_about_its_new_shape():
    # Sudden eigencurvature: static part kappa x^2 / 2, and every mode rings about it with the
    # frequency of the beam; the tip reaches twice the static deflection of the first mode.
    kappa = 1e-3
    scene, rod = beam("thin", 2, 12, eigencurvature=ancf.Ramp(kappa, 1e-6), strain="biot")
    scene.clamp(rod.start)
    mass = 7800.0 * AREA
    k = np.array([1.87510407, 4.69409113, 7.85475744, 10.99554073])
    omega = k**2 * math.sqrt(EI / mass) / LENGTH**2
    x = np.linspace(0.0, 1.0, 20001)
    run = ancf.simulate(scene, 0.06, 2e-5, integrator=ancf.Newmark(0.0), save_every=10)
    tip = np.full(len(run.t), kappa / 2.0)
    for each, w in zip(k, omega, strict=True):
        ratio = (math.cosh(each) + math.cos(each)) / (math.sinh(each) + math.sin(each))
        shape = (
            np.cosh(each * x) - np.cos(each * x) - ratio * (np.sinh(each * x) - np.sin(each * x))
        )
        share = np.trapezoid(shape * kappa * x**2 / 2.0, x) / np.trapezoid(shape**2, x)
        tip -= share * shape[-1] * np.cos(w * run.t)
    np.testing.assert_allclose(run.position(rod.end)[:, 1], tip, atol=0.02 * kappa / 2.0)


def test_a_rod_heated_at_once_sends_a_wave_from_its_free_end():
    # Held at one end; without stress it would be longer by e x.  Then u = e x - sum of waves:
    # the end moves with the speed e c until the wave is back, as long as 2 L / c.
    strain = 1e-4
    scene, rod = beam("thin", 2, 200, eigenstrain=ancf.Ramp(strain, 1e-7), strain="biot")
    scene.clamp(rod.start, stretch="free")
    back = 2.0 * LENGTH / SPEED
    run = ancf.simulate(scene, 1.5 * back, back / 800, integrator=ancf.Newmark(0.0))
    x = run.position(rod.end)[:, 0] - LENGTH
    n = np.arange(1, 400, 2)
    wave = (
        8.0
        / math.pi**2
        * np.sum(np.cos(np.outer(run.t, n) * math.pi * SPEED / (2.0 * LENGTH)) / n**2, axis=1)
    )
    np.testing.assert_allclose(x, strain * LENGTH * (1.0 - wave), atol=0.02 * strain * LENGTH)
    assert x.max() == pytest.approx(2.0 * strain * LENGTH, rel=0.02)


@pytest.mark.parametrize(
    "integrator", [ancf.GeneralizedAlpha(0.9), ancf.Newmark(0.0), ancf.DormandPrince()], ids=repr
)
def test_the_power_of_heat_balances_the_energy_to_second_order(integrator):
    drifts = []
    for dt in (4e-6, 2e-6):
        heat = ancf.Sine(1e-3, 400.0)
        scene, rod = beam("thin", 2, 4, eigenstrain=heat, eigencurvature=ancf.Sine(0.2, 300.0))
        scene.clamp(rod.start)
        scene.pin(rod.end)
        run = ancf.simulate(scene, 4e-4, dt, integrator=integrator)
        drifts.append(run.energy.drift)
        assert run.energy.work[-1] > 0.1
    assert drifts[1] < 1e-2
    if isinstance(integrator, ancf.Newmark):
        assert 3.0 < drifts[0] / drifts[1] < 5.0


def test_reactions_and_section_forces_are_those_of_the_time():
    scene, rod = beam("thin", 2, 8, eigenstrain=ancf.Ramp(-1e-4, 0.1, smooth=True), strain="biot")
    scene.clamp(rod.start)
    scene.pin(rod.end)
    run = ancf.simulate(scene, 0.1, 1e-3)
    pull = -np.asarray(ancf.Ramp(-1e-4, 0.1, smooth=True)(run.t)) * 2.1e11 * AREA
    np.testing.assert_allclose(run.section_force(rod, 0.5).N[:, 0], pull, atol=0.01 * pull[-1])
    np.testing.assert_allclose(run.reaction(rod.end)[:, 0], pull, atol=0.01 * pull[-1])
    # Work stored: EA e^2 L / 2.
    stored = 0.5 * 2.1e11 * AREA * 1e-8 * LENGTH
    assert run.energy.work[-1] == pytest.approx(stored, rel=1e-2)
    assert run.energy.elastic[-1] == pytest.approx(stored, rel=1e-2)


def test_section_forces_of_many_states_need_few_evaluations_of_strains(monkeypatch):
    calls, strained_ends = [], bodies.strained_ends
    monkeypatch.setattr(
        bodies, "strained_ends", lambda *given: calls.append(1) or strained_ends(*given)
    )
    scene, rod = beam("thin", 2, 4, eigenstrain=ancf.Sine(1e-4, 3.0), strain="biot")
    scene.clamp(rod.start)
    run = ancf.simulate(scene, 0.1, 1e-3)
    calls.clear()
    run.section_force(rod, [0.3, 0.7])
    assert 0 < len(calls) < 10 < len(run.t)


def test_heat_buckles_a_pinned_beam_at_eulers_load():
    # N = -E A e reaches pi^2 EI / L^2 at e = pi^2 I / (A L^2).
    heat = ancf.Table([0.0, 1.0], [2e-5, 2e-5], outside="hold")
    scene, rod = beam("thin", 2, 16, eigenstrain=heat, strain="biot")
    scene.pin(rod.start)
    scene.pin(rod.end)
    critical = math.pi**2 * SIDE**2 / 12.0
    assert ancf.buckling(scene, 1).factors[0] * 2e-5 == pytest.approx(critical, rel=1e-5)


def test_bad_signals():
    with pytest.raises(ancf.InputError, match="must be a signal of a number"):
        beam("thin", 2, eigenstrain=ancf.Ramp((1.0, 2.0), 1.0))
    with pytest.raises(ancf.InputError, match="must be a signal of two numbers"):
        beam("thick", 3, eigencurvature=ancf.Ramp(1.0, 1.0))
    with pytest.raises(ancf.InputError, match="made of 'l2t2'"):
        beam("l2t2", 2, eigencurvature=ancf.Ramp(1.0, 1.0))
    scene, rod = beam("thin", 2, eigenstrain=ancf.Ramp(-2.0, 1.0))
    scene.clamp(rod.start)
    with pytest.raises(ancf.LoadError, match="above -1, the strain of zero length"):
        ancf.simulate(scene, 1.0, 0.01)
