"""Explicit integrators with rigid bodies and joints by multipliers: order, constraints, energy."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.integrators.explicit.explicit_methods import make_explicit
from ancfsparse.problems import bricard, dzhanibekov, four_bar, heavy_top, n_four_bar, slider_crank
from ancfsparse.solve.initial_conditions.consistent_accelerations import initial_acceleration
from ancfsparse.solve.linearization.matrices import constraint_magnitudes, saddle_seed
from ancfsparse.system import System
from tests.beams import build_beam

RATTLE, EIGHTH = ancf.CentralDifference(), ancf.DormandPrince()
G = 9.81


def off_constraints(run):
    """How far positions and velocities are off the constraints at the end, over their terms."""
    system, q, v = run.system, run.q[-1], run.v[-1]
    none = np.zeros(system.n_multipliers)
    loads = system.loads.amplitudes(run.t[-1:])[0]
    phi = system.assembly.residual(q, v, 0.0 * v, none, system.dead_load, loads)[1]
    rate = system.constraints.jacobian(q) @ v
    if system.prescribed.n_equations:
        now = system.prescribed.at(run.t[-1])
        phi[-len(now.s) :] -= now.s
        rate[-len(now.s) :] -= now.s_rate
    sizes = constraint_magnitudes(system)
    return np.max(np.abs(phi) / sizes), np.max(np.abs(rate) / sizes) / np.max(np.abs(v))


def last(make, t_end, dt, integrator):
    return ancf.simulate(make().scene, t_end, dt, integrator=integrator).q[-1]


@pytest.mark.parametrize(
    ("make", "step"), [(dzhanibekov, 0.1), (four_bar, 0.04), (slider_crank, 0.04), (bricard, 0.04)]
)
@pytest.mark.filterwarnings("ignore::ancfsparse.RedundantConstraintsWarning")
def test_orders_two_and_eight(make, step):
    """Against the eighth order with steps of 2 ms, which rounding limits."""
    best = last(make, 1.0, 0.002, EIGHTH)
    errors = [np.max(np.abs(last(make, 1.0, dt, RATTLE) - best)) for dt in (0.004, 0.002)]
    assert 3.8 < errors[0] / errors[1] < 4.2
    errors = [np.max(np.abs(last(make, 1.0, dt, EIGHTH) - best)) for dt in (step, step / 2)]
    assert errors[0] / errors[1] > 2**6.5
    assert errors[1] < 1e-8


@pytest.mark.parametrize("integrator", [RATTLE, EIGHTH], ids=repr)
@pytest.mark.parametrize("make", [four_bar, bricard])
@pytest.mark.filterwarnings("ignore::ancfsparse.RedundantConstraintsWarning")
def test_constraints_hold_to_rounding(make, integrator):
    run = ancf.simulate(make().scene, 2.0, 0.005, integrator=integrator)
    of_places, of_speeds = off_constraints(run)
    assert of_places < 5e-15
    assert of_speeds < 1e-12


def test_rattle_keeps_the_energy_and_momenta_of_a_free_top_to_rounding():
    """Without forces it follows a discrete top, which has exact invariants; 25 flips."""
    scene = dzhanibekov().scene
    run = ancf.simulate(scene, 100.0, 0.01, integrator=RATTLE, save_every=50)
    motion = run.body(scene.bodies[0])
    energy, moment = motion.kinetic_energy, motion.angular_momentum
    assert np.ptp(energy) < 1e-10 * energy[0]
    np.testing.assert_allclose(moment, np.tile(moment[0], (len(moment), 1)), atol=1e-11 * 15.0)


def test_energy_errors_have_the_order():
    """The heavy top at 150 rad/s; that of RATTLE does not grow in ten times the time."""
    spread = {}
    for integrator, dts in ((RATTLE, (1e-3, 5e-4)), (EIGHTH, (4e-3, 2e-3))):
        runs = [ancf.simulate(heavy_top().scene, 0.4, dt, integrator=integrator) for dt in dts]
        spread[integrator] = [np.ptp(run.energy.total) for run in runs]
    assert 3.5 < spread[RATTLE][0] / spread[RATTLE][1] < 4.5
    assert spread[EIGHTH][0] / spread[EIGHTH][1] > 2**6.5
    longer = ancf.simulate(heavy_top().scene, 4.0, 1e-3, integrator=RATTLE, save_every=4)
    assert np.ptp(longer.energy.total) < 1.5 * spread[RATTLE][0]


def coupled():
    """A wheel that drives another by a gear, a weight on a winch, an angle and a length driven."""
    scene = ancf.Scene((0.0, -G))
    one = scene.add_body(mass=1.0, inertia=2.0, position=(0, 0), angular_velocity=-1.0)
    other = scene.add_body(mass=1.0, inertia=0.5, position=(1, 0), angular_velocity=0.5)
    pins = scene.pin(one.origin), scene.pin(other.origin)
    scene.gear(*pins, -2.0)
    weight = scene.add_body(mass=0.7, inertia=0.1, position=(3, -1), velocity=(0.3, 0))
    scene.winch(
        [(3, 0), weight.origin],
        length=lambda t: 1.0 + 0.1 * np.sin(t) ** 2,
        rate=lambda t: 0.1 * np.sin(2 * t),
        second_rate=lambda t: 0.2 * np.cos(2 * t),
    )
    return scene


def test_gears_and_ropes_of_prescribed_length():
    runs = [ancf.simulate(coupled(), 1.0, dt, integrator=EIGHTH) for dt in (0.05, 0.01)]
    slow = [ancf.simulate(coupled(), 1.0, dt, integrator=RATTLE) for dt in (0.01, 0.005)]
    errors = [np.max(np.abs(run.q[-1] - runs[1].q[-1])) for run in (*slow, runs[0])]
    assert 3.8 < errors[0] / errors[1] < 4.2
    assert errors[2] < 1e-8
    of_places, of_speeds = off_constraints(runs[1])
    assert of_places < 1e-14
    assert of_speeds < 1e-12
    # The work of the winch is part of the energy balance.
    energy = runs[1].energy
    assert np.ptp(energy.work) > 0.1
    np.testing.assert_allclose(energy.total - energy.work, energy.total[0], rtol=0, atol=1e-4)
    watch = runs[1].last.memory["watch"]  # its work is of the order of the method
    assert abs(watch["gain"]) < 1e-9


def screw():
    """A bead on an arm that turns, along which a gear moves it out."""
    scene = ancf.Scene((0.0, -G))
    arm = scene.add_body(mass=1.0, inertia=2.0, position=(0, 0), angular_velocity=1.0)
    bead = scene.add_body(
        mass=0.5, inertia=0.1, position=(0.5, 0), velocity=(0.5, 0.5), angular_velocity=1.0
    )
    hinge = scene.pin(arm.origin)
    scene.gear(hinge, scene.prismatic(bead.origin, arm.origin, axis=(1, 0)), 2.0)
    return scene


@pytest.mark.parametrize("make", [coupled, screw])
def test_accelerations_are_those_of_the_python_formulas(make):
    """Those of gears and ropes, with their second derivatives along the motion."""
    system = System(make())
    system.prescribed.resolve(1e-3, 0.0, 1.0)
    seed = saddle_seed(system)
    inputs = system.inputs(np.zeros(1), rates=True)[0][0]
    state = (system.q0, system.v0, inputs, seed, np.inf, 0.0, 0.0)
    loop = make_explicit(system, 1e-3, EIGHTH, *state, constraint_magnitudes(system))
    _, _, a, lam = loop.state
    none = np.zeros(system.n_multipliers)
    amplitudes = system.loads.amplitudes(np.zeros(1))[0]
    seed.factor(system.assembly.matrix(1.0, 0.0, system.q0, none, amplitudes))
    expected, multipliers = initial_acceleration(system, seed, system.v0)
    np.testing.assert_allclose(a, expected, atol=1e-10 * np.max(np.abs(expected)))
    r, _ = system.assembly.residual(system.q0, system.v0, a, lam, system.dead_load, amplitudes)
    assert np.max(np.abs(r[: system.n_free])) < 1e-9 * np.max(np.abs(multipliers))


def swing():
    """A body on a beam that is pinned by multipliers."""
    section, material = ancf.Circle(0.02), ancf.Material(1e7, 2000.0)
    scene, beam = build_beam("thin", (0, 0), (1, 0), 4, section, material, gravity=(0.0, -G))
    bob = scene.add_body(ancf.Rod(0.3), mass=0.5, position=(1, 0))
    scene.pin(beam.start, as_constraint=True)
    scene.connect(beam.end, bob.origin)
    return scene, bob


@pytest.mark.parametrize("integrator", [RATTLE, EIGHTH], ids=repr)
def test_beams_and_bodies_together(integrator):
    """Against the implicit default in steps of 0.1 ms, which is off by 1e-6 m."""
    scene, bob = swing()
    limit = ancf.stable_step(scene, integrator)
    dt = 0.2 / np.ceil(0.2 / min(0.9 * limit, 1e-3))
    run = ancf.simulate(scene, 0.2, dt, integrator=integrator)
    reference = ancf.simulate(scene, 0.2, 1e-4)
    end = [each.position(bob.end)[-1] for each in (run, reference)]
    np.testing.assert_allclose(*end, atol=1e-5)
    assert max(off_constraints(run)) < 1e-12
    energy = run.energy.total
    assert np.ptp(energy) < 5e-3 * np.max(np.abs(run.energy.kinetic))


def test_a_pin_by_multipliers_is_that_by_numbering():
    """Central differences with projections are those of fewer coordinates."""
    ends = []
    for as_constraint in (True, False):
        scene = ancf.Scene((0.0, -G))
        material = ancf.Material(1e7, 2000.0)
        beam = scene.add_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.02), material)
        scene.pin(beam.start, as_constraint=as_constraint)
        ends.append(ancf.simulate(scene, 0.2, 1e-4, integrator=RATTLE).position(beam.end)[-1])
    np.testing.assert_allclose(*ends, atol=1e-9)


@pytest.mark.parametrize("integrator", [RATTLE, EIGHTH], ids=repr)
def test_a_run_in_two_parts_is_one_run(integrator):
    scene = four_bar().scene
    whole = ancf.simulate(scene, 0.4, 0.01, integrator=integrator)
    half = ancf.simulate(scene, 0.2, 0.01, integrator=integrator)
    rest = ancf.simulate(scene, 0.4, 0.01, integrator=integrator, start=half.last)
    np.testing.assert_array_equal(rest.q[-1], whole.q[-1])
    np.testing.assert_array_equal(rest.v[-1], whole.v[-1])


def test_steps_in_which_a_body_turns_too_far_end_the_run():
    """A top at 5 rad/s: chords of unit vectors end where a step turns by 90 degrees and more."""
    scene = dzhanibekov().scene
    limit = ancf.stable_step(scene, RATTLE)
    assert limit == pytest.approx(2.0 / 5.0, rel=1e-6)
    with pytest.raises(ancf.InputError, match="above the stable step"):
        ancf.simulate(scene, 5.0, 0.5, integrator=RATTLE)
    fast = ancf.Scene((0.0, -G))
    rod = fast.add_body(ancf.Rod(0.01), mass=1.0, position=(0, 0))
    fast.pin(rod.origin)
    with pytest.raises(ancf.InstabilityError, match="constraints cannot be met by step") as stop:
        ancf.simulate(fast, 10.0, 0.5, integrator=RATTLE)
    assert np.isfinite(stop.value.trajectory.q).all()


def test_linkages_pass_places_where_constraints_lose_rank():
    """Ten of them in 10 s; b0 by the exact reduction (IFToMM A02)."""
    problem = n_four_bar(2)
    run = ancf.simulate(problem.scene, 10.0, 5e-3, integrator=EIGHTH)
    b0 = run.position(problem.bodies["coupler 0"].origin)[-1]
    np.testing.assert_allclose(b0, (0.328458112, 0.944518538), atol=1e-6)
    assert np.ptp(run.energy.total) < 1e-6


def test_runs_to_an_accuracy_take_them_where_they_cost_less():
    """Angular velocities of the free top at 10 s by Euler's equations; 178 steps, 6256 before."""
    scene = dzhanibekov().scene
    run = ancf.simulate(scene, 10.0, accuracy=1e-6)
    assert "DormandPrince" in run.stats.solver
    assert run.stats.steps < 1500  # those of all runs, implicit ones included
    spin = run.body(scene.bodies[0]).angular_velocity_in_body[-1]
    np.testing.assert_allclose(spin, (0.003232663, -4.999998740, -0.002173719), atol=5e-6)


@pytest.mark.parametrize("integrator", [ancf.DormandPrince(), ancf.CentralDifference()])
@pytest.mark.parametrize("begin", [0.0, 0.05, 0.0533])
def test_a_motion_that_a_smooth_load_begins_is_stable(integrator, begin):
    """The work of the load in the first steps was off by 2.5 % of the energy: "1.95e-18 J"."""
    scene = ancf.Scene((0.0, 0.0))
    body = scene.add_body(mass=1.0, inertia=0.1, position=(0, 0))
    scene.point_force(body.origin, ancf.Ramp((1.0, 0.0), 0.5, smooth=True, start=begin))
    for n_steps in (*range(1, 41), 200):
        run = ancf.simulate(scene, n_steps * 1e-3, 1e-3, integrator=integrator)
        assert run.stats.steps == n_steps
