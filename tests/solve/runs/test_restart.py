"""Runs that start from a state: where another run, a file or a static solution has ended."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from ancfsparse.results.hdf5_reader import load
from tests.beams import build_beam

NEWTON = ancf.Newton()
SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


def swing(as_constraint=False, youngs_modulus=1e8):
    """Return the paper's pendulum under gravity and a force that changes, and its rod."""
    scene, rod = pendulum("thin", 6, as_constraint=as_constraint, youngs_modulus=youngs_modulus)
    scene.point_force(rod.end, ancf.Sine((1.0, 2.0), 3.0))
    return scene, rod


def cable(length=2.0, hold_end="pin"):
    """Return a cable of the paper's section with its ends held, hanging under its weight."""
    return build_beam("thin", (0, 0), (length, 0), 16, SECTION, MATERIAL, "pin", hold_end)


def in_two(scene, t_half, t_end, dt, **options):
    """Return a run in one, and the second part of one in two."""
    whole = ancf.simulate(scene, t_end, dt, **options)
    first = ancf.simulate(scene, t_half, dt, **options)
    return whole, ancf.simulate(scene, t_end, dt, start=first.last, **options)


def check_states(second, whole):
    """Compare a second part with the last states of a whole run, bit for bit."""
    for name in ("t", "q", "v", "a", "lam"):
        part = getattr(second, name)
        np.testing.assert_array_equal(part, getattr(whole, name)[-len(part) :])


IMPLICIT = [
    ancf.GeneralizedAlpha(0.9),
    ancf.GeneralizedAlpha(0.5),
    ancf.HHT(0.1),
    ancf.Newmark(0.0),
    ancf.EnergyMomentum(),
]


@pytest.mark.parametrize("as_constraint", [False, True])
@pytest.mark.parametrize("integrator", IMPLICIT, ids=repr)
def test_two_parts_are_one_run_bit_for_bit(integrator, as_constraint):
    scene, _ = swing(as_constraint)
    whole, second = in_two(scene, 0.298, 0.6, 2e-3, integrator=integrator, solver=NEWTON)
    assert len(second.t) == 152
    check_states(second, whole)


@pytest.mark.parametrize("as_constraint", [False, True])
def test_two_parts_of_a_driven_crank_are_one_run_for_any_number_of_steps(as_constraint):
    """A function of few times was called time by time, where powers are rounded otherwise."""
    scene = ancf.Scene((0.0, -9.81))
    crank = scene.add_body(mass=1.0, inertia=0.05, centre=(0.25, 0), position=(0, 0))
    rod = scene.add_body(mass=1.0, inertia=0.2, centre=(0.75, 0), position=(0.5, 0))
    scene.connect(crank.at((0.5, 0.0)), rod.origin)
    angle = ancf.Ramp(6.0, 1.0, smooth=True)
    scene.drive_joint(scene.pin(crank.origin), angle, as_constraint=as_constraint)
    whole, second = in_two(scene, 0.1, 0.3, 4e-3, solver=NEWTON)
    assert len(second.t) == 51
    check_states(second, whole)


@pytest.mark.parametrize(
    ("integrator", "dt"),
    [
        (ancf.CentralDifference(), 2e-5),
        (ancf.RungeKuttaNystrom(4), 2e-5),
        (ancf.DormandPrince(), 4e-5),
    ],
    ids=repr,
)
def test_two_parts_of_an_explicit_run_are_one(integrator, dt):
    scene, _ = swing(isinstance(integrator, ancf.DormandPrince))
    whole, second = in_two(scene, 500 * dt, 1200 * dt, dt, integrator=integrator)
    assert np.max(np.abs(second.q[-1] - whole.q[-1])) < 1e-13
    assert np.max(np.abs(second.v[-1] - whole.v[-1])) < 1e-10


def test_with_a_seed_two_parts_differ_by_what_the_tolerance_leaves():
    scene, rod = swing()
    whole, second = in_two(scene, 0.3, 0.6, 2e-3)
    coarse = ancf.simulate(scene, 0.6, 4e-3)
    error = np.linalg.norm(coarse.position(rod.end)[-1] - whole.position(rod.end)[-1]) / 3.0
    apart = np.linalg.norm(second.position(rod.end)[-1] - whole.position(rod.end)[-1])
    assert 0.0 < apart < 0.02 * error


