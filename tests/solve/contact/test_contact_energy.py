"""Columns of the energy balance for contact: its potential, friction, and damped impacts."""

import dataclasses

import h5py
import numpy as np
import pytest
from matplotlib.figure import Figure

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.results.data.hdf5_format import CHECKED
from ancfsparse.results.fields import energy_balance
from ancfsparse.scene.force_elements.contacts import LAYER_RATIO
from ancfsparse.system import System
from tests.solve.contact.test_contact_motion import LINE_MASS, level

LAYER = LAYER_RATIO * 0.005  # of the pressure law, for a radius of 5 mm [m]
REST_DEPTH = LINE_MASS * 9.81 / 1e6 + 0.5 * LAYER  # under the weight, for 1e6 N/m2 [m]
SLIDING = {"friction": 0.3, "slip_speed": 1e-3}
LOSSES = ("work", "dissipated", "friction", "impact_damping")


def turning_drum():
    """A cable that falls on a turning drum, which accelerates it; an impact lasts 1.6 ms."""
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam(
        "thin", (-0.5, 0.11), (0.5, 0.11), 40, ancf.Circle(0.004), ancf.Material(1e8, 2e3)
    )
    drum = ancf.Drum((0, 0), 0.1, angular_velocity=5.0)
    scene.contact(cable, drum, stiffness=1e5, friction=0.3, slip_speed=1e-2)
    return scene


@pytest.mark.parametrize("dt", [1e-3, 5e-4])
@pytest.mark.parametrize(
    ("integrator", "drift"),
    [(ancf.EnergyMomentum(), 1e-8), (ancf.GeneralizedAlpha(0.9), 2e-4)],
)
def test_the_work_of_a_turning_drum_is_in_the_balance(integrator, drift, dt):
    """It is lost to friction and damped impacts, or changes the energy; no load does work."""
    run = ancf.simulate(turning_drum(), 0.15, dt, integrator=integrator)
    energy = run.energy
    largest = energy.kinetic.max()
    assert energy.work[-1] > 0.1 * largest
    assert energy.friction[-1] > 0.1 * largest
    assert np.diff(energy.friction).min() >= 0.0
    change = energy.total - energy.total[0]
    assert np.abs(energy.work - energy.lost - change).max() < drift * largest
    assert energy.drift < drift
    assert (energy.impact_damping[-1] > 10.0 * drift * largest) != integrator.keeps_energy
    watched = run.last.memory["watch"]["work"]
    assert energy.work[-1] - energy.friction[-1] == pytest.approx(watched, rel=1e-9)


def test_the_balance_of_a_turning_drum_converges_with_damped_impacts():
    """Steps of an eighth and a sixteenth of an impact of 1.6 ms."""
    drifts = [
        ancf.simulate(turning_drum(), 0.15, dt, integrator=ancf.GeneralizedAlpha(0.9)).energy.drift
        for dt in (2e-4, 1e-4)
    ]
    assert drifts[1] < 5e-4
    assert drifts[1] < 0.4 * drifts[0]


def test_explicit_runs_count_the_work_of_a_turning_drum():
    """A run without loads that change was stopped for the energy that it gained."""
    run = ancf.simulate(turning_drum(), 0.15, 2e-5, integrator=ancf.DormandPrince())
    watched = run.last.memory["watch"]["work"]
    assert run.energy.work[-1] - run.energy.friction[-1] == pytest.approx(watched, rel=1e-9)
    assert not run.energy.impact_damping.any()
    assert run.energy.drift < 1e-6


@pytest.mark.parametrize("integrator", [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9)])
def test_losses_are_those_of_all_steps_also_of_those_not_saved(integrator):
    losses = [
        ancf.simulate(turning_drum(), 0.15, 5e-4, integrator=integrator, save_every=every).energy
        for every in (1, 10)
    ]
    for name in LOSSES:
        every_step, few = (getattr(each, name) for each in losses)
        assert np.array_equal(few, every_step[::10])


