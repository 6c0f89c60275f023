"""Plans that make short stiff beams rigid rods, beside motions of beams."""

import dataclasses

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.kernels.catalog import ElementChoice
from ancfsparse.plans.model_error.rigid_link_error import deflection, deflection_effect
from ancfsparse.plans.models.model import RIGID, Model, build_model
from ancfsparse.plans.models.rigid_links import rigid_candidates, rigid_rod
from ancfsparse.plans.selection.element_hierarchy import CABLE
from ancfsparse.plans.selection.rigid_link_selection import select_rigid_links
from tests.beams import build_beam
from tests.plans.comparison import build_trials, distance_from_shorter_steps, largest_distance

STEEL, SOFT = ancf.Material(2e11, 7800), ancf.Material(1e9, 1000)
THICK, SLIM = ancf.Circle(0.05), ancf.Circle(0.01)


def swing(element="auto", n="auto", radius=0.05, dim=2, slope=0.0):
    """A rod that swings about one end from the horizontal, or from a slope."""
    end = np.array([np.cos(slope), -np.sin(slope), 0.0])[:dim]
    down = -9.81 * np.eye(dim)[1]
    return build_beam(element, 0 * end, end, n, ancf.Circle(radius), STEEL, "pin", gravity=down)


def whip(elements=("auto", "auto"), n="auto"):
    """A soft rod at the end of a short stiff one."""
    scene = ancf.Scene()
    link = scene.add_beam(elements[0], (0, 0), (0.2, 0), n, THICK, STEEL)
    rod = scene.add_beam(elements[1], (0.2, 0), (1.2, 0), n, SLIM, SOFT)
    scene.pin(link.start)
    scene.connect(link.end, rod.start)
    return scene, link, rod


@pytest.mark.parametrize("dim", [2, 3])
def test_a_rod_has_the_mass_and_the_inertia_of_its_beam(dim):
    scene, rod = swing(dim=dim, slope=0.3)
    body = build_model(scene, Model({rod.name: RIGID})).bodies[0]
    assert body.mass == pytest.approx(7800 * np.pi * 0.025**2, rel=1e-12)
    assert body.masses == pytest.approx(body.mass * np.array([[1, 1 / 2], [1 / 2, 1 / 3]]))
    assert body.end.position == pytest.approx(rod.end.position, abs=1e-15)
    still = np.zeros(3 if dim == 3 else 1)
    moving = ancf.Scene(np.zeros(dim))

    def velocity(r):
        return np.stack([-r[:, 1], r[:, 0], *np.zeros((dim - 2, len(r)))], axis=1)

    made = "auto", np.zeros(dim), np.eye(dim)[0], "auto", THICK, STEEL
    turned = moving.add_beam(*made, velocity=velocity)
    spin = np.atleast_1d(rigid_rod(turned).angular_velocity)
    assert spin == pytest.approx(still + (np.arange(len(spin)) == len(spin) - 1))
    bent = moving.add_beam(*made, velocity=lambda r: r**2)
    with pytest.raises(ancf.InputError, match="bend or stretch it"):
        rigid_rod(bent)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("slope", [0.0, 1.0])
@pytest.mark.parametrize("ask", [ancf.position, ancf.velocity])
def test_a_rod_that_its_weight_surely_bends_is_not_tried(dim, slope, ask, monkeypatch):
    def select(radius, error):
        scene, rod = swing(radius=radius, dim=dim, slope=slope)
        trials = build_trials(scene, 0.5, ask(rod.end), error)
        return select_rigid_links(trials), trials

    tried = 0
    for radius in (0.05, 0.01, 0.003):
        for error in ("3 %", "0.1 %", "0.003 %"):
            mine, trials = select(radius, error)
            with monkeypatch.context() as patch:
                patch.setattr(
                    "ancfsparse.plans.selection.rigid_link_selection._bends_at_start",
                    lambda *_: False,
                )
                whole, other = select(radius, error)
            assert mine == whole
            tried += bool(other.done) - bool(trials.done)
    assert tried >= 2


@pytest.mark.parametrize("dim", [2, 3])
def test_the_multiplier_of_a_rod_is_its_axial_force(dim):
    """Its own weight hangs on a rod at rest: a mean of m g / 2."""
    scene, rod = swing(dim=dim, slope=np.pi / 2)
    rigid = build_model(scene, Model({rod.name: RIGID}))
    run = ancf.simulate(rigid, 0.1, 1e-2)
    body = rigid.bodies[0]
    stretched = body.mass * 9.81 / 2.0 / rod.stiffnesses()["axial_stiffness"]
    assert deflection(run, body, rod) == pytest.approx(2.0 * stretched, rel=1e-6)


