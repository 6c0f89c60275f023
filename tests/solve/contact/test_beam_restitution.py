"""Impacts of beams on each other with a coefficient of restitution, against its definition."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from ancfsparse.system.contributions.force_elements.contact_steps import (
    RESTITUTION_STEPS,
    SLOW_RATIO,
)
from tests.matrices import derivative_of_step, full
from tests.solve.contact.friction.test_beam_bristles import rod_on_rails
from tests.solve.contact.friction.test_beam_friction_motion import momenta
from tests.solve.contact.test_beam_impacts import LINE_MASS, MATERIAL, RADIUS, SECTION

INTEGRATORS = [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9), ancf.Newmark(0.0)]
RIGID = ancf.Material(1e15, MATERIAL.density)


def longest_step(stiffness, restitution):
    """Of two equal lines, whose reduced mass is half of the mass of each."""
    return math.pi * math.sqrt(0.5 * LINE_MASS / stiffness) * restitution / RESTITUTION_STEPS


def meet(restitution, stiffness, angle, speed, gap, material=MATERIAL, **options):
    """A cable that moves onto another one, whose middle is below its own; both are free."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 4, SECTION, material)
    along = 0.5 * np.array([math.cos(angle), math.sin(angle), 0.0])
    middle, velocity = np.array([0, 0, 2.0 * RADIUS + gap]), (0, 0, -speed)
    upper = scene.add_beam(
        "thin", middle - along, middle + along, 4, SECTION, material, velocity=velocity
    )
    options = {"stiffness": stiffness, "restitution": restitution, **options}
    return scene, (lower, upper), scene.contact(lower, upper, **options)


def separation_speed(run, beams, speed):
    velocities = [run.velocity(each.at(0.5))[-1, 2] for each in beams]
    return (velocities[1] - velocities[0]) / speed


@pytest.mark.parametrize("integrator", INTEGRATORS, ids=repr)
@pytest.mark.parametrize("restitution", [0.25, 0.5, 0.9])
def test_lines_separate_with_the_speed_of_the_restitution_within_a_percent(restitution, integrator):
    """With the longest steps, in all phases; half of the energy, of the mean speed, remains."""
    for stiffness, speed in ((1e5, 1.0), (1e7, 1.0), (1e9, 10.0)):
        for phase in np.arange(4) / 4:
            dt = longest_step(stiffness, restitution)
            scene, beams, _ = meet(restitution, stiffness, 0.0, speed, (2.0 + phase) * speed * dt)
            steps = math.ceil(1.5 * RESTITUTION_STEPS / restitution**2 + 10)
            run = ancf.simulate(scene, steps * dt, dt, integrator=integrator)
            returned, energy = separation_speed(run, beams, speed), run.energy
            assert returned == pytest.approx(restitution, rel=1e-2)
            lost = energy.impact_damping[-1] / energy.total[0]
            closed = 2e-6 if integrator.keeps_energy else 2e-2
            assert lost == pytest.approx(0.5 * (1.0 - returned**2), abs=closed)
            held = energy.total + energy.lost
            assert np.abs(held - held[0]).max() < closed * energy.total[0]
            assert np.diff(energy.impact_damping).min() >= 0.0


@pytest.mark.parametrize("integrator", INTEGRATORS[:2], ids=repr)
@pytest.mark.parametrize("angle", [0.3, 0.5 * math.pi])
@pytest.mark.parametrize("restitution", [0.25, 0.5, 0.8])
def test_rigid_rods_that_cross_follow_the_impact_of_two_masses(restitution, angle, integrator):
    """Speeds (1 - eps)/2 and (1 + eps)/2 of that before; such impacts are far longer."""
    stiffness, speed = 1e5, 0.3
    dt = longest_step(stiffness, restitution)
    scene, beams, contact = meet(restitution, stiffness, angle, speed, 1e-5, RIGID)
    steps = math.ceil((0.25 + 0.02 / restitution) / dt)
    run = ancf.simulate(scene, steps * dt, dt, integrator=integrator)
    touches = np.count_nonzero(run.contact_force(contact).size)
    assert touches > 4 * RESTITUTION_STEPS / restitution
    speeds = [-run.velocity(each.at(0.5))[-1, 2] / speed for each in beams]
    expected = [0.5 * (1.0 + restitution), 0.5 * (1.0 - restitution)]
    np.testing.assert_allclose(speeds, expected, rtol=5e-3)
    assert run.energy.total[-1] / run.energy.total[0] == pytest.approx(
        0.5 * (1.0 + restitution**2), rel=2e-3
    )
    change = momenta(run, -1)[:3] - momenta(run, 0)[:3]
    assert np.abs(change).max() < 1e-9 * np.abs(momenta(run, 0)[2])


