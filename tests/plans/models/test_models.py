"""Beams whose element and mesh are open: handles, rebuilt scenes, refusals."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.kernels.catalog import ElementChoice
from ancfsparse.plans.models.model import (
    Model,
    build_model,
    element_counts,
    find_counterpart,
)

BAR = ancf.Rectangle(0.01, 0.01)
RUBBER = ancf.Material(1e8, 4000)


def open_scene(element="thin", n_elements="auto", dim=2):
    scene = ancf.Scene((0.0, -9.81, 0.0)[:dim])
    ends = np.zeros(dim), np.eye(dim)[0] * 2.0
    return scene, scene.add_beam(element, *ends, n_elements, BAR, RUBBER)


@pytest.mark.parametrize("count", [3, 7, 10, 64])
@pytest.mark.parametrize("s", [0.0, 0.5, 0.74, 2.0 / 3.0, 1.999, 2.0])
def test_a_handle_by_arc_length_is_the_same_point_on_every_mesh(count, s):
    scene, rod = open_scene()
    new = build_model(scene, Model(counts={rod.name: count}))
    point = find_counterpart(new, rod.at(s))
    assert point.beam.n_elements == count
    assert point.s == pytest.approx(s, abs=1e-12)


@pytest.mark.parametrize("count", [3, 10, 25])
def test_places_of_joints_are_nodes_of_every_mesh(count):
    scene, rod = open_scene()
    scene.pin(rod.at(0.74))
    scene.point_force(rod.at(2.0 / 3.0), (0.0, -1.0))
    new = build_model(scene, Model(counts={rod.name: count}))
    assert new.joints[0].nodes[0].is_node
    assert new.joints[0].nodes[0].s == pytest.approx(0.74, abs=1e-12)
    assert new.loads[0].node.s == pytest.approx(2.0 / 3.0, abs=1e-12)
    assert count <= new.bodies[0].n_elements <= 1.2 * count + 2


def test_results_take_the_handles_of_the_scene_that_was_planned():
    scene, rod = open_scene()
    scene.pin(rod.start)
    new = build_model(scene, Model(counts={rod.name: 6}))
    run = ancf.simulate(new, 0.02, 1e-3)
    own = new.bodies[0]
    assert np.array_equal(run.position(rod.end), run.position(own.end))
    assert np.array_equal(run.slope(rod.at(0.5)), run.slope(own.at(0.5)))
    assert np.array_equal(run.reaction(rod.start), run.reaction(own.start))
    assert np.array_equal(run.strain(rod), run.strain(own))
    mine = run.section_force(rod, [rod.at(0.5)]).M
    assert np.array_equal(mine, run.section_force(own, [own.at(0.5)]).M)


def test_elements_and_options_are_put_into_the_records():
    scene, rod = open_scene("auto", 5, 3)
    thick = ElementChoice("thick", {"curvature": "section", "section_strain": "nodal"})
    beam = build_model(scene, Model(elements={rod.name: thick})).bodies[0]
    assert (beam.element, beam.n_elements) == ("thick", 5)
    assert beam.options["curvature"] == "section"


def test_a_scene_without_open_beams_is_itself():
    scene, _ = open_scene(n_elements=4)
    assert build_model(scene, Model()) is scene


def test_an_open_scene_is_a_scene(tmp_path):
    scene, rod = open_scene("auto")
    scene.pin(rod.at(0.3))
    scene.save(tmp_path / "scene.json")
    assert ancf.Scene.load(tmp_path / "scene.json") == scene
    assert scene.replaced() == scene
    assert "auto" in str(scene)
    assert "auto" in repr(rod)
    fixed = scene.replaced(rod, n_elements=20, element="thin")
    assert fixed.bodies[0].n_elements == 20
    assert fixed.joints[0].nodes[0].s == pytest.approx(0.3)
    again = fixed.replaced(fixed.bodies[0], n_elements="auto", element="auto")
    assert again == scene


def test_elements_of_one_length_are_spread_over_beams():
    scene, rod = open_scene()
    short = scene.add_beam("thin", (0, 0), (0, 0.5), "auto", BAR, RUBBER)
    given = scene.add_beam("thin", (1, 0), (1, 0.5), 3, BAR, RUBBER)
    assert element_counts(scene, 8.0) == {rod.name: 8, short.name: 2}
    assert given.name not in element_counts(scene, 8.0)
    assert element_counts(scene, 1.0) == {rod.name: 1, short.name: 1}


@pytest.mark.parametrize("n_longest", [4.5, 5.0, 7.5, 13.5])
def test_equal_lengths_get_equal_numbers_of_elements(n_longest):
    scene = ancf.Scene()
    ends = [(0.1 * k, 0.1 * (k + 1)) for k in range(8)]
    beams = [scene.add_beam("thin", (a, 0), (b, 0), "auto", BAR, RUBBER) for a, b in ends]
    assert len({beam.length for beam in beams}) > 1  # they differ by rounding
    (count,) = set(element_counts(scene, n_longest).values())
    assert abs(count - n_longest) <= 0.5
    long = scene.add_beam("thin", (0, 1), (0.2, 1), "auto", BAR, RUBBER)
    counts = element_counts(scene, n_longest)
    whole = counts.pop(long.name)
    assert abs(whole - n_longest) <= 0.5
    assert len(set(counts.values())) == 1


def test_equal_parts_of_a_beam_get_equal_numbers_of_elements():
    scene, rod = open_scene()
    for share in (0.1, 0.3, 0.5, 0.7, 0.9):
        scene.point_force(rod.at(2.0 * share), (0.0, -1.0))
    (body,) = build_model(scene, Model(counts={rod.name: 25})).bodies
    assert body.n_elements == 4 * 7 + 2 * 4
    assert np.allclose(np.diff(body.arcs)[4:-4], 0.4 / 7, rtol=1e-12)


@pytest.mark.parametrize("use", [lambda s: ancf.simulate(s, 0.1, 1e-3), ancf.solve_static])
def test_only_a_plan_builds_it(use):
    scene, _ = open_scene("auto")
    with pytest.raises(ancf.InputError, match="and n_elements='auto', which a plan"):
        use(scene)


def test_what_is_open_cannot_be_refined_and_odd_numbers_are_refused():
    scene, _ = open_scene()
    with pytest.raises(ancf.InputError, match="nothing can be refined"):
        scene.refined(2)
    with pytest.raises(ancf.InputError, match="must be an integer, got 'many'"):
        open_scene(n_elements="many")
