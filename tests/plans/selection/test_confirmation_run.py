"""The last pilot is the answer, and corrects estimates that were too good."""

from dataclasses import replace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.models.model import Model, build_model
from ancfsparse.plans.selection import confirmation_run
from ancfsparse.plans.selection.confirmation_run import confirm_selection
from ancfsparse.plans.selection.discretization_search import search
from ancfsparse.plans.trial_runs.run_differences import goal_differences
from ancfsparse.plans.trial_runs.trial_runs import round_steps
from ancfsparse.problems import pendulum
from tests.beams import build_beam
from tests.plans.comparison import build_trials

T_END = 1.0


def pilots_of(error):
    scene, rod = pendulum("thin", "auto")
    return build_trials(scene, T_END, ancf.position(rod.end), error)


def test_a_system_that_was_marched_before_gives_the_same_numbers():
    trials, model = pilots_of(1e-3), Model(counts={"beam 0": 8})
    first = trials.run(model, 100)
    again = trials.run(model, 200)
    assert again.run.system is first.run.system
    how = {"integrator": again.integrator, "solver": again.solver}
    fresh = ancf.simulate(build_model(trials.scene, model), T_END, T_END / 200, **how)
    for name in ("t", "q", "v", "a", "lam"):
        assert np.array_equal(getattr(again.run, name), getattr(fresh, name))


def test_one_mesh_is_run_once_for_several_requested_counts():
    """Five places on a beam make ten elements of six, of seven and of eight."""
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), "auto", ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000),
        "clamp",
    )  # fmt: skip
    for share in (0.1, 0.3, 0.5, 0.7, 0.9):
        scene.point_force(rod.at(share), (0.0, -0.01))
    trials = build_trials(scene, 0.1, ancf.position(rod.end), 1e-3)
    model = Model()
    one, *others = (trials.run(model.with_counts({rod.name: n}), 100) for n in (6, 7, 8))
    assert one.run.system.scene.body(rod.name).n_elements == 10
    assert all(other is one for other in others)
    assert trials.find(model.with_counts({rod.name: 8}), 100) is one
    assert trials.build(model.with_counts({rod.name: 8})) is one.run.system.scene
    assert trials.find(model.with_counts({rod.name: 16}), 100) is None
    assert len(trials.run_costs) == len(trials.systems) == 1


def test_the_answer_is_not_marched_again_and_is_the_run_of_the_plan():
    scene, rod = pendulum("thin", "auto")
    plan = ancf.plan(scene, T_END, ancf.position(rod.end), "1 %")
    assert plan.result is not None
    run = plan.run()
    assert run.q is plan.result.q
    again = plan.run(save_every=1)
    assert again.q is not run.q
    assert np.array_equal(again.position(rod.end), run.position(rod.end))
    # Longer runs are not made before they are asked for.
    assert ancf.plan(scene, 3.0, ancf.position(rod.end), 5e-5).result is None


def test_an_estimate_that_is_too_good_is_corrected():
    trials = pilots_of(2e-4)
    error_model = search(trials, Model(), None, None)
    exact = trials.run(Model(counts={"beam 0": 64}), 12800)
    (mesh,) = error_model.mesh.estimates
    blind = replace(
        error_model,
        mesh=replace(error_model.mesh, estimates=(replace(mesh, error=mesh.error / 50, lower=()),)),
    )
    n_longest, steps = blind.optimum()
    wrong = trials.run(Model(counts={"beam 0": int(n_longest)}), steps)
    assert goal_differences(trials.goals, wrong, exact)[0] > 2e-4
    seen = confirm_selection(trials, blind)
    assert seen.excess(n_longest, steps) > 1.0
    n_longest, steps = seen.optimum()
    run = trials.run(Model(counts={"beam 0": int(n_longest)}), steps)
    assert goal_differences(trials.goals, run, exact)[0] <= 2e-4


