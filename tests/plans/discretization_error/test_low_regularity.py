"""Quantities after jumps, which converge slowly, and forces that have no limit at the start."""

import pickle

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.discretization_error.initial_singularity import check_initial_force
from ancfsparse.plans.discretization_error.richardson import MIN_ORDER
from ancfsparse.plans.discretization_error.run_series import bound
from ancfsparse.plans.discretization_error.vibrations import find_swings
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.selection import method_selection
from ancfsparse.plans.trial_runs import trial_runs
from ancfsparse.plans.trial_runs.solution_methods import SolutionMethod
from tests.beams import build_beam
from tests.plans.comparison import build_trials


@pytest.mark.parametrize("order", [0.6, 0.8, 1.0])
def test_the_bound_of_a_regular_series_is_what_is_left(order):
    errors = 3.0 * 2.0 ** (-order * np.arange(4.0))
    error_model, left = bound(-np.diff(errors))
    assert error_model == pytest.approx(order)
    assert left == pytest.approx(errors[-1])


def test_chance_and_high_orders_are_not_believed():
    assert bound([4.0, 2.0, 1e-6]) == (1.0, 1.0)  # the one before the last, halved
    assert bound([64.0, 8.0, 1.0]) == (1.0, 4.0)
    order, left = bound([1.0, 0.5, 2.0])  # none falls
    assert order == MIN_ORDER
    assert left == pytest.approx(2.0 / (2.0**MIN_ORDER - 1.0))
    assert bound([0.0, 0.0, 0.0]) == (1.0, 0.0)


def struck(element, n):
    """Build a cantilever whose end a force pushes at once, and leaves as suddenly."""
    made = ancf.Rectangle(0.01, 0.01), ancf.Material(2e9, 1000.0, 0.3)
    scene, beam = build_beam(element, (0, 0), (1, 0), n, *made, "clamp", gravity=(0.0, 0.0))
    scene.point_force(beam.end, ancf.Pulse((0.0, 2.0), 0.0, 0.05))
    return scene, beam


@pytest.mark.parametrize(
    ("ask", "t_end", "error"),
    [
        (lambda beam: ancf.section_force(beam.start, at="largest"), 0.5, "3 %"),
        (lambda beam: ancf.strain(beam.start, at="largest"), 0.2, "10 %"),
    ],
)
def test_peaks_after_a_pulse_have_plans_that_hold(ask, t_end, error):
    scene, beam = struck("thin", "auto")  # other elements have other strains of a bent axis
    plan = ancf.plan(scene, t_end, ask(beam), error)
    assert plan.is_met
    error_model = ask(beam).value(plan.run())
    fine, its = struck("thin", 120)
    run = ancf.simulate(fine, t_end, t_end / 20000, integrator=ancf.GeneralizedAlpha(0.9))
    assert abs(error_model - ask(its).value(run))[0, 0] <= plan.predictions[0].tolerance


def test_peaks_of_motions_that_differ_are_not_believed():
    """The last two of four peaks agree to 3 % of the tolerance, and are 1.6 tolerances off.

    Their motions differ by 14 % of the peak.
    """
    rich = {"curvature": "section", "section_strain": "nodal"}

    def struck_span(n, **options):
        scene = ancf.Scene(gravity=(0.0, -9.81))
        made = ancf.Circle(0.0159786), ancf.Material(9.29045e9, 1265.07)
        span = scene.add_beam("thick", (0, 0), (0.901826, 0), n, *made, **rich, **options)
        scene.pin(span.start)
        scene.pin(span.end)
        pulse = ancf.Pulse((0.0, 1.90414), 0.0233233, 0.0399144)
        scene.point_force(span.at(0.63956), pulse)
        return scene, ancf.section_force(span.at(0.777383), "M", at="largest")

    t_end = 0.1166166
    scene, moment = struck_span("auto")
    plan = ancf.plan(scene, t_end, moment, "1.4788 %")
    fine, its = struck_span(192)
    exact = its.value(ancf.simulate(fine, t_end, t_end / 51200, save_every=8))
    assert abs(moment.value(plan.run()) - exact)[0, 0] <= plan.predictions[0].tolerance


def test_errors_far_out_of_reach_are_refused():
    scene, beam = struck("auto", "auto")
    with pytest.raises(ancf.PlanError, match=r"section force|moment"):
        ancf.plan(scene, 0.1, ancf.section_force(beam.start, at="largest"), 5e-324)


def slack(element, n):
    """Build a rope with an arch of its own length, whose pins hold no moment of its bending."""
    made = ancf.Circle(0.01), ancf.Material(1e7, 1000.0)
    scene, rope = build_beam(element, (0, 0), (1, 0), n, *made, "pin", "pin", length=1.1)
    return scene, rope