@pytest.mark.parametrize("friction", [{"slip_speed": 1e-2}, {}], ids=["slip speed", "bristles"])
@pytest.mark.parametrize("make", ["drum", "crossing"])
@pytest.mark.parametrize("integrator", [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9)])
def test_losses_of_divided_steps_are_those_of_their_parts(integrator, make, friction):
    """As of entire steps, by the saved states, they were 30 times the energy of a run."""
    scene = ancf.Scene((0.0, -9.81)) if make == "drum" else ancf.Scene((0, 0, -9.81))
    rope = ancf.Circle(0.004), ancf.Material(1e8, 2e3)
    if make == "drum":
        cable = scene.add_beam("thin", (-0.5, 0.11), (0.5, 0.11), 40, *rope)
        contact = cable, ancf.Drum((0, 0), 0.1, angular_velocity=5.0)
    else:
        lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 8, *rope)
        scene.clamp(lower.start)
        scene.clamp(lower.end)
        start, end = (0, -0.5, 0.01), (0, 0.5, 0.01)
        contact = lower, scene.add_beam("thin", start, end, 8, *rope, velocity=(0.3, 0, -0.2))
    scene.contact(*contact, friction=0.3, stiffness=1e9, **friction)
    run = ancf.simulate(scene, 0.15, 2e-3, integrator=integrator, max_halvings=8)
    energy, bound = run.energy, 1e-8 if integrator.keeps_energy else 0.1
    assert run.stats.short_steps > 0
    assert energy.friction[-1] > 1e-3 * energy.kinetic.max()
    assert energy.drift < bound
    watched = run.last.memory["watch"]["work"]
    assert energy.work[-1] - energy.friction[-1] == pytest.approx(watched, rel=1e-9)


def test_losses_of_states_without_internal_variables_are_not_known():
    run = ancf.simulate(turning_drum(), 0.01, 5e-4)
    energy = dataclasses.replace(run, internal=np.empty((0, 0))).energy
    assert np.isnan(energy.friction).all()
    assert np.array_equal(energy.total, run.energy.total)


def test_a_file_with_other_internal_variables_is_refused(tmp_path):
    """An earlier version wrote one without losses: those of a second contact would be shifted."""
    file = tmp_path / "run.h5"
    ancf.simulate(turning_drum(), 0.01, 5e-4, output=file)
    with h5py.File(file, "r+") as opened:
        history = opened["history"][:, 1:]
        del opened["history"]
        opened.create_dataset("history", data=history, **CHECKED)
    with pytest.raises(InputError, match="internal variables of contacts there: 2; here: 3"):
        ancf.load(file)


def test_a_cable_that_slides_to_a_halt_loses_its_kinetic_energy_to_friction():
    """After v / (mu g) = 0.34 s; the speed of creep that remains is below the slip speed."""
    scene, _, _ = level(-REST_DEPTH, 1e6, velocity=(1.0, 0.0), **SLIDING)
    energy = ancf.simulate(scene, 0.4, 1e-3, integrator=ancf.EnergyMomentum()).energy
    assert energy.friction[-1] == pytest.approx(0.5 * LINE_MASS, rel=1e-6)
    assert energy.friction[200] == pytest.approx(energy.kinetic[0] - energy.kinetic[200], rel=1e-9)
    stored = 0.15 * LAYER**2 + 0.5 * ((REST_DEPTH - 0.5 * LAYER) ** 2 - 0.25 * LAYER**2)
    assert energy.contact == pytest.approx(1e6 * stored, rel=1e-6)
    assert np.abs(energy.elastic).max() < 1e-15


def lying(**options):
    return level(-REST_DEPTH, 1e6, **options)[0]


