"""Plans that take central differences where their stable step is no burden."""

import pytest

import ancfsparse as ancf
from ancfsparse.plans.selection.explicit_alternative import (
    EXPLICIT,
    STABLE_FRACTION,
    stable_step_bound,
)
from tests.beams import build_beam
from tests.plans.comparison import DAMPED, distance_from_shorter_steps


def line(element="auto", n="auto", radius=0.02):
    """A slightly taut line that begins to fall."""
    made = ancf.Circle(radius), ancf.Material(1e8, 1000)
    scene, cord = build_beam(
        element, (0, 0), (1, 0), n, *made, "pin", "pin", tension=1e6 * radius**2
    )
    return scene, cord.at(0.5)


def test_a_short_motion_on_a_coarse_mesh_is_marched_explicitly():
    scene, point = line()
    plan = ancf.plan(scene, 0.02, ancf.position(point), "1 %")
    assert plan.integrator == ancf.CentralDifference()
    assert "explicit steps take less work" in str(plan)
    assert plan.dt <= ancf.stable_step(plan.build(), plan.integrator)
    run = plan.run(verify=True)
    fine, its = line("thin", 32)
    off = distance_from_shorter_steps(run, point, fine, its, 16)
    assert off <= plan.predictions[0].tolerance
    assert run.measured[0] <= plan.predictions[0].tolerance
    implicit = ancf.plan(scene, 0.02, ancf.position(point), "1 %", integrator=DAMPED)
    assert run.stats.residual_evaluations < implicit.run().stats.residual_evaluations
    assert run.stats.solves + run.stats.factorizations < 2 * run.stats.steps


def test_a_stiff_mesh_is_not():
    scene, point = line(radius=0.2)
    plan = ancf.plan(scene, 0.5, ancf.position(point), "3 %")
    assert plan.integrator == DAMPED


@pytest.mark.parametrize(("stiffness", "integrator"), [(1e8, EXPLICIT), (1e9, DAMPED)])
def test_explicit_steps_resolve_a_contact_that_begins_later(stiffness, integrator):
    """With 1e8 N/m2 it shortens the stable step of the line by 5 %, with 1e9 to a third."""
    scene, point = line("thin", 8)
    free = ancf.stable_step(scene, EXPLICIT)
    floor = ancf.HalfSpace((0, -0.0215), (0, 1))
    scene.contact(scene.beams[0], floor, stiffness=stiffness)
    assert ancf.stable_step(scene, EXPLICIT) < 0.96 * free
    plan = ancf.plan(scene, 0.02, ancf.position(point), "1 %")
    assert plan.integrator == integrator
    if integrator == EXPLICIT:
        assert plan.dt <= STABLE_FRACTION * ancf.stable_step(plan.build(), EXPLICIT)
    assert plan.run().finished


SHEARED = {"curvature": "section", "section_strain": "nodal"}


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize(("element", "options"), [("thin", {}), ("thick", {}), ("thick", SHEARED)])
def test_no_stable_step_is_longer_than_the_slope_of_one_node_allows(dim, element, options):
    made = ancf.Circle(0.02), ancf.Material(1e8, 1000, 0.3)
    none = (0,) * (dim - 1)
    for n, heavy in ((2, False), (3, True), (8, True)):
        scene = ancf.Scene((*none, -9.81))
        beam = scene.add_beam(element, (0, *none), (1, *none), n, *made, **options)
        (scene.clamp if heavy else scene.pin)(beam.start)
        if heavy:
            scene.add_mass(beam.end, 1.0)
        ratio = stable_step_bound(scene) / ancf.stable_step(scene, EXPLICIT)
        assert ratio >= 1.0
        assert element != "thin" or ratio <= 3.0
