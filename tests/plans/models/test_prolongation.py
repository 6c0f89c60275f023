"""Equilibria on finer meshes that begin with those of coarser ones."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.models.prolongation import prolongate
from ancfsparse.plans.trial_runs import trial_runs
from ancfsparse.plans.trial_runs.trial_runs import as_trajectory
from ancfsparse.system import System
from tests.beams import build_beam

PLACES = np.linspace(0.0, 1.0, 41)


def cantilever(element, n, nodes=None, dim=2, **options):
    none = (0.0,) * (dim - 2)
    scene, rod = build_beam(
        element, (0, 0, *none), (1, 0, *none), n, ancf.Circle(0.02), ancf.Material(1e8, 1e3, 0.3),
        "clamp", gravity=(0.0, -9.81, *none), nodes=nodes, **options,
    )  # fmt: skip
    scene.point_force(rod.end, (0.05, 0.1, *none))
    return scene, rod


@pytest.mark.parametrize(("element", "dim"), [("thin", 2), ("l2t2", 2), ("thick", 2), ("thin", 3),
                                              ("thick", 3)])  # fmt: skip
@pytest.mark.parametrize("nodes", [None, (0.0, 0.1, 0.125, 0.3, 0.5, 0.6, 1.0)])
def test_a_finer_mesh_begins_in_the_same_shape(element, dim, nodes):
    coarse, rod = cantilever(element, 4, dim=dim)
    run = as_trajectory(ancf.solve_static(coarse))
    fine, its = cantilever(element, 12 if nodes is None else None, nodes, dim)
    state = prolongate(run, fine)
    at = System(fine, state)
    # If every element is divided, the shape is the same everywhere.
    everywhere = [its.at(s) for s in PLACES] if nodes is None else []
    for point in [*everywhere, *(its.node(node) for node in range(its.n_nodes))]:
        places, weights = at.point(point)
        place = run.position(rod.at(point.s))[0]
        assert at.q0[places] @ weights == pytest.approx(place, abs=1e-12)
    warm, cold = ancf.solve_static(fine, start=state), ancf.solve_static(fine)
    assert warm.position(its.end) == pytest.approx(cold.position(its.end), abs=1e-9)
    # Between the nodes of thick beams sections are not at right angles, as they nearly should be.
    more = 1 if element == "thick" else 0
    assert warm.stats.factorizations < cold.stats.factorizations + more


def test_strings_meshes_and_rods_are_carried_over_or_begun_again():
    def net(element, k, rods):
        made = ancf.Circle(0.002), ancf.Material(1e9, 1e3)
        scene, rope = build_beam("string", (0, 0), (1, 0), k, *made, length=1.01)
        mesh = scene.add_mesh([(0, 0), (0.5, 0.5), (1, 0)], [(0, 1), (1, 2)], element, *made)
        scene.pin(rope.start)
        scene.pin(rope.end)
        for node in (0, 2):
            scene.pin(mesh.node(node))
        for _ in range(rods):
            scene.add_body(position=(2.0, 0.0), mass=1.0, inertia=1.0)
        return scene, rope

    coarse, rope = net("string", 4, 0)
    run = as_trajectory(ancf.solve_static(coarse))
    fine, its = net("string", 8, 0)
    state = prolongate(run, fine)
    at = System(fine, state)
    for s in PLACES * rope.length:
        places, weights = at.point(its.at(s))
        assert at.q0[places] @ weights == pytest.approx(run.position(rope.at(s))[0], abs=1e-12)
    assert prolongate(run, net("thin", 8, 0)[0]) is None
    assert prolongate(run, net("string", 8, 1)[0]) is None


def test_the_response_of_a_line_in_tension_is_measured():
    """A plan makes it stiffer, by which its length without stress changes."""
    made = ancf.Circle(0.02), ancf.Material(1e8, 1e3)
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), "auto", *made, "clamp", "clamp", gravity=(0.0, 0.0), tension=30.0
    )
    place = rod.at(0.25 * rod.length)
    scene.point_force(place, (0.0, -1.0))
    plan = ancf.plan(scene, quantity=ancf.static_deflection(place), error="0.05 %")
    assert plan.is_met
    assert "it neglects about shear" in str(plan)


def test_plans_of_equilibria_take_less_work_for_the_same_choice(monkeypatch):
    def planned():
        scene, rod = cantilever("thin", "auto")
        return ancf.plan(scene, quantity=ancf.static_deflection(rod.end), error="0.01 %")

    warm = planned()
    monkeypatch.setattr(trial_runs, "prolongate", lambda run, scene: None)
    cold = planned()
    assert warm.choice == cold.choice
    assert warm.error == pytest.approx(cold.error, rel=1e-3)
    assert warm.cost["operations"] < 0.75 * cold.cost["operations"]
