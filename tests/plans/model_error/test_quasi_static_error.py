"""Plans that follow equilibria where loads are slow, beside motions on fine meshes."""

from dataclasses import replace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.model_error.quasi_static_error import (
    inertia_error,
    is_dynamic,
    start_error,
)
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.quantities.tolerances import check_goals
from ancfsparse.plans.selection.method_selection import _resolve_vibrations
from ancfsparse.plans.trial_runs.solution_methods import Statics, _time_dependent_loads
from ancfsparse.plans.trial_runs.trial_runs import TrialRuns
from ancfsparse.system import System
from tests.beams import build_beam
from tests.plans.comparison import (
    DAMPED,
    build_trials,
    distance_from_shorter_steps,
)

SOFT = ancf.Material(1e8, 1000)


def pulled(time, element="auto", n="auto"):
    """A sagging cable, one end of which is pulled by 8 cm."""
    scene = ancf.Scene((0.0, -9.81))
    rope = scene.add_beam(element, (0, 0), (1, 0), n, ancf.Circle(0.005), SOFT, length=1.1)
    scene.pin(rope.start)
    scene.drive(rope.end, lambda t: (1 + 0.08 * (t / time) ** 2 * (3 - 2 * t / time), 0.0))
    return scene, rope.at(0.55)


def bent(time, element="auto", n="auto", damping=0.0):
    """A cantilever whose load grows smoothly."""
    made = ancf.Circle(0.02), ancf.Material(1e8, 1000, bending_damping=damping)
    scene, rod = build_beam(element, (0, 0), (1, 0), n, *made, "clamp", gravity=(0.0, 0.0))
    scene.point_force(rod.end, lambda t: (0.0, -0.2 * (t / time) ** 2 * (3 - 2 * t / time)))
    return scene, rod.end


@pytest.mark.parametrize(("time", "error"), [(20.0, "5 %"), (60.0, "4 %"), (60.0, "5 %")])
def test_a_cable_that_is_pulled_slowly_is_solved_as_statics(time, error):
    scene, point = pulled(time)
    plan = ancf.plan(scene, time, ancf.position(point), error)
    assert plan.integrator == Statics()
    assert "the motion is computed as a sequence of equilibria" in str(plan)
    assert "statics at all times" in plan.choice
    run = plan.run(verify=True)
    asked = plan.predictions[0].tolerance
    fine = pulled(time, "thin", 24)
    division = round(run.t[1] / 2e-3)
    achieved = distance_from_shorter_steps(run, point, *fine, division, integrator=DAMPED)
    assert achieved <= asked
    assert plan.is_met
    assert run.measured[0] == pytest.approx(achieved, rel=0.6)
    sources = plan.predictions[0].sources
    assert sources["inertia"] + sources["start"] >= 0.3 * achieved


def test_a_start_without_equilibrium_is_named_and_refused_early(monkeypatch):
    steps, run = [], TrialRuns._run

    def counted(trials, model, n):
        steps.append(n)
        return run(trials, model, n)

    monkeypatch.setattr(TrialRuns, "_run", counted)
    scene, point = pulled(20.0)
    named = "mostly by vibrations of the start, which start='equilibrium' avoids"
    with pytest.raises(ancf.PlanError, match=named):
        ancf.plan(scene, 20.0, ancf.position(point), "1 %")
    assert max(steps) <= 102400  # not 409600, which took five times as long
    assert ancf.plan(scene, 20.0, ancf.position(point), "1 %", start="equilibrium").is_met


def test_vibrations_of_the_start_have_its_distance_from_equilibrium():
    scene, point = pulled(20.0, "thin", 8)
    path = ancf.quasi_static(scene, 20.0, 1.0)
    distance = np.linalg.norm(point.position - ancf.solve_static(scene).position(point))
    assert start_error(path, ancf.position(point)) == pytest.approx(distance, rel=1e-6)
    begun = ancf.quasi_static(scene, 20.0, 1.0, start=ancf.solve_static(scene))
    assert start_error(begun, ancf.position(point)) < 1e-6 * distance


def test_what_is_not_slow_enough_is_marched():
    scene, point = bent(3.0)
    plan = ancf.plan(scene, 3.0, ancf.position(point), "3 %")
    assert plan.integrator == DAMPED
    assert "statics at all times would exceed the tolerance by a factor of" in str(plan)