def test_a_restitution_of_one_gives_back_all():
    """Also where soft cables vibrate and touch askew, with friction or without."""
    for friction in (0.0, 0.3):
        scene, _, contact = meet(1.0, 1e6, 1.0, 2.0, 2e-3, friction=friction)
        run = ancf.simulate(scene, 0.02, 1e-4, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
        energy = run.energy
        assert run.contact_force(contact).size.max() > 1.0
        assert not energy.impact_damping.any()
        held = energy.total + energy.friction
        assert np.abs(held - held[0]).max() < 1e-10 * energy.total[0]


@pytest.mark.parametrize("friction", [{}, {"friction": 0.3}, {"friction": 0.3, "slip_speed": 0.05}])
def test_soft_cables_keep_momentum_and_what_they_lose_is_in_the_balance(friction):
    scene, *_ = meet(0.5, 1e6, 1.0, 2.0, 2e-3, **friction)
    scene = scene.replaced(scene.beams[1], velocity=(1.0, 0.5, -2.0))
    integrator = ancf.EnergyMomentum()
    run = ancf.simulate(scene, 0.01, 5e-5, integrator=integrator, tolerance=1e-12)
    energy = run.energy
    assert energy.drift < 1e-9
    assert energy.impact_damping[-1] > 0.01 * energy.total[0]
    assert np.diff(energy.impact_damping).min() >= 0.0
    change = momenta(run, -1)[:3] - momenta(run, 0)[:3]
    assert np.abs(change).max() < 1e-11 * np.abs(momenta(run, 0)[:3]).max()
    sparse = ancf.simulate(scene, 0.01, 5e-5, integrator=integrator, save_every=2).energy
    assert sparse.impact_damping[-1] == pytest.approx(energy.impact_damping[-1], rel=0.05)


@pytest.mark.parametrize(
    "options",
    [{"dt": 2e-3, "accuracy": 1e-5}, {"dt": 2e-5, "integrator": ancf.DormandPrince()}],
    ids=["accuracy", "explicit"],
)
def test_other_methods_return_the_same_speed(options):
    scene, beams, _ = meet(0.5, 1e5, 0.0, 1.0, 1e-3)
    run = ancf.simulate(scene, 0.02, **options)
    assert separation_speed(run, beams, 1.0) == pytest.approx(0.5, rel=1e-2)


def test_forces_in_saved_states_contain_the_damping(tmp_path):
    """k e per length, times 1 + gamma in compression and 1 - gamma in restitution."""
    eps, stiffness = 0.5, 1e5
    scene, beams, contact = meet(eps, stiffness, 0.0, 1.0, 1e-3)
    run = ancf.simulate(scene, 0.02, 5e-5, output=tmp_path / "run.h5")
    heights, speeds = (
        each(beams[1].at(0.5))[:, 2] - each(beams[0].at(0.5))[:, 2]
        for each in (run.position, run.velocity)
    )
    depth, touches = 2.0 * RADIUS - heights, heights < 2.0 * RADIUS
    rate = math.sqrt(2.0 * stiffness / LINE_MASS)
    s = -speeds[touches] / (SLOW_RATIO * eps * rate * depth[touches])
    gamma = (1 - eps**2) / (1 + eps**2)
    force = run.contact_force(contact)
    expected = stiffness * depth[touches] * (1.0 + gamma * np.tanh(s))
    assert np.ptp(np.tanh(s)) > 1.99
    np.testing.assert_allclose(
        force.size[touches], expected, rtol=2e-2, atol=1e-2 * force.size.max()
    )
    k = int(np.argmax(force.size))
    normal = sum(each.normal_force for each in run.contacts(run.t[k]))
    assert normal == pytest.approx(force.size[k], rel=1e-9)
    stored = ancf.load(tmp_path / "run.h5", scene)
    assert np.array_equal(stored.contact_force(contact).size, force.size)


def test_a_rod_that_slides_is_not_braked():
    """Points at its front approach the rail, and points behind separate from it."""
    scene, *_, weight = rod_on_rails(0.0, 0.0, 0.3, restitution=0.5)
    run = ancf.simulate(scene, 0.05, 5e-6, integrator=ancf.GeneralizedAlpha(0.5))
    lost = momenta(run, 0)[0] - momenta(run, -1)[0]
    assert abs(lost) < 2e-3 * 0.05 * weight


@pytest.mark.parametrize("integrator", INTEGRATORS[:2], ids=repr)
@pytest.mark.parametrize("angle", [0.0, 1.0])
def test_the_matrix_of_a_step_is_the_derivative(integrator, angle):
    """By a displacement of the upper cable, near the deepest point, where the speed matters."""
    scene, *_ = meet(0.5, 1e5, angle, 1e-3, -4e-4)
    system = System(scene)
    march, *_ = prepare_implicit(system, 1e-4, integrator, ancf.Newton(), 1e-9, math.inf)
    march.prepare(np.zeros((1, 0)))
    n, up = system.n_free, np.zeros(system.n_free)
    up[system.vectors("r")[1][:, 2]] = 1.0
    change = up @ derivative_of_step(march, n, 1e-10) @ up
    march.residual()
    own = march.matrix()[: len(system.pattern.indices)]  # without the blocks of both cables
    assert up @ full(system, own)[:n, :n] @ up == pytest.approx(change, rel=1e-4)
    assert change > 1.005 * LINE_MASS


def test_a_run_in_two_parts_is_one_run_bit_for_bit():
    options = {"integrator": ancf.GeneralizedAlpha(0.9), "solver": ancf.Newton()}

    def made():
        return meet(0.5, 1e6, 1.0, 2.0, 2e-3, friction=0.2, static_friction=0.4)[0]

    whole = ancf.simulate(made(), 0.01, 5e-5, **options)
    scene = made()
    first = ancf.simulate(scene, 0.0016, 5e-5, **options)  # in the impact
    assert first.contact_force(scene.attachments[0]).size[-1] > 0.0
    second = ancf.simulate(scene, 0.01, 5e-5, start=first.last, **options)
    assert np.array_equal(second.q[-1], whole.q[-1])


def test_a_saved_scene_has_its_restitution(tmp_path):
    scene = meet(0.5, 1e5, 1.0, 1.0, 1e-3)[0]
    scene.save(tmp_path / "scene.json")
    again = ancf.Scene.load(tmp_path / "scene.json")
    assert again.digest() == scene.digest() != meet(0.6, 1e5, 1.0, 1.0, 1e-3)[0].digest()
    assert again.attachments[0].restitution == 0.5
    assert str(again) == str(scene) != str(meet(0.6, 1e5, 1.0, 1.0, 1e-3)[0])


def test_steps_that_do_not_resolve_an_impact_are_refused():
    scene = meet(0.5, 1e5, 0.0, 1.0, 1e-3)[0]
    dt = longest_step(1e5, 0.5)
    with pytest.raises(
        ancf.InputError, match=rf"restitution of 0.5 needs a dt of at most {dt:.3g}"
    ):
        ancf.simulate(scene, 0.1, 1e-3)
    ancf.simulate(scene, 4 * dt, dt)


@pytest.mark.parametrize(
    ("value", "message"),
    [(0.0, "must be positive"), (1.5, "at most 1, got 1.5"), ("a", "restitution of the contact")],
)
def test_other_numbers_are_refused(value, message):
    with pytest.raises(ancf.InputError, match=message):
        meet(value, 1e5, 0.0, 1.0, 1e-3)
