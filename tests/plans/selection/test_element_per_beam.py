"""Plans with another element for single beams, beside fine meshes of the richest."""

import numpy as np

import ancfsparse as ancf
from ancfsparse.plans.models.model import Model, build_model
from ancfsparse.plans.selection.element_hierarchy import (
    CABLE,
    SHEARED,
    STRING,
    beams_rejecting,
    candidates,
)
from tests.plans.comparison import build_trials, distance_from_shorter_steps

RUBBER, SOFT = ancf.Material(1e7, 1000, 0.3), ancf.Material(1e9, 1000)


def line_on_an_arm():
    """A taut line between the end of a stiff arm and a wall, let go into its weight."""
    scene = ancf.Scene()
    arm = scene.add_beam("auto", (0, 0), (1, 0), "auto", ancf.Rectangle(0.05, 0.05), SOFT)
    line = scene.add_beam("auto", (1, 0), (2, 0), "auto", ancf.Circle(0.002), SOFT, tension=20.0)
    scene.clamp(arm.start)
    scene.connect(arm.end, line.start)
    scene.pin(line.end)
    return scene, arm, line


def stub_and_strip():
    """A short thick beam of rubber, held by a long thin one."""
    scene = ancf.Scene((0, 0))
    stub = scene.add_beam("auto", (0, 0), (0.3, 0), "auto", ancf.Rectangle(0.1, 0.1), RUBBER)
    strip = scene.add_beam("auto", (0.3, 0), (1.3, 0), "auto", ancf.Rectangle(0.02, 0.02), RUBBER)
    scene.clamp(stub.start)
    scene.connect(stub.end, strip.start)
    scene.pin(strip.end)
    scene.point_force(stub.end, (0, -20.0))
    return scene, stub, strip


def test_a_line_on_a_stiff_arm_is_a_string():
    scene, arm, line = line_on_an_arm()
    point = line.at(0.5)
    plan = ancf.plan(scene, 0.3, ancf.position(point), "25 %", dt=1.5e-3)
    assert plan.model.elements == {arm.name: CABLE, line.name: STRING}
    assert f"string elements suffice for {line.name}" in str(plan)
    run = plan.run(verify=True)
    fine = build_model(
        scene, Model({arm.name: SHEARED, line.name: CABLE}, {arm.name: 12, line.name: 24})
    )
    off = distance_from_shorter_steps(run, point, fine, point, 32)
    assert off <= plan.predictions[0].tolerance
    assert run.measured[0] <= plan.predictions[0].tolerance


def check_against_sheared(plan, scene, point, n):
    """Compare a planned deflection with that of all beams thick and divided into n elements."""
    names = [beam.name for beam in scene.beams]
    fine = build_model(scene, Model(dict.fromkeys(names, SHEARED), dict.fromkeys(names, n)))
    off = plan.run().position(point)[-1] - ancf.solve_static(fine).position(point)
    assert np.linalg.norm(off) <= plan.predictions[0].tolerance


def test_only_the_beam_that_shears_is_thick():
    scene, stub, strip = stub_and_strip()
    plan = ancf.plan(scene, quantity=ancf.static_deflection(stub.end), error="1 %")
    assert plan.model.elements == {stub.name: SHEARED, strip.name: CABLE}
    assert f"{strip.name} may remain" in str(plan)
    check_against_sheared(plan, scene, stub.end, 48)
    rough = ancf.plan(scene, quantity=ancf.static_deflection(stub.end), error="30 %")
    assert rough.model.elements == {stub.name: CABLE, strip.name: CABLE}


def test_only_the_beam_that_rejects_a_cable_is_thick():
    """One of two beams in space has a flat section."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    flat = scene.add_beam(
        "auto", (0, 0, 0), (0.5, 0, 0), "auto", ancf.Rectangle(0.05, 0.02), RUBBER
    )
    cord = scene.add_beam("auto", (0.5, 0, 0), (0.5, 0.5, 0), "auto", ancf.Circle(0.01), RUBBER)
    scene.clamp(flat.start)
    scene.connect(flat.end, cord.start)
    scene.pin(cord.end)
    scene.point_force(flat.end, (0.0, -0.5, 0.3))
    trials = build_trials(scene, None, ancf.static_deflection(flat.end), "3 %")
    assert candidates(trials)[0][0] != CABLE
    assert beams_rejecting(trials, CABLE, SHEARED) == [flat.name]
    plan = ancf.plan(scene, quantity=ancf.static_deflection(flat.end), error="3 %")
    assert plan.model.elements == {flat.name: SHEARED, cord.name: CABLE}
    check_against_sheared(plan, scene, flat.end, 40)
