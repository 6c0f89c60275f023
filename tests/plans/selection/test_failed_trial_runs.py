"""Plans whose trial runs fail: shorter steps, another method, or an error that says why."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans import planning
from ancfsparse.plans.trial_runs import trial_runs
from ancfsparse.plans.trial_runs.solution_methods import Statics
from tests.beams import build_beam

FREE = {"gravity": (0.0, 0.0)}


def test_resonances_that_move_with_the_mesh_are_refused():
    """A force of 1 kHz, near the frequency of another mode on every mesh."""
    made = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000)
    scene, rod = build_beam("auto", (0, 0), (1, 0), "auto", *made, "pin", **FREE)
    scene.point_force(rod.end, ancf.Sine((0, 100.0), 1000.0, np.pi / 2))
    with pytest.raises(ancf.PlanError, match="does not converge as meshes and steps are refined"):
        ancf.plan(scene, 0.1, ancf.position(rod.end), 1e-3)


@pytest.mark.parametrize("error", ["3 %", "0.3 %", "0.03 %"])
def test_explicit_plans_are_trial_runs(error):
    made = ancf.Circle(0.02), ancf.Material(1e8, 1000)
    scene, line = build_beam("thin", (0, 0), (1, 0), "auto", *made, "pin", "pin", tension=400.0)
    plan = ancf.plan(scene, 0.02, ancf.position(line.at(0.5)), error)
    assert isinstance(plan.integrator, ancf.CentralDifference)
    assert plan.result is not None
    assert plan.dt <= ancf.stable_step(plan.build(), plan.integrator)


def test_a_whipped_string_whose_energy_grows_with_long_steps_is_planned():
    length, time = 2.993794665192686, 0.5524290412219393
    section, density = ancf.Circle(length * 0.0023300890163628473), 4034.945936007579
    weight = 9.81 * density * section.area * length
    made = section, ancf.Material(15941210.47957172, density)
    scene, rod = build_beam("auto", (0, 0), (length, 0), "auto", *made, "pin", **FREE)
    push = 0.0, 4.576979377758091 * weight
    scene.point_force(rod.at(0.6 * length), ancf.Pulse(push, 0.37 * time, 0.52 * time))
    plan = ancf.plan(scene, time, ancf.position(rod.end), "10 %")
    run = plan.run(verify=True)
    assert plan.is_met
    assert run.measured[0] <= plan.predictions[0].tolerance


def pendulum(given=False):
    """A pendulum; or two links, the mesh of one of which is given."""
    made = ancf.Circle(0.02), ancf.Material(1e8, 1000)
    scene, rod = build_beam("thin", (0, 0), (1, 0), "auto", *made, "pin")
    if given:
        link = scene.add_beam("thin", (1, 0), (1.5, 0), 4, *made)
        scene.connect(rod.end, link.start)
    return scene, rod.end


def fail_if(monkeypatch, fails, kind=ancf.ConvergenceError):
    """Let trial runs fail whose numbers of elements and steps satisfy a condition."""
    run = trial_runs.run_request

    def failing(request, system):
        elements = sum(beam.n_elements for beam in request.scene.beams)
        if not fails(elements, request.n_steps):
            return run(request, system)
        dt = request.t_end / request.n_steps
        if kind is ancf.EnergyIncreaseError:
            raise kind(0.2, 1.0, 0.01, 0.1, 7, dt)
        raise kind("no convergence in 25 iterations", 0.1, 7, dt, 1.0, "beam 0")

    monkeypatch.setattr(trial_runs, "run_request", failing)


@pytest.mark.parametrize("kind", [ancf.ConvergenceError, ancf.EnergyIncreaseError])
@pytest.mark.parametrize(
    ("given", "dt", "coarse"), [(False, None, 8), (True, None, 12), (False, 1 / 500, 8)]
)
def test_steps_that_fail_on_finer_meshes_alone_are_shortened(given, dt, coarse, kind, monkeypatch):
    scene, tip = pendulum(given)
    fail_if(monkeypatch, lambda elements, steps: elements > coarse and steps < 1000, kind)
    plan = ancf.plan(scene, 0.5, ancf.position(tip), "3 %", dt=None if dt is None else 0.5 * dt)
    assert plan.steps >= 1000 or sum(plan.model.counts.values()) <= coarse or dt is not None
    assert plan.is_met


@pytest.mark.parametrize("named", ["auto", ancf.Newmark(0.1)])
@pytest.mark.parametrize(
    ("kind", "words"),
    [
        (ancf.ConvergenceError, "No convergence in 25 iterations"),
        (ancf.EnergyIncreaseError, "gained 0.2 J that no load accounts for"),
    ],
)
def test_runs_that_fail_with_any_step_are_no_plan(kind, words, named, monkeypatch):
    scene, tip = pendulum()
    fail_if(monkeypatch, lambda elements, steps: True, kind)
    with pytest.raises(ancf.PlanError, match="fail with any step") as refused:
        ancf.plan(scene, 0.5, ancf.position(tip), "3 %", integrator=named)
    assert words in str(refused.value)
    assert "at t = 0.1 s" in str(refused.value)
    assert "max_halvings" not in str(refused.value)


def test_equilibria_that_fail_on_the_selected_mesh_are_marched(monkeypatch):
    scene = ancf.Scene()
    made = ancf.Circle(0.005), ancf.Material(1e8, 1000)
    rope = scene.add_beam("thin", (0, 0), (1, 0), "auto", *made, length=1.1)
    scene.pin(rope.start)
    scene.drive(rope.end, ancf.Ramp((0.08, 0.0), 20.0, smooth=True) + np.array([1.0, 0.0]))
    goal = ancf.position(rope.at(0.55)), "20 %"
    assert "statics" in ancf.plan(scene, 20.0, *goal).choice
    confirm = planning.confirm_selection

    def failing(trials, error_model):
        if isinstance(trials.integrator, Statics):
            raise ancf.EquilibriumError("the path ended", 0.5, 1.0, "beam 0")
        return confirm(trials, error_model)

    monkeypatch.setattr(planning, "confirm_selection", failing)
    assert ancf.plan(scene, 20.0, *goal).integrator == ancf.GeneralizedAlpha(0.9)


def test_trial_runs_end_when_they_take_too_long(monkeypatch):
    """Those of a pendulum over 1e20 s went on for minutes; here the budget ends them."""
    monkeypatch.setattr(trial_runs, "SEARCH_BUDGET", 0.0)
    monkeypatch.setattr(trial_runs, "MAX_WORK_RATIO", 0.5)
    made = ancf.Circle(0.01), ancf.Material(1e8, 1000.0)
    scene, rod = build_beam("thin", (0, 0), (1, 0), "auto", *made, "pin")
    with pytest.raises(ancf.PlanError, match=r"runs of up to .* would take too long") as caught:
        ancf.plan(scene, 2.0, ancf.position(rod.end), "0.1 %", dt=1e-3)
    assert str(caught.value).endswith("accuracy= or dt=.")