def test_the_energy_watch_goes_on():
    scene, _ = swing()
    whole, second = in_two(scene, 0.298, 0.6, 2e-3, integrator=ancf.Newmark(0.0), solver=NEWTON)
    watches = [run.last.memory["watch"] for run in (second, whole)]
    for each in watches:
        del each["beyond"]  # less gains by rounding, which is estimated at each start
    errors = [each.pop("errors") for each in watches]
    assert errors[0] == pytest.approx(errors[1], rel=0.25)  # half of it without the first part
    assert watches[0] == watches[1]


@pytest.mark.parametrize("nodes", [False, True])
@pytest.mark.parametrize("save_every", [1, 7])
def test_a_run_goes_on_from_a_file(tmp_path, save_every, nodes):
    scene, rod = swing()
    path = tmp_path / "run.h5"
    options = {"integrator": ancf.HHT(0.1), "solver": NEWTON, "save_every": save_every}
    kept = [rod.end] if nodes else None
    first = ancf.simulate(scene, 0.3, 2e-3, output=path, save_nodes=kept, **options)
    other, _ = swing()
    state = load(path, other).last
    for name in ("q", "v", "a", "b", "lam"):
        np.testing.assert_array_equal(getattr(state, name), getattr(first.last, name))
    whole = ancf.simulate(scene, 0.6, 2e-3, **options)
    second = ancf.simulate(other, 0.6, 2e-3, start=state, output=tmp_path / "more.h5", **options)
    np.testing.assert_array_equal(second.q[-1], whole.q[-1])
    again = load(tmp_path / "more.h5", other)
    assert again.t[0] == 0.3
    np.testing.assert_array_equal(again.last.q, whole.q[-1])


def test_a_file_of_a_run_from_a_state_belongs_to_its_scene(tmp_path):
    scene, _ = cable()
    ancf.simulate(scene, 0.1, 1e-3, start=ancf.solve_static(scene), output=tmp_path / "rest.h5")
    with pytest.raises(ancf.InputError, match="What differs is the stress-free shape"):
        load(tmp_path / "rest.h5", cable(2.1)[0])
    assert load(tmp_path / "rest.h5", cable()[0]).t[-1] == pytest.approx(0.1)


def test_a_state_survives_pickling():
    scene, _ = swing()
    run = ancf.simulate(scene, 0.3, 2e-3, solver=NEWTON)
    sent_scene, sent = pickle.loads(pickle.dumps((scene, run.last)))
    runs = [
        ancf.simulate(each, 0.4, 2e-3, solver=NEWTON, start=state)
        for each, state in ((scene, run.last), (sent_scene, sent))
    ]
    np.testing.assert_array_equal(runs[0].q[-1], runs[1].q[-1])
    path = pickle.loads(pickle.dumps(runs[0]))
    assert path.system.t0 == runs[0].t[0]
    np.testing.assert_array_equal(path.system.q0, runs[0].q[0])


@pytest.mark.parametrize(
    "integrator", [*IMPLICIT, ancf.CentralDifference(), ancf.DormandPrince()], ids=repr
)
def test_a_hanging_cable_stays_at_rest(integrator):
    scene, _ = cable()
    rest = ancf.solve_static(scene)
    assert rest.displacement(scene.beams[0].at(1.0))[1] < -0.05
    if integrator in IMPLICIT:
        run = ancf.simulate(scene, 10.0, 0.01, integrator=integrator, start=rest)
    else:
        run = ancf.simulate(scene, 0.1, 2e-5, integrator=integrator, start=rest)
    assert np.max(np.abs(run.q - rest.q)) < 1e-9
    assert run.energy.drift == 0.0


def test_an_accuracy_holds_from_a_state():
    scene, rod = swing()
    whole = ancf.simulate(scene, 0.6, accuracy=1e-7)
    first = ancf.simulate(scene, 0.25, accuracy=1e-7)
    second = ancf.simulate(scene, 0.6, accuracy=1e-6, start=first.last)
    assert second.t[0] == 0.25
    assert second.t[-1] == pytest.approx(0.6, abs=1e-15)
    apart = second.position(rod.end)[-1] - whole.position(rod.end)[-1]
    assert np.linalg.norm(apart) < 2e-6


@pytest.mark.parametrize("integrator", [ancf.HHT(0.1), ancf.EnergyMomentum()], ids=repr)
@pytest.mark.parametrize("as_constraint", [False, True])
def test_another_integrator_goes_on_at_second_order(integrator, as_constraint):
    scene, rod = swing(as_constraint, youngs_modulus=1e6)
    first = ancf.simulate(scene, 0.3, 1e-4, solver=NEWTON)
    ends = [
        ancf.simulate(
            scene, 0.4, dt, integrator=integrator, solver=NEWTON, start=first.last
        ).position(rod.end)[-1]
        for dt in (1e-3, 5e-4, 2.5e-4)
    ]
    coarse, fine = (np.linalg.norm(b - a) for a, b in pairwise(ends))
    assert math.log2(coarse / fine) > 1.7


