"""What the iteration leaves of the balance of stiff bodies does no work that shows."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.problems import chain, net, pendulum
from ancfsparse.solve.judge import Judge, stiffest
from ancfsparse.system import System

DAMPED = ancf.GeneralizedAlpha(0.8)
STEEL = 2.1e11
CABLE = ancf.Rectangle(0.01, 0.01)


def falling(youngs_modulus, hung, element="thin"):
    scene, rod = pendulum(element, youngs_modulus=youngs_modulus)
    if hung:
        scene.rod(rod.end, (2.0, 1.0, 0.0)[: scene.dim])
    return scene


def gained(scene, t_end, dt, integrator=DAMPED, **options):
    """Energy above that at the start, over the largest kinetic energy, and the counts."""
    options = {"save_every": max(1, round(t_end / dt) // 200)} | options
    run = ancf.simulate(scene, t_end, dt, integrator=integrator, **options)
    energy = run.energy
    return (energy.total - energy.total[0]) / energy.kinetic.max(), run.stats


@pytest.mark.parametrize("hung", [False, True])
@pytest.mark.parametrize("dt", [5e-4, 1e-3, 2e-3, 4e-3])
def test_steel_under_a_damped_scheme_loses_what_exact_steps_lose(dt, hung):
    energy, stats = gained(falling(STEEL, hung), 30.0, dt)
    exact, _ = gained(falling(STEEL, hung), 30.0, dt, tolerance=1e-7)
    assert exact[-1] < 0.0
    assert energy[-1] == pytest.approx(exact[-1], rel=0.05, abs=1e-6)
    assert energy.max() < 1e-6
    assert stats.recoveries == 0
    assert stats.iterations < 3.6 * stats.steps


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.GeneralizedAlpha(0.5),
                                        ancf.HHT(0.05)], ids=repr)  # fmt: skip
def test_so_does_every_damped_scheme(integrator):
    energy, _ = gained(falling(STEEL, True), 20.0, 2e-3, integrator)
    exact, _ = gained(falling(STEEL, True), 20.0, 2e-3, integrator, solver=ancf.Newton())
    assert energy[-1] == pytest.approx(exact[-1], rel=0.1)


@pytest.mark.parametrize("update", ["broyden", "davidon", "dfp", "bfgs"])
def test_so_does_every_update(update):
    energy, _ = gained(falling(STEEL, True), 20.0, 2e-3, solver=ancf.QuasiNewton(update, 10))
    exact, _ = gained(falling(STEEL, True), 20.0, 2e-3, tolerance=1e-7)
    assert energy[-1] == pytest.approx(exact[-1], rel=0.1)


@pytest.mark.parametrize(("youngs_modulus", "dt"), [(1e9, 5e-3), (1e10, 1e-3), (1e10, 4e-3)])
@pytest.mark.parametrize("hung", [False, True])
def test_nothing_is_gained_between_soft_and_stiff(youngs_modulus, dt, hung):
    side = 2.0 * np.array([math.sin(0.5), -math.cos(0.5)])
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), side, 10, CABLE, ancf.Material(youngs_modulus, 4000.0))
    scene.pin(rod.start)
    if hung:
        scene.rod(rod.end, (side[0], side[1] + 1.0))
    energy, _ = gained(scene, 30.0, dt)
    assert energy.max() < 1e-6
    assert energy[-1] < 0.0


def test_runs_to_an_accuracy_gain_nothing_either():
    run = ancf.simulate(falling(STEEL, True), 10.0, accuracy=1e-2, integrator=DAMPED)
    energy = run.energy
    assert (energy.total - energy.total[0]).max() < 1e-5 * energy.kinetic.max()


@pytest.mark.parametrize("hung", [False, True])
@pytest.mark.parametrize("tolerance", [1e-2, 1e-4])
def test_a_number_bounds_the_forces_of_stiff_bodies(tolerance, hung):
    run = ancf.simulate(falling(STEEL, hung), 1.0, 2e-3, integrator=DAMPED, tolerance=tolerance)
    system = run.system
    free = np.arange(system.n_free)
    worst = max(
        np.abs(system.assembly.residual(q, v, a, lam, system.dead_load, np.zeros(0))[0][free]).max()
        for q, v, a, lam in zip(run.q[1:], run.v[1:], run.a[1:], run.lam[1:], strict=True)
    )
    places = system.places[0][:, :2]
    mass = system.mass_diagonal[places[places < system.n_free]].mean()
    # One more correction may follow the judgement.
    assert worst <= 1.1 * tolerance * mass + 8.0 * EPSILON * system.force_scale(system.q0)


def judged_by_forces(scene, dt, method, integrator=DAMPED, tolerance="default"):
    return not Judge(System(scene), integrator, method, tolerance).at(dt).by_correction


SAVING, LEARNING = ancf.ModifiedNewton(), ancf.QuasiNewton("broyden", 10)


@pytest.mark.parametrize("dt", [1e-4, 5e-4, 2e-3])
def test_soft_bodies_save_the_last_residual(dt):
    soft = [falling(1e8, False), falling(1e8, True), falling(1e8, False, "thick"),
            chain(50).scene, chain(50, "rough").scene, net(6).scene]  # fmt: skip
    for scene in soft:
        assert not judged_by_forces(scene, dt, SAVING)
        assert not judged_by_forces(scene, dt, LEARNING)


def test_who_is_judged_by_forces():
    stiff = falling(STEEL, False)
    assert judged_by_forces(stiff, 5e-4, SAVING)
    assert judged_by_forces(stiff, 5e-4, LEARNING)
    assert not judged_by_forces(stiff, 5e-5, SAVING)  # a step that follows the waves
    # Their last error is squared, or corrected once more.
    exact = (ancf.Newton(), ancf.QuasiNewton("bfgs"), ancf.QuasiNewton("bfgs", 10, carry=True))
    assert not any(judged_by_forces(stiff, 5e-4, method) for method in exact)
    # Energy is to be kept, whatever the method and the stiffness.
    for method in (*exact, SAVING):
        assert judged_by_forces(falling(1e8, False), 5e-4, method, ancf.EnergyMomentum())
    # Where the last residual is evaluated anyway, sooner.
    assert not judged_by_forces(falling(1e10, False), 5e-4, SAVING)
    assert judged_by_forces(falling(1e10, True), 5e-4, SAVING)
    assert judged_by_forces(falling(1e10, False), 5e-4, LEARNING)


@pytest.mark.parametrize("element", ["l2t2", "thin", "thick"])
def test_how_stiff_a_body_is_does_not_depend_on_how_it_lies(element):
    values = []
    for angle in (0.0, 0.4, 0.5 * math.pi):
        dim = 3 if element == "thick" else 2
        scene = ancf.Scene((0.0,) * dim)
        end = (2.0 * math.cos(angle), 2.0 * math.sin(angle), 0.0)[:dim]
        scene.add_beam(element, (0.0,) * dim, end, 10, CABLE, ancf.Material(1e8, 4000.0, 0.3))
        system = System(scene)
        values.append(stiffest(system, system.stiffness_diagonal(system.q0)))
    np.testing.assert_allclose(values, values[0], rtol=1e-9)


def test_slopes_and_what_is_held_do_not_count():
    thin, thick = (System(pendulum(element).scene) for element in ("thin", "thick"))
    values = [stiffest(s, s.stiffness_diagonal(s.q0)) for s in (thin, thick)]
    # EA / l over rho A l, for a mean of the directions and elements that share their nodes.
    waves = 1e8 / 4000.0 / 0.2**2
    assert all(0.3 * waves < value < 3.0 * waves for value in values)


def test_shorter_steps_across_a_hard_one_are_judged_in_their_own_way():
    # Soft for a step of 0.6 ms, stiff for the whole one: both are crossed.
    dt, method = 5e-3, ancf.ModifiedNewton(max_iterations=3)
    scene, rod = pendulum("thin", youngs_modulus=1e9)
    scene.point_force(rod.end, lambda t: (0.0, 40.0 * math.sin(9.0 * t)))
    assert judged_by_forces(scene, dt, method)
    assert not judged_by_forces(scene, dt / 8, method)
    run = ancf.simulate(scene, 0.5, dt, integrator=DAMPED, solver=method, max_halvings=6)
    crossed = [event.rung for event in run.stats.events if "steps of" in event.rung]
    assert any(f"of {dt / 8:.3g} s" in each or f"of {dt / 16:.3g} s" in each for each in crossed)
    exact = ancf.simulate(scene, 0.5, 2.5e-4, integrator=DAMPED, save_every=20)
    assert np.abs(run.position(rod.end) - exact.position(rod.end)).max() < 0.05