@pytest.mark.parametrize("radius", [0.02, 0.05])
@pytest.mark.parametrize("slope", [0.0, 1.5])
def test_deflections_are_foreseen_from_the_forces_of_a_rod(radius, slope):
    scene, rod = swing(radius=radius, slope=slope)
    rigid = build_model(scene, Model({rod.name: RIGID}))
    run = ancf.simulate(rigid, 1.0, 2e-3)
    beam = build_model(scene, Model({rod.name: CABLE}, {rod.name: 6}))
    motion = ancf.simulate(beam, 1.0, 1e-4, save_every=20)
    far = deflection(run, rigid.bodies[0], rod)
    for make in (ancf.position, ancf.velocity):
        quantity = make(rod.end).in_scene(rigid)
        truth = largest_distance(
            quantity.history(run), make(rod.end).in_scene(beam).history(motion)
        )
        assert truth <= deflection_effect(far, rod, quantity, run) <= 30.0 * truth


def test_short_stiff_links_are_rigid():
    scene, link, rod = whip()
    plan = ancf.plan(scene, 0.5, ancf.position(rod.end), "1 %")
    assert plan.model.elements == {link.name: RIGID, rod.name: CABLE}
    assert link.name not in plan.model.counts
    assert f"{link.name} may be rigid" in str(plan)
    run = plan.run(verify=True)
    fine, _, its = whip(("thin", "thin"), 24)
    off = distance_from_shorter_steps(run, rod.end, fine, its.end, 64)
    assert off <= plan.predictions[0].tolerance
    assert run.measured[0] <= plan.predictions[0].tolerance
    assert np.allclose(run.position(link.end), run.position(rod.start))


def test_what_must_bend_is_not_rigid():
    scene, rod = swing()
    assert rigid_candidates(scene) == [rod.name]
    plan = ancf.plan(scene, 0.2, ancf.position(rod.end), 1e-3)
    assert plan.model.elements == {rod.name: RIGID}
    run = plan.run()
    assert np.allclose(np.linalg.norm(run.position(rod.at(0.5)), axis=1), 0.5, atol=1e-9)
    for of_section in (run.strain, run.section_force, run.curvature):
        with pytest.raises(ancf.InputError, match="is a rigid rod in this run"):
            of_section(rod)
    for quantity, error in (
        (ancf.position(rod.end), 1e-6),
        (ancf.section_force(rod.at(0.5)), "20 %"),
        (ancf.strain(rod.at(0.5)), "20 %"),
    ):
        plan = ancf.plan(scene, 0.02, quantity, error)
        assert plan.model.elements[rod.name] != RIGID
    clamped, rod = swing()
    clamped.clamp(rod.end)
    assert not rigid_candidates(clamped)
    turned, rod = swing()
    turned.add_mass(rod.end, 0.1)
    assert rigid_candidates(turned) == [rod.name]
    turned.add_mass(rod.start, 0.1, inertia=1e-3)
    assert not rigid_candidates(turned)
    loaded, rod = swing()
    loaded.point_force(rod.at(0.5), (0.0, -1.0))
    assert not rigid_candidates(loaded)
    pressed, rod = swing()
    pressed.distributed_force(rod, (0.0, -1.0))
    assert not rigid_candidates(pressed)
    slack = ancf.Scene()
    slack.add_beam("auto", (0, 0), (1, 0), "auto", THICK, STEEL, length=1.1)
    assert not rigid_candidates(slack)


def frame(hinged=False, element="auto", n="auto"):
    """Two columns and a beam that is welded to both, or hinged, pushed from one side."""
    scene = ancf.Scene((0.0, 0.0))
    made = ancf.Rectangle(0.1, 0.1), ancf.Material(2.1e11, 7850.0)
    left = scene.add_beam(element, (0, 0), (0, 3), n, *made)
    above = scene.add_beam(element, (0, 3), (4, 3), n, *made)
    right = scene.add_beam(element, (4, 3), (4, 0), n, *made)
    join = scene.connect if hinged else scene.weld
    for point in (left.start, right.end):
        scene.clamp(point)
    join(left.end, above.start)
    join(above.end, right.start)
    scene.point_force(left.end, ancf.Ramp((2000.0, 0.0), 0.1, smooth=True))
    return scene, left, above, right


