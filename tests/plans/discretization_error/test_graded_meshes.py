"""Graded meshes: beside analytic solutions, and in plans."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.discretization_error import mesh_error, refinement
from ancfsparse.plans.discretization_error.mesh_grading import grade_meshes
from ancfsparse.plans.models.graded_mesh import MeshGrading, error_density
from ancfsparse.plans.models.model import Model
from ancfsparse.plans.selection import confirmation_run
from ancfsparse.problems import pendulum
from tests.beams import build_beam
from tests.plans.comparison import build_trials, largest_distance

LAYER, STIFFNESS, LOAD = 0.01, 1.0, 1e-6  # sqrt(EI / T) / L, N m2, q L / T
TENSION = STIFFNESS / LAYER**2


def taut(n, nodes=None, diameter=3e-5):
    """Clamped cable of 1 m under an even load, so thin that it hardly stretches."""
    inertia = np.pi * diameter**4 / 64.0
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), n, ancf.Circle(diameter), ancf.Material(STIFFNESS / inertia, 1e3),
        "clamp", "clamp", gravity=(0.0, 0.0), tension=TENSION, nodes=nodes,
    )  # fmt: skip
    scene.distributed_force(rod, (0.0, LOAD * TENSION))
    return scene, rod


def deflection(x):
    """Solve EI w'''' - T w'' = q with w = w' = 0 at both ends [m]."""

    def bent(x):
        return (np.exp(-x / LAYER) + np.exp(-(1.0 - x) / LAYER)) / (1.0 - np.exp(-1.0 / LAYER))

    return 0.5 * LOAD * (x * (1.0 - x) + LAYER * (bent(x) - bent(0.0)))


def error(n, x, nodes=None):
    """Relative error of the deflection; that of the linear theory is 7e-7."""
    scene, rod = taut(n, nodes)
    w = ancf.solve_static(scene).position(rod.at(x * rod.length))[1]
    return abs(w / deflection(x) - 1.0)


def equilibrium_of(scene, point, count):
    trials = build_trials(scene, None, ancf.static_deflection(point), "1 %")
    return trials.run(Model(counts={"beam 0": count}), 1)


@pytest.mark.parametrize("x", [0.02, 0.5])
def test_the_error_of_boundary_layers_falls_with_graded_meshes(x):
    scene, rod = taut("auto")
    grades, gain = grade_meshes(scene, equilibrium_of(scene, rod.end, 18))
    assert gain > 1.8
    uniform = [error(n, x) for n in (20, 40, 80)]
    graded = [error(None, x, grades["beam 0"].node_positions(n, [])) for n in (20, 40, 80)]
    # Uniform elements are longer than the layer, so their order has not shown at 20 elements.
    assert uniform[0] > 4e-3
    assert graded[0] < uniform[0] / 4.0
    assert graded[1] < uniform[1] / 15.0
    assert graded[2] < uniform[2] / 15.0
    assert np.log2(graded[0] / graded[2]) / 2.0 > 3.3


def test_a_plan_takes_graded_elements_where_they_are_fewer(monkeypatch):
    scene, rod = taut("auto")
    middle = rod.at(0.5 * rod.length)
    plan = ancf.plan(scene, quantity=ancf.static_deflection(middle), error="0.03 %")
    assert "graded elements" in plan.choice
    assert "times shorter than elsewhere" in str(plan)
    w = plan.run().position(middle)[-1, 1]
    assert abs(w / deflection(0.5) - 1.0) < 3e-4
    with monkeypatch.context() as none:
        none.setattr(mesh_error, "MIN_GRADING_GAIN", np.inf)
        even = ancf.plan(scene, quantity=ancf.static_deflection(middle), error="0.03 %")
    assert plan.model.counts["beam 0"] < 0.6 * even.model.counts["beam 0"]
    assert plan.cost["operations"] < even.cost["operations"]
    # One rung up, all graded elements are divided alike.
    assert plan.run(verify=True).measured[0] <= plan.predictions[0].tolerance


def test_a_motion_takes_graded_elements_where_they_are_fewer(monkeypatch):
    scene, rod = taut("auto", diameter=1e-2)
    middle = rod.at(0.5 * rod.length)
    asked = scene, 0.02, ancf.position(middle), "0.3 %"
    plan = ancf.plan(*asked)
    assert "graded elements" in plan.choice
    run = plan.run()
    for module in (confirmation_run, refinement):
        monkeypatch.setattr(module, "MIN_GRADING_GAIN", np.inf)
    even = ancf.plan(*asked)
    assert plan.model.counts["beam 0"] < 0.7 * even.model.counts["beam 0"]
    work, its = (each.cost["operations"] * (1.0 + 1.0 / each.cost["work"]) for each in (plan, even))
    assert work < its
    fine, own = taut(200, diameter=1e-2)
    exact = ancf.simulate(fine, 0.02, plan.dt / 8, integrator=plan.integrator, save_every=8)
    places = exact.position(own.at(0.5 * own.length))[:: plan.save_every]
    assert largest_distance(run.position(middle), places) <= plan.predictions[0].tolerance


def test_where_nothing_is_concentrated_no_more_trial_runs_are_run(monkeypatch):
    scene, rod = pendulum("thin", "auto")
    asked = scene, 1.0, ancf.position(rod.end), 1e-3
    plan = ancf.plan(*asked)
    monkeypatch.setattr(confirmation_run, "MIN_GRADING_GAIN", np.inf)
    even = ancf.plan(*asked)
    assert plan.choice == even.choice
    assert plan.cost["operations"] == even.cost["operations"]


def test_a_point_load_alone_needs_no_graded_mesh():
    """A cantilever is a cubic on both sides of its load, where r''' jumps at a node."""
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (1, 0), "auto", ancf.Circle(0.01), ancf.Material(1e9, 1e3))
    scene.clamp(rod.start)
    scene.point_force(rod.at(0.3), (0.0, 1e-4))
    assert grade_meshes(scene, equilibrium_of(scene, rod.end, 10)) == ({}, 1.0)


def test_meshes_of_a_grade_keep_inner_places():
    grade = MeshGrading((0.0, 0.1, 1.0), (0.0, 0.5, 1.0))
    assert grade.node_positions(4, []) == pytest.approx([0.0, 0.05, 0.1, 0.55, 1.0])
    nodes = grade.node_positions(8, [0.3, 0.97])
    # Five elements up to 0.3, equal in the share of the elements, which is 11 / 18 there; then
    # three of 0.67 / 3 and one at the end.
    share = np.arange(5) / 5.0 * 11.0 / 18.0
    places = np.interp(share, grade.element_fractions, grade.positions)
    assert nodes == pytest.approx([*places, *np.linspace(0.3, 0.97, 4), 1.0])
    assert grade.length_ratio == pytest.approx(9.0)


def test_fourth_derivatives_by_nodes_of_a_quintic():
    """Divided differences of r''' on uneven elements, exact for polynomials of degree 4."""
    s = np.array([0.0, 0.1, 0.25, 0.3, 0.6, 1.0])
    r = np.stack([s, 2.0 * s**4], axis=1)[None]
    slopes = np.stack([np.ones_like(s), 8.0 * s**3], axis=1)[None]
    f = error_density(r, slopes, np.diff(s), np.zeros(6, dtype=bool))
    assert f == pytest.approx(np.full(5, 48.0**2), rel=1e-9)
    jump = np.zeros(6, dtype=bool)
    jump[2] = True
    r[0, 2:, 1] += 1e3 * (s[2:] - s[2]) ** 3
    slopes[0, 2:, 1] += 3e3 * (s[2:] - s[2]) ** 2
    assert error_density(r, slopes, np.diff(s), jump) == pytest.approx(
        np.full(5, 48.0**2), rel=1e-6
    )