def test_a_force_without_a_limit_at_the_start_has_no_plan():
    forces = []
    for n in (64, 128, 256):
        scene, rope = slack("thin", n)
        run = ancf.simulate(scene, 1e-6, 1e-6)
        forces.append(np.linalg.norm(run.reaction(rope.start)[0]))
    assert forces[2] / forces[1] == pytest.approx(2.0, rel=0.05)
    assert forces[1] / forces[0] == pytest.approx(2.0, rel=0.1)
    scene, rope = slack("auto", "auto")
    largest = ancf.reaction(rope.start, at="largest")
    with pytest.raises(ancf.PlanError, match="has no limit at t = 0, where it") as caught:
        ancf.plan(scene, 0.3, largest, "10 %")
    assert "Begin with start='equilibrium', or request it at='end'." in str(caught.value)
    assert ancf.plan(scene, 0.3, largest, "10 %", start="equilibrium").is_met


def test_a_reaction_of_a_straight_rod_has_a_plan():
    pinned, rod = build_beam(
        "thin", (0, 0), (1, 0), "auto", ancf.Circle(0.01), ancf.Material(1e8, 1000.0), "pin"
    )
    plan = ancf.plan(pinned, 0.5, ancf.reaction(rod.start), "5 %")
    assert plan.is_met


@pytest.mark.parametrize("part", ["M", "Q", "N"])
@pytest.mark.parametrize("hold", ["pin", "clamp"])
def test_rounding_of_a_force_at_the_start_is_no_growth(hold, part):
    """Inclined straight beams at rest have forces of rounding, which grows with the mesh."""
    for angle in (0.4, -1.2, 1.3):
        end = 2.0 * np.cos(angle), 2.0 * np.sin(angle)
        made = ancf.Circle(0.02), ancf.Material(2e11, 4000.0, bending_damping=1e-2)
        scene, rod = build_beam("thin", (0, 0), end, "auto", *made, hold)
        trials = build_trials(scene, 0.1, ancf.section_force(rod.at(0.7), part), 0.1)
        model = Model({rod.name: "thin"})
        for n_longest in (8, 16):
            run = trials.run(trials.with_mesh(model, n_longest), 16)
        check_initial_force(trials, run)


def test_a_refusal_names_vibrations_and_what_ends_them(monkeypatch):
    """The reaction of a rod of steel that gravity lets swing, and bends at once."""
    monkeypatch.setattr(trial_runs, "SEARCH_BUDGET", 1e7)
    monkeypatch.setattr(trial_runs, "MAX_WORK_RATIO", 0.0)

    def dropped(damping):
        steel = ancf.Material(2e11, 7800.0, axial_damping=damping, bending_damping=damping)
        scene, rod = build_beam("thin", (0, 0), (1, 0), "auto", ancf.Circle(0.02), steel, "pin")
        return scene, ancf.reaction(rod.start)

    scene, reaction = dropped(0.0)
    with pytest.raises(ancf.PlanError, match="In the last motion it vibrates by up to") as caught:
        ancf.plan(scene, 0.2, reaction, "1 %")
    assert "axial_damping and bending_damping of the material damp" in str(caught.value)
    assert str(pickle.loads(pickle.dumps(caught.value))) == str(caught.value)
    scene, reaction = dropped(1e-3)
    assert ancf.plan(scene, 0.2, reaction, "1 %").is_met


def test_a_refusal_names_equilibria_that_cease_to_exist(monkeypatch):
    """Two beams that lean on each other, pushed through; no steps have a plan."""
    whole = method_selection.select_model

    def hopeless(trials, finer, steps):
        if isinstance(trials.integrator, SolutionMethod):
            return whole(trials, finer, steps)
        raise ancf.PlanError("position", 1e-3, 2e-3, "m", 4, 1.5, ("It vibrates",))

    monkeypatch.setattr(method_selection, "select_model", hopeless)
    scene = ancf.Scene((0.0, 0.0))
    made = ancf.Circle(0.02), ancf.Material(1e7, 1000.0)
    left = scene.add_beam("thin", (0, 0), (1, 0.1), "auto", *made)
    right = scene.add_beam("thin", (1, 0.1), (2, 0), "auto", *made)
    scene.pin(left.start)
    scene.pin(right.end)
    scene.connect(left.end, right.start)
    scene.point_force(left.end, ancf.Ramp((0.0, -3.0), 2.0))
    with pytest.raises(
        ancf.PlanError,
        match=r"It vibrates\. Statics at all times is not applicable: .* the equilibrium path ends",
    ):
        ancf.plan(scene, 2.0, ancf.position(left.end), "5 %")


def test_swings_count_from_turn_to_turn():
    t = np.linspace(0.0, 1.0, 1001)
    rows, sizes = find_swings(np.sin(2.0 * np.pi * 10.0 * t), 1.0)
    assert len(rows) == 19
    assert np.allclose(np.diff(rows), 50, atol=1)
    assert np.allclose(sizes, 2.0, rtol=1e-2)
    assert len(find_swings(0.4 * np.sin(2.0 * np.pi * 10.0 * t), 1.0)[0]) == 0
    assert len(find_swings(t, 0.0)[0]) == 0
