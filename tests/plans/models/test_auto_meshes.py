"""Nets whose number of elements on every edge a plan chooses."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.models.model import Model, build_model, coarse_count, element_counts
from ancfsparse.plans.selection.element_hierarchy import CABLE
from ancfsparse.system import System
from tests.grids import level_grid
from tests.plans.comparison import largest_distance

SECTION, RUBBER = ancf.Circle(0.004), ancf.Material(1e7, 1000.0)


def hammock(element, n, cells=3, scene=None):
    """Square net of 1 m, held at its corners, that hangs or falls."""
    scene = scene or ancf.Scene((0.0, 0.0, -9.81))
    nodes, edges, number = level_grid(cells + 1)
    net = scene.add_mesh(nodes, edges, element, SECTION, RUBBER, n_elements=n)
    for corner in number[[0, 0, -1, -1], [0, -1, 0, -1]].tolist():
        scene.pin(net.node(corner))
    return scene, net


def test_points_of_an_open_mesh_are_the_same_on_every_mesh():
    scene = ancf.Scene((0.0, -9.81))
    nodes = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0)]
    edges = [(1, 0), (1, 2)]  # one of them is turned round to make a line
    net = scene.add_mesh(nodes, edges, "thin", SECTION, RUBBER, n_elements="auto")
    places = [net.at(edge, s) for edge in (0, 1) for s in (0.0, 0.25, 0.7, 1.0)]
    scene.pin(net.node(0))
    scene.pin(net.node(2))
    scene.point_force(net.at(1, 0.25), (0.0, -0.1))
    for count in (1, 3, 4):
        model = Model({net.name: CABLE}, {net.name: count})
        its = build_model(scene, model)
        assert its.body(net.name).n_elements == 2 * count
        assert its.loads[-1].node.position == pytest.approx([1.25, 0.0], abs=1e-12)
        system = System(its)
        for place in places:  # of the handle, on the mesh that was built
            where, weights = system.point(place)
            assert system.q_ref[where] @ weights == pytest.approx(place.position, abs=1e-12)


@pytest.mark.parametrize(("element", "error"), [("string", "2 %"), ("thin", "0.3 %"),
                                                ("auto", "1 %")])  # fmt: skip
def test_the_equilibrium_of_a_net_is_found_to_its_error(element, error):
    scene, net = hammock(element, "auto")
    middle = net.node(5)
    plan = ancf.plan(scene, quantity=ancf.static_deflection(middle), error=error)
    assert plan.is_met
    assert "on every edge" in plan.choice
    own = "string" if element == "string" else "thin"
    fine, its = hammock(own, 40 if element == "string" else 12)
    exact = ancf.solve_static(fine).position(its.node(5))
    off = plan.run(verify=True).position(middle)[-1] - exact
    # What elements neglect comes on top, and is the same in both.
    assert np.linalg.norm(off) <= plan.predictions[0].tolerance


def test_the_fall_of_a_net_is_found_to_its_error():
    scene, net = hammock("thin", "auto")
    middle = net.node(5)
    run = ancf.simulate(scene, 0.2, quantity=ancf.position(middle), error="2 %")
    plan = run.plan
    fine, its = hammock("thin", 2 * plan.model.counts[net.name])
    exact = ancf.simulate(fine, 0.2, plan.dt / 4, save_every=4, integrator=plan.integrator)
    places = exact.position(its.node(5))[:: plan.save_every]
    assert largest_distance(run.position(middle), places) <= plan.predictions[0].tolerance


def test_coarse_meshes_have_few_elements_across_a_net():
    scene, net = hammock("auto", "auto", cells=10)
    assert coarse_count(scene, 8.0) == 1.0
    assert element_counts(scene, 1.0) == {net.name: 1}
    one, edge = hammock("auto", "auto", cells=1)
    assert element_counts(one, coarse_count(one, 8.0)) == {edge.name: 6}  # across the diagonal
    # Beside a beam, elements of edges are as long as its own.
    rod = scene.add_beam("thin", (0, 0, 1), (4, 0, 1), "auto", SECTION, RUBBER)
    assert coarse_count(scene, 8.0) == 8.0
    assert element_counts(scene, 80.0) == {net.name: 2, rod.name: 80}


def test_open_meshes_are_stated_and_kept(tmp_path):
    scene, net = hammock("auto", "auto")
    assert "auto auto elements" in repr(net)
    with pytest.raises(ancf.InputError, match="n_elements='auto', which a plan chooses"):
        ancf.simulate(scene, 0.1, 1e-3)
    with pytest.raises(ancf.InputError, match="nothing can be refined"):
        scene.refined(2)
    with pytest.raises(ancf.InputError, match="n_elements of mesh 0 must be an integer"):
        ancf.Scene().add_mesh([(0, 0, 0), (1, 0, 0)], [(0, 1)], "thin", SECTION, RUBBER,
                              n_elements="many")  # fmt: skip
    scene.point_force(net.at(4, 0.1), (0.0, 0.0, -1.0))
    scene.save(tmp_path / "net.json")
    again = ancf.Scene.load(tmp_path / "net.json")
    assert again.records == scene.records
    assert again.body(net.name).automatic == net.automatic
    given = scene.replaced(net, element="thin", n_elements=3)
    assert given.loads[-1].node.position == pytest.approx(net.at(4, 0.1).position)
    back = given.replaced(given.body(net.name), element="auto", n_elements="auto")
    assert back.records == scene.records