def test_what_only_held_the_cable_may_be_released():
    scene, _ = cable()
    rest = ancf.solve_static(scene)
    free, rod = cable(hold_end="")
    run = ancf.simulate(free, 0.5, 1e-3, start=rest)
    np.testing.assert_allclose(run.position(rod.at(1.0))[0], rest.position(scene.beams[0].at(1.0)))
    assert run.position(rod.end)[-1, 1] < -0.5
    assert run.energy.drift < 0.02


def test_loads_may_change_at_the_start():
    scene, rod = cable()
    scene.point_force(rod.at(1.0), (0.0, 30.0))
    rest = ancf.solve_static(scene)
    released, other = cable()
    run = ancf.simulate(released, 1.0, 2.5e-4, start=rest)
    up = rest.position(rod.at(1.0))[1]
    assert run.position(other.at(1.0))[:, 1].min() < up - 0.1
    fine = ancf.simulate(released, 1.0, accuracy=1e-4, start=rest)
    apart = run.position(other.at(1.0))[-1] - fine.position(other.at(1.0))[-1]
    assert np.linalg.norm(apart) < 1e-3


def refusal(scene, start, t_end=1.0, dt=1e-3, **options):
    """Return the sentence that refuses a start."""
    with pytest.raises(ancf.InputError) as refused:
        ancf.simulate(scene, t_end, dt, start=start, **options)
    return str(refused.value)


def test_bad_starts_are_refused():
    scene, _ = swing()
    run = ancf.simulate(scene, 0.3, 1e-3)
    last = run.last
    assert "run.last" in refusal(scene, run)
    assert "start is a state of another scene: beam 0 is thin" in refusal(
        pendulum("thin", 7).scene, last
    )
    longer, _ = build_beam("thin", (0, 0), (3, 0), 6, SECTION, MATERIAL, "pin")
    assert "stress-free shape of beam 0 differs by up to 1 m" in refusal(longer, last)
    spoilt = replace(last, q=np.where(np.arange(len(last.q)) == 3, np.nan, last.q))
    assert "q of start is not finite at 1 of" in refusal(scene, spoilt)
    assert "q of start has shape (4,)" in refusal(scene, replace(last, q=last.q[:4]))
    assert "the time of start must be finite" in refusal(scene, replace(last, t=math.nan))
    assert "t_end = 0.2 s is not after the start" in refusal(scene, last, t_end=0.2)
    assert "t_end = 0.2 s is not after the start" in refusal(scene, last, 0.2, None, accuracy=1e-4)
    assert "does not divide the 0.7 s from start" in refusal(scene, last, dt=3e-3)
    pinned, rod = swing()
    pinned.pin(rod.end)
    assert "from where a joint of this scene holds it" in refusal(pinned, last)
    rodded, rod = swing()
    rodded.rod(rod.end, (4.0, 0.0))
    assert "the initial positions violate the rod" in refusal(rodded, last)


def test_connected_nodes_must_meet_at_the_start():
    scene, rod = pendulum("thin", 6)
    other = scene.add_beam("thin", (2, 0), (4, 0), 6, SECTION, MATERIAL)
    scene.pin(other.end)
    apart = ancf.simulate(scene, 0.3, 1e-3).last
    scene.connect(rod.end, other.start)
    assert "from the point that it is connected to" in refusal(scene, apart)


def test_a_failed_run_can_be_tried_again_from_its_last_state():
    def force(t):
        if t > 0.2005:
            raise ValueError("no wind then")
        return (0.0, 1.0)

    scene, rod = pendulum("thin", 6)
    scene.point_force(rod.end, force)
    with pytest.raises(ancf.LoadError) as failed:
        ancf.simulate(scene, 1.0, 1e-3)
    last = failed.value.trajectory.last
    calm, rod = pendulum("thin", 6)
    run = ancf.simulate(calm, 0.4, 1e-3, start=last)
    assert run.t[0] == pytest.approx(0.2, abs=1e-12)
    assert run.energy.drift < 1e-2


def test_a_scene_that_has_grown_since_is_refused():
    scene, rod = cable()
    rest = ancf.solve_static(scene)
    scene.add_beam("thin", (5, 0), (6, 0), 4, SECTION, MATERIAL)
    assert "start is a state of 1 bodies, and this scene has 2" in refusal(scene, rest)
    assert rest.position(rod.end)[0] == 2.0