@pytest.mark.parametrize("damping", [0.0, 0.3])
@pytest.mark.parametrize("time", [4.0, 16.0])
def test_what_equilibria_leave_out(time, damping):
    scene, point = bent(time, "thin", 8, damping)
    run = ancf.quasi_static(scene, time, time / 64)
    off = distance_from_shorter_steps(run, point, scene, point, 100, integrator=ancf.Newmark())
    assert off <= inertia_error(run, ancf.position(point)) <= 12.0 * off


def test_the_lowest_frequency_is_bounded_where_loads_displace_little(monkeypatch):
    """What the bound refuses is what the frequency itself refuses."""
    called = []
    whole = is_dynamic

    def looked(*arguments):
        called.append(whole(*arguments))
        return called[-1]

    monkeypatch.setattr("ancfsparse.plans.trial_runs.solution_methods.is_dynamic", looked)
    for t_end in (40.0, 4.0, 2.0, 1.0, 0.5):
        scene, point = bent(t_end, "thin", 4)
        changes = _time_dependent_loads(System(scene), t_end)
        before = len(called)
        asked = check_goals([ancf.position(point)], "1 %")
        error_model = Statics.fit(System(scene), t_end, asked) is not None
        assert error_model is not whole(scene, t_end, changes, 0.01)
        assert t_end > 1.0 or len(called) == before
    assert called


def test_what_statics_does_not_have_is_marched():
    """Velocities, what begins to move, and loads that do not change."""
    scene, point = bent(40.0)

    def fits(made, quantity):
        return Statics.fit(System(made), 40.0, check_goals([quantity], "1 %")) is not None

    made = bent(40.0, "thin", 4)[0]
    assert fits(made, ancf.position(point))
    assert not fits(made, ancf.velocity(point))
    assert not fits(made, ancf.energy("kinetic"))
    thrown = ancf.Scene((0.0, 0.0))
    rod = thrown.add_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.02), SOFT, velocity=(0, 1))
    thrown.point_force(rod.end, ancf.Ramp((0.0, -2.0), 20.0))
    assert not fits(thrown, ancf.position(rod.end))
    still, rod = build_beam("thin", (0, 0), (1, 0), 4, ancf.Circle(0.02), SOFT, "clamp")
    assert not fits(still, ancf.position(rod.end))
    kept = ancf.plan(scene, 40.0, ancf.position(point), "3 %", integrator=ancf.HHT())
    assert kept.integrator == ancf.HHT()
    scene, point = pulled(20.0)
    plan = ancf.plan(scene, 20.0, ancf.position(point), "5 %")
    assert isinstance(plan.integrator, Statics)
    np.testing.assert_array_equal(plan.run(save_every=2).t, plan.run().t[::2])


def test_steps_see_the_vibrations_that_equilibria_miss():
    """Steps of 0.6 s jump to the equilibrium about which the cable vibrates by 3 mm in 0.35 s."""
    scene, point = pulled(60.0, "thin")
    trials = build_trials(scene, 60.0, ancf.position(point), "3 %")
    equilibria = replace(trials.with_integrator(Statics()), base=16)
    assert _resolve_vibrations(trials, equilibria).base == trials.base  # nothing is known
    fine = Model(counts={"beam 0": 8})
    equilibria.run(fine, 16)
    seen = _resolve_vibrations(trials, equilibria).base
    assert seen >= 8 * 60.0 / 0.36
    assert seen <= 2 * 8 * 60.0 / 0.34
    rough = replace(trials, goals=check_goals([ancf.position(point)], "30 %"))
    assert _resolve_vibrations(rough, equilibria).base == trials.base
    # So long steps miss it, and agree on that.
    undamped = ancf.GeneralizedAlpha(1.0)
    made = [
        ancf.simulate(pulled(60.0, "thin", n)[0], 6.0, dt, integrator=own)
        for n, dt, own in ((4, 0.6, undamped), (6, 0.3, DAMPED), (6, 1e-3, DAMPED))
    ]
    one, other, true = (
        run.position(run.system.scene.beams[0].at(0.55))[:: (len(run.t) - 1) // 10] for run in made
    )
    assert np.abs(one - other).max() < 1e-3
    assert np.abs(true - other).max() > 2e-3


def test_what_is_far_from_slow_is_not_tried():
    scene, point = bent(0.2)
    plan = ancf.plan(scene, 0.2, ancf.position(point), "3 %")
    assert plan.integrator == DAMPED
    assert "statics" not in str(plan)
