"""How long an explicit step may be, and what happens beyond."""

import numpy as np
import pytest
import scipy.linalg

import ancfsparse as ancf
from ancfsparse.problems import net, pendulum
from ancfsparse.solve.linearization.matrices import highest_frequency, mass_seed
from ancfsparse.system import System
from tests.beams import build_beam
from tests.soak.trials.accuracy import trial

CENTRAL, FOURTH = ancf.CentralDifference(), ancf.RungeKuttaNystrom(4)


def test_the_limit_of_the_pendulum_of_the_paper():
    # Highest of 42 frequencies of the assembled mesh: 9.548 c / l with c = 158.1 m/s, l = 0.2 m.
    scene, _ = pendulum()
    omega = 9.548 * np.sqrt(1e8 / 4000.0) / 0.2
    assert omega == pytest.approx(7548, abs=1)
    assert ancf.stable_step(scene, CENTRAL) == pytest.approx(2 / omega, rel=1e-4)
    assert ancf.stable_step(scene, CENTRAL) == pytest.approx(2.65e-4, abs=5e-7)
    assert ancf.stable_step(scene, FOURTH) == pytest.approx(3.767 / omega, rel=1e-4)


def by_differences(system, q, amplitudes):
    """Highest frequency with the stiffness from differences of the residual."""
    n, d = system.n_free, 1e-6
    unit = np.eye(system.n_all)
    zero, none = np.zeros(system.n_all), np.zeros(system.n_multipliers)

    def force(x):
        return system.assembly.residual(x, zero, zero, none, system.dead_load, amplitudes)[0]

    stiffness = np.array([(force(q + d * e) - force(q - d * e)) / (2 * d) for e in unit[:n]])[:, :n]
    mass = np.array([system.assembly.inertia(e) for e in unit[:n]])[:, :n]
    return np.sqrt(scipy.linalg.eigh((stiffness + stiffness.T) / 2, mass, eigvals_only=True)[-1])


SCENES = {
    "planar": lambda: pendulum("thin", 10).scene,
    "spatial": lambda: pendulum("thin", 20, 3).scene,
    "thick": lambda: pendulum("thick", 2).scene,
    "net": lambda: net(4).scene,
    "long": lambda: pendulum("l2t2", 60).scene,
}


@pytest.mark.parametrize("name", SCENES)
def test_the_fastest_vibration_is_that_of_a_dense_formula(name):
    system = System(SCENES[name]())
    rng = np.random.default_rng(1)
    for q in (system.q0, system.q0 + 1e-3 * rng.normal(size=system.n_all)):
        amplitudes = system.loads.amplitudes(np.zeros(1))[0]
        expected = by_differences(system, q, amplitudes)
        assert highest_frequency(system, mass_seed(system), q, amplitudes) == pytest.approx(
            expected, rel=2e-4
        )


def test_the_limit_is_found_where_a_search_for_one_eigenvalue_fails():
    # LAPACK 3.12 finds no interval that holds the highest of these 96 frequencies alone.
    scene, _, _ = trial(1301, 255)
    system = System(scene.scene)
    load = system.loads.amplitudes(np.zeros(1))[0]
    found = highest_frequency(system, mass_seed(system), system.q0, load)
    assert found == pytest.approx(by_differences(system, system.q0, load), rel=2e-4)


@pytest.mark.parametrize("integrator", [CENTRAL, FOURTH, ancf.RungeKuttaNystrom(8)], ids=repr)
def test_a_step_above_the_limit_is_refused_with_one_that_works(integrator):
    scene, _ = pendulum()
    limit = ancf.stable_step(scene, integrator)
    with pytest.raises(ancf.InputError, match="above the stable step") as refusal:
        ancf.simulate(scene, 0.01, 0.01 / 8, integrator=integrator)
    message = str(refusal.value)
    assert f"{limit:.4g} s" in message
    assert "GeneralizedAlpha(0.9)" in message
    dt = float(message.split("take dt = ")[1].split(" s ")[0])
    assert limit > dt > 0.9 * limit
    ancf.simulate(scene, 0.01, dt, integrator=integrator)


@pytest.mark.parametrize("integrator", [CENTRAL, FOURTH], ids=repr)
def test_the_limit_is_where_runs_begin_to_grow(integrator, monkeypatch):
    scene, _ = stretched(None)
    limit = ancf.stable_step(scene, integrator)
    monkeypatch.setattr(
        "ancfsparse.solve.stepping.explicit_setup.highest_frequency", lambda *_: 1.0
    )
    for share, grows in ((0.98, False), (1.02, True)):
        rod_scene, _ = stretched(shaken)
        dt = share * limit
        if grows:
            with pytest.raises(ancf.InstabilityError):
                ancf.simulate(rod_scene, 3000 * dt, dt, integrator=integrator)
        else:
            # Near the limit the energy of central differences oscillates by 5 % without growing.
            gain = 0.1 if integrator == CENTRAL else 0.01
            run = ancf.simulate(
                rod_scene, 3000 * dt, dt, integrator=integrator, max_energy_gain=gain
            )
            assert np.abs(run.v).max() < 10 * np.abs(run.v[0]).max()