def test_what_carries_moments_of_others_is_not_rigid():
    """A rod for the beam of a frame was 34 times the error off: welds did not count as bending."""
    scene, _, above, _ = frame(hinged=True)
    assert rigid_candidates(scene) == [above.name]
    scene, left, *_ = frame()
    assert not rigid_candidates(scene)
    plan = ancf.plan(scene, 0.1, ancf.section_force(left.start), "3 %")
    fine, mine, *_ = frame(element="thin", n=16)
    run, motion = plan.run(), ancf.simulate(fine, 0.1, 0.1 / 3200, save_every=32)
    values = [q.value(r) for q, r in (
        (ancf.section_force(left.start, at="end").in_scene(run.system.scene), run),
        (ancf.section_force(mine.start, at="end"), motion),
    )]  # fmt: skip
    assert abs(values[0] - values[1]).max() <= plan.predictions[0].tolerance


def test_what_both_ends_hold_is_not_rigid():
    """Its two drives repeat the length of a rod, which is no concern of a scene of beams."""
    scene = ancf.Scene((0.0, 0.0))
    crank = scene.add_beam("auto", (0, 0), (0.1, 0), "auto", SLIM, STEEL)
    scene.pin(crank.start)
    scene.drive(crank.end, lambda t: (0.1 * np.cos(t * t), 0.1 * np.sin(t * t)))
    assert rigid_candidates(scene) == [crank.name]
    plan = ancf.plan(scene, 0.5, ancf.position(crank.at(0.05)), "1 %")
    assert plan.model.elements == {crank.name: CABLE}


def test_compression_bends_a_rod_that_is_about_to_buckle():
    def under(load):
        scene, strut = swing(radius=0.01)
        rigid = build_model(scene, Model({strut.name: RIGID}))
        run = ancf.simulate(rigid, 0.1, 1e-2)
        body = rigid.bodies[0]
        rows = dataclasses.replace(run, lam=np.full_like(run.lam, load / body.size))
        return deflection(rows, body, strut)

    critical = np.pi**2 * 2e11 * np.pi * 0.01**4 / 64.0
    bent, pulled, pushed = (under(share * critical) for share in (0.0, 0.2, -0.2))
    stretched = 0.2 * critical / (2e11 * np.pi * 0.005**2)
    assert pulled == pytest.approx(bent + 2.0 * stretched, rel=1e-4)
    assert pushed == pytest.approx(pulled / 0.8, rel=1e-2)
    assert under(-0.6 * critical) == pytest.approx(under(0.6 * critical) / 0.4, rel=1e-2)
    assert under(-1.1 * critical) == np.inf > under(1.1 * critical)


def test_a_rod_in_space_hangs_on_two_links():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    made = "auto", THICK, STEEL
    one = scene.add_beam("auto", (0, 0, 0), (0.2, 0, 0), *made)
    other = scene.add_beam("auto", (0.2, 0, 0), (0.2, 0.3, 0), *made)
    scene.pin(one.start)
    scene.connect(one.end, other.start)
    plan = ancf.plan(scene, 0.3, ancf.position(other.end), "2 %")
    assert list(plan.model.elements.values()) == [RIGID, RIGID]
    run = plan.run(verify=True)
    assert run.measured[0] <= plan.predictions[0].tolerance
    assert str(ElementChoice("rigid")) == '"rigid"'


def test_a_mesh_that_was_given_stays():
    scene = ancf.Scene()
    link = scene.add_beam("auto", (0, 0), (0.2, 0), 6, THICK, STEEL)
    rod = scene.add_beam("auto", (0.2, 0), (1.2, 0), "auto", SLIM, SOFT)
    scene.pin(link.start)
    scene.connect(link.end, rod.start)
    assert rigid_candidates(scene) == [rod.name]
    assert rigid_candidates(whip()[0]) == ["beam 0", "beam 1"]
    alone, beam = swing(n=6)
    plan = ancf.plan(alone, 0.2, ancf.position(beam.end), "10 %")
    assert plan.model.elements[beam.name] != RIGID
    assert plan.build().beams[0].n_elements == 6
    assert "mesh of beam 0 given: the error of given meshes is predicted to be" in str(plan)