def on_a_drum(**options):
    """A cable that lies on a drum whose surface moves along it at 1 m/s."""
    scene = ancf.Scene((0, 0))
    cable = scene.add_beam(
        "thin", (-0.1, 1.0049), (0.1, 1.0049), 4, ancf.Circle(0.01), ancf.Material(1e8, 5e3)
    )
    scene.contact(cable, ancf.Drum((0, 0), 1.0, angular_velocity=-1.0), stiffness=1e6, **options)
    return scene


def crossing(**options):
    """Two cables, the second of which lies across the first."""
    scene = ancf.Scene((0, 0, 0))
    rope = ancf.Circle(0.01), ancf.Material(1e8, 5e3)
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 4, *rope)
    upper = scene.add_beam("thin", (0, -0.5, 0.0095), (0, 0.5, 0.0095), 4, *rope)
    scene.contact(lower, upper, stiffness=1e4, **options)
    return scene


def friction_of(scene, places, velocities):
    """Return the losses to friction where the last cable moves through places, (k, dim) [m]."""
    system = System(scene)
    q = np.tile(system.q0, (len(places), 1))
    v, beam, none = np.zeros_like(q), scene.beams[-1], np.zeros(1)
    for node in range(beam.n_nodes):
        where, _ = system.point(beam.node(node))
        q[:, where[:, 0]] += places
        v[:, where[:, 0]] = velocities
    system.assembly.begin(q[0])
    system.assembly.set_step(1e-3)
    history = [system.assembly.history]
    for k in range(1, len(q)):
        system.assembly.load_work(q[k - 1], none, q[k], none, v0=v[k - 1], v1=v[k])
        system.assembly.accept(q[k])
        history.append(system.assembly.history)
    return system.contributions[-1].contact_losses(np.array(history))[:, 1]


@pytest.mark.parametrize("make", [lying, on_a_drum, crossing])
def test_friction_gives_no_energy_in_steps_that_do_not_resolve_the_sliding(make):
    """There the velocities at both ends of a step can be opposite to the displacement.

    Random runs with contact were not stopped for the energy that this adds (9102/521, 7703/59).
    """
    scene = make(friction=0.3, slip_speed=1e-2)
    places, velocities = np.zeros((2, 5, scene.dim))
    places[:, 0], velocities[:, 0] = [0.0, -1e-3, -2e-3, -1e-3, 0.0], [2.0, 2.0, 2.0, -2.0, -2.0]
    friction = friction_of(scene, places, velocities)
    assert (np.diff(friction) >= 0.0).all()
    assert friction_of(scene, places, -velocities)[-1] > 0.0


@pytest.mark.parametrize("make", [lying, crossing])
def test_bristles_return_no_more_than_they_have_stored(make):
    """Here at the end of contact in a step that goes back by more than their deflection."""
    scene = make(friction=0.3)
    places = np.zeros((3, scene.dim))
    places[1, 0] = 1e-4
    places[2, 0], places[2, -1] = -1e-3, 0.1
    friction = friction_of(scene, places, 0.0 * places)
    assert friction[1] > 0.0
    assert -4.0 * np.finfo(float).eps * friction[1] <= friction[2] < friction[1]  # rounding