def test_a_confirmation_costs_at_most_twice_as_much_as_the_runs_before(monkeypatch):
    """The tolerance asks for so many steps that .15 of their work is far more."""
    monkeypatch.setattr(confirmation_run, "BASE_BUDGET", 0.0)
    trials = pilots_of(2e-2)
    error_model = replace(search(trials, Model(), None, None), selected=None, combined_errors=None)
    strict = replace(error_model, tolerances=tuple(1e-4 * x for x in error_model.tolerances))
    before = sum(each.work for each in trials.run_costs)
    n_before = len(trials.run_costs)
    assert 0.15 * strict.work(*strict.optimum()) > 4.0 * before
    confirm_selection(trials, strict)
    for each in trials.run_costs[n_before:]:
        assert each.work <= 2.5 * before  # 2 by the estimate of its iterations
        before += each.work


@pytest.mark.parametrize("base", [1, 50, 100, 333])
def test_numbers_of_steps_share_times(base):
    for steps in (base, 1.01 * base, 7.3 * base, 129.7 * base):
        error_model = round_steps(steps, base)
        assert steps <= error_model <= max(1.13 * steps, steps + base)
        assert np.gcd(error_model, base << 10) >= base // 2


def falling_strain():
    """Waves along the axis of 4 ms, which the coarsest mesh hides under 20 times larger strains."""
    length, section = 5.47, ancf.Circle(0.0286)
    scene, rod = build_beam(
        "thin", (0, 0), (length * np.cos(0.4), length * np.sin(0.4)), "auto", section,
        ancf.Material(1.55e11, 4454, bending_damping=1e-3), "clamp", gravity=(0, -9.81),
    )  # fmt: skip
    scene.point_force(rod.end, ancf.Sine((0.0, 33.5), 6.7))
    return scene, 1.5, ancf.strain(rod.at(0.35 * length)), "3 %"


def whipping_slope():
    """The end of a flexible beam that snaps, where finer meshes still change by 0.2 rad."""
    length, t_end, density = 19.88486013780027, 1.4237271489575967, 1215.701056952705
    section = ancf.Circle(length * 0.010591201189158135)
    material = ancf.Material(184214716.01936802, density, bending_damping=1e-3)
    scene, rod = build_beam("auto", (0, 0), (length, 0), "auto", section, material, "clamp")
    force = 3.859520501262132 * 9.81 * density * section.area * length
    scene.point_force(rod.end, ancf.Ramp((0.0, force), 0.3 * t_end, smooth=True))
    return scene, t_end, ancf.slope_angle(rod.end), "1 %"


def test_waves_that_long_steps_damp_are_refused():
    """Two runs agreed with the estimates, and the error was 31 times as large."""
    with pytest.raises(ancf.PlanError, match="In the last motion it vibrates by up to"):
        ancf.plan(*falling_strain())


def test_a_run_far_from_all_others_is_confirmed_by_a_near_one():
    """Their difference agreed with the estimates, and the error was 12 times as large."""
    plan = ancf.plan(*whipping_slope())
    assert not plan.is_met
    assert plan.error > 1.5 * plan.predictions[0].tolerance


@pytest.mark.parametrize("place", [0.2, 0.27, 0.35, 0.43])
def test_a_run_does_not_confirm_its_own_estimate(place):
    """One mesh shows no order: of the error next to a force it was 1.5, which took 1.01 times."""

    def build(n):
        scene, rod = build_beam(
            "thin", (0, 0), (2, 0), n, ancf.Circle(0.002), ancf.Material(5e10, 3000), "pin",
            tension=800.0,
        )  # fmt: skip
        scene.pin(rod.end)
        scene.point_force(rod.at(2.0 * place), (0.0, -15.0), follow=True)
        return scene, rod.at(2.0 * place)

    scene, point = build("auto")
    plan = ancf.plan(scene, quantity=ancf.static_deflection(point), error="3 %")
    fine, its = build(400)
    exact = ancf.solve_static(fine).displacement(its)
    off = plan.run().position(point)[-1] - np.array(its.position) - exact
    assert plan.is_met
    assert np.linalg.norm(off) <= 0.03 * np.linalg.norm(exact)
    assert plan.cost["runs"] > 1 or plan.predictions[0].error <= 0.5 * plan.predictions[0].tolerance