def test_a_stiff_scene_is_told_the_step_it_would_need():
    scene, _ = pendulum("thick", youngs_modulus=2e11)
    with pytest.raises(ancf.InputError, match=r"which is .*e-0[6-8] s for this scene"):
        ancf.simulate(scene, 0.01, 1e-4, integrator=CENTRAL)


def test_multipliers_are_refused_by_the_name_of_their_joint():
    scene, _ = pendulum(as_constraint=True)
    refused = r"the pin .* needs them.*as_constraint=False.*GeneralizedAlpha"
    with pytest.raises(ancf.InputError, match=refused):
        ancf.simulate(scene, 0.01, 1e-4, integrator=FOURTH)
    with pytest.raises(ancf.InputError, match=refused):
        ancf.stable_step(scene, FOURTH)


@pytest.mark.parametrize("option", [{"solver": ancf.Newton()}, {"tolerance": "paper"}])
def test_what_only_implicit_methods_need_is_refused(option):
    scene, _ = pendulum()
    with pytest.raises(ancf.InputError, match=f"{next(iter(option))}=.* does not apply"):
        ancf.simulate(scene, 0.01, 1e-4, integrator=CENTRAL, **option)


def test_only_explicit_integrators_have_a_stable_step():
    with pytest.raises(ancf.InputError, match="stable step"):
        ancf.stable_step(pendulum().scene, ancf.Newmark())


def stretched(velocity):
    """A pinned rod without weight; `velocity` turns places (k, 2) into velocities."""
    scene = ancf.Scene((0.0, 0.0))
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    rod = scene.add_beam("thin", (0, 0), (2, 0), 10, section, material, velocity=velocity)
    scene.pin(rod.start)
    return scene, rod


GROWS = "without work of a load; the stable step"


def pulled(x):
    return np.stack([12.0 * x[:, 0], 0.0 * x[:, 0]], axis=1)


def shaken(x):
    return 1e-6 * np.sin(np.stack([7e3 * x[:, 0], 9e3 * x[:, 0]], axis=1))


def test_a_run_that_outgrows_its_limit_stops():
    scene, _ = stretched(pulled)
    dt = 0.999 * ancf.stable_step(scene, CENTRAL)
    with pytest.raises(ancf.InstabilityError, match=GROWS) as stop:
        ancf.simulate(scene, 4000 * dt, dt, integrator=CENTRAL)
    assert "GeneralizedAlpha(0.9)" in str(stop.value)
    assert isinstance(stop.value, ancf.StepError)
    assert np.isfinite(stop.value.trajectory.q).all()
    assert stop.value.trajectory.energy.drift < 0.5
    # Half the step follows the same motion.
    assert ancf.simulate(scene, 4000 * dt, dt / 2, integrator=CENTRAL).energy.drift < 0.05


def test_rounding_of_a_body_at_rest_far_away_hides_no_instability():
    # Its K q^2 of 4e19 J has 1e5 J of rounding, and the rod 80 J of energy.
    scene, _ = stretched(pulled)
    bar = scene.add_beam(
        "thin", (1e5, 0.0), (1e5 + 20.0, 0.0), 4, ancf.Rectangle(0.1, 0.1),
        ancf.Material(2e11, 7800.0),
    )  # fmt: skip
    scene.clamp(bar.start)
    scene.clamp(bar.end)
    dt = 0.999 * ancf.stable_step(scene, CENTRAL)
    with pytest.raises(ancf.InstabilityError, match=GROWS) as stop:
        ancf.simulate(scene, 4000 * dt, dt, integrator=CENTRAL)
    assert stop.value.trajectory.energy.drift < 0.5


def test_without_the_watch_a_run_ends_where_numbers_do():
    scene, _ = stretched(pulled)
    dt = 0.999 * ancf.stable_step(scene, CENTRAL)
    with pytest.raises(ancf.InstabilityError, match="leaves the range of numbers") as stop:
        ancf.simulate(scene, 40000 * dt, dt, integrator=CENTRAL, max_energy_gain=np.inf)
    path = stop.value.trajectory
    assert len(path.t) == stop.value.step + 1
    assert np.isfinite(path.q).all()


@pytest.mark.parametrize("dt", [1e-4, 1.0])
def test_damping_is_refused(dt):
    wet = ancf.Material(1e8, 4000.0, rayleigh=(1.0, 0.0))
    scene, _ = build_beam("thin", (0, 0), (2, 0), 3, ancf.Rectangle(0.01, 0.01), wet, "pin")
    with pytest.raises(ancf.InputError, match=r"damping .* depends on velocities"):
        ancf.simulate(scene, 10 * dt, dt, integrator=CENTRAL)
    with pytest.raises(ancf.InputError, match=r"damping .* depends on velocities"):
        ancf.stable_step(scene, CENTRAL)


def test_a_run_under_changing_loads_that_outgrows_its_limit_stops():
    scene, rod = stretched(None)
    scene.point_force(rod.end, lambda t: (2e3 * min(t / 0.5, 1.0), 0.0))
    dt = 0.999 * ancf.stable_step(scene, CENTRAL)
    steps = int(1.0 / dt)
    with pytest.raises(ancf.InstabilityError, match=GROWS) as stop:
        ancf.simulate(scene, steps * dt, dt, integrator=CENTRAL)
    assert np.isfinite(stop.value.trajectory.q).all()
    ancf.simulate(scene, steps * dt, dt / 2, integrator=CENTRAL)