@pytest.mark.parametrize("dt", [2e-4, 1e-3, 2e-3])
def test_energy_momentum_conserves_energy_and_losses_to_friction(dt):
    """In impacts of 6 ms on a slope."""
    scene, _, _ = level(0.01, 1e5, 0.3, velocity=(1.0, 0.0), **SLIDING)
    run = ancf.simulate(scene, 0.2, dt, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    energy = run.energy
    assert energy.contact.max() > 0.0 < energy.friction[-1]
    held = energy.kinetic + energy.elastic + energy.potential + energy.contact + energy.friction
    assert np.abs(held - held[0]).max() < 1e-10 * energy.kinetic.max()


def test_beams_among_each_other_have_a_potential_alone():
    scene = ancf.Scene((0, 0, -9.81))
    rope, wire = ancf.Circle(0.01), ancf.Material(1e8, 5e3)
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 4, rope, wire)
    scene.clamp(lower.start)
    scene.clamp(lower.end)
    start, end = (0, -0.5, 0.012), (0, 0.5, 0.012)
    upper = scene.add_beam("thin", start, end, 4, rope, wire, velocity=(0, 0, -1))
    scene.contact(lower, upper, stiffness=1e7)
    run = ancf.simulate(scene, 0.03, 5e-4, integrator=ancf.EnergyMomentum(), max_halvings=6)
    energy = run.energy
    assert energy.contact.max() > 1e-3 * energy.kinetic.max()
    held = energy.kinetic + energy.elastic + energy.potential + energy.contact
    assert np.abs(held - held[0]).max() < 1e-6 * energy.kinetic.max()
    assert not energy.friction.any()


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum()])
def test_stored_and_continued_runs_have_the_same_losses(tmp_path, integrator):

    def drop():
        return level(2e-3, 1e5, velocity=(1.0, 0.0), **SLIDING)[0]

    options = {"integrator": integrator, "solver": ancf.Newton()}
    file = tmp_path / "drop.h5"
    whole = ancf.simulate(drop(), 0.06, 1e-3, output=file, **options).energy
    assert whole.friction[-1] > 0.0
    scene = drop()
    first = ancf.simulate(scene, 0.015, 1e-3, **options)
    rest = ancf.simulate(scene, 0.06, 1e-3, start=first.last, **options).energy
    read = ancf.load(file).energy
    for name in ("kinetic", "elastic", "potential", "contact", *LOSSES):
        column = getattr(whole, name)
        assert np.array_equal(getattr(read, name), column)
        begin = column[15] if name in LOSSES else 0.0
        np.testing.assert_allclose(getattr(rest, name), column[15:] - begin, rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum()])
def test_states_that_exceed_the_memory_have_the_same_losses(monkeypatch, integrator):
    scene, _, _ = level(2e-3, 1e5, velocity=(1.0, 0.0), **SLIDING)
    run = ancf.simulate(scene, 0.04, 1e-3, integrator=integrator)
    whole = run.energy
    monkeypatch.setattr(energy_balance, "BLOCK_SIZE", 3 * run.q.shape[1])
    again = dataclasses.replace(run).energy
    for name in ("contact", *LOSSES):
        np.testing.assert_allclose(getattr(again, name), getattr(whole, name), rtol=1e-14)


def test_the_balance_leaves_the_history_of_contacts_as_it_is():
    scene, _, _ = level(2e-3, 1e5, velocity=(1.0, 0.0), **SLIDING)
    run = ancf.simulate(scene, 0.022, 1e-3)
    memory = run.system.assembly.memory
    assert run.energy.impact_damping[-1] > 0.0
    assert memory.any()
    assert np.array_equal(run.system.assembly.memory, memory)


def drawn_energies(run):
    """Return the lines of the plot of the energies."""
    return run.plot("energy", ax=Figure().subplots()).lines


def test_losses_of_contact_are_printed_and_drawn_where_there_are_any():
    scene, _, _ = level(2e-3, 1e5, velocity=(1.0, 0.0), **SLIDING)
    run = ancf.simulate(scene, 0.022, 1e-3)
    energy = run.energy
    assert f"friction {energy.friction[-1]:.6g} J" in repr(energy)
    assert f"damped impacts {energy.impact_damping[-1]:.6g} J" in repr(energy)
    drawn = {line.get_label(): line.get_ydata() for line in drawn_energies(run)}
    assert np.array_equal(drawn["contact"], energy.contact)
    assert np.array_equal(drawn["impact damping"], energy.impact_damping)
    free = ancf.simulate(level(1.0)[0], 0.01, 1e-3)
    assert "friction" not in repr(free.energy)
    assert not free.energy.lost.any()
    assert "contact" not in {line.get_label() for line in drawn_energies(free)}
