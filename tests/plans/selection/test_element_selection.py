"""Which element a plan takes: no more than the quantity needs, and no less."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import ancfsparse as ancf
from ancfsparse.kernels.catalog import HIERARCHY, ElementChoice
from ancfsparse.plans.model_error.effects import Effects, largest_negligible_set
from ancfsparse.plans.selection.element_hierarchy import CABLE, SHEARED, STRING, candidates
from ancfsparse.plans.selection.element_selection import cheapest_sufficient
from tests.beams import build_beam
from tests.grids import level_grid
from tests.plans.comparison import build_trials

RUBBER = ancf.Material(1e7, 1000, 0.3)
TWISTED = HIERARCHY[2]


def cantilever(section, length, force, dim=2):
    ends = np.zeros(dim), length * np.eye(dim)[0]
    scene, rod = build_beam("auto", *ends, "auto", section, RUBBER, "clamp", gravity=(0.0,) * dim)
    scene.point_force(rod.end, force)
    return scene, rod


def rung_of(plan):
    (element,) = plan.model.elements.values()
    return element


def test_a_slender_pendulum_is_a_cable():
    bar, soft = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000)
    scene, rod = build_beam("auto", (0, 0), (2, 0), "auto", bar, soft, "pin")
    plan = ancf.plan(scene, 1.0, ancf.position(rod.end), 1e-2)
    assert rung_of(plan) == CABLE
    assert plan.is_met
    assert plan.predictions[0].sources["shear"] > 0.0
    assert "is sufficient for the" in str(plan)


@pytest.mark.parametrize(("error", "element"), [("30 %", CABLE), ("1 %", SHEARED)])
def test_a_short_beam_is_sheared_where_that_matters(error, element):
    scene, rod = cantilever(ancf.Rectangle(0.1, 0.1), 0.3, (0.0, -20.0))
    plan = ancf.plan(scene, quantity=ancf.static_deflection(rod.end), error=error)
    assert rung_of(plan) == element
    # Timoshenko: F L^3 / 3 E I + F L / k G A; of the second a cable has nothing.
    bending = 20.0 * 0.3**3 / (3 * 1e7 * 0.1**4 / 12)
    shear = 20.0 * 0.3 / rod.stiffnesses()["shear_stiffness_y"]
    error_model = -plan.run().position(rod.end)[-1, 1]
    exact = bending + shear if element == SHEARED else bending
    assert error_model == pytest.approx(exact, rel=0.02)
    assert shear / bending == pytest.approx(0.765 * (0.1 / 0.3) ** 2, rel=1e-2)


def test_a_twisted_beam_is_no_cable():
    scene, rod = cantilever(ancf.Circle(0.05), 0.5, (0.0, -5.0, 2.0), dim=3)
    scene.point_moment(rod.end, (0.5, 0.0, 0.0))
    plan = ancf.plan(scene, 0.1, ancf.position(rod.end), "3 %")
    assert rung_of(plan).name == "thick"
    assert "cannot be twisted" in str(plan)


def test_a_scene_in_a_plane_is_solved_there():
    scene, rod = cantilever(ancf.Rectangle(0.05, 0.02), 1.0, (0.0, -1.0, 0.0), dim=3)
    flat, its = cantilever(ancf.Rectangle(0.05, 0.02), 1.0, (0.0, -1.0))
    plan = ancf.plan(scene, 0.1, ancf.position(rod.end), "3 %")
    reduce_to_plane = ancf.plan(flat, 0.1, ancf.position(its.end), "3 %")
    assert "moves in a plane" in str(plan)
    assert plan.build().dim == 2
    run, other = plan.run(), reduce_to_plane.run()
    assert run.position(rod.end).shape[1] == 3
    assert np.allclose(run.position(rod.end)[:, :2], other.position(its.end), atol=1e-12)
    assert not run.velocity(rod.end)[:, 2].any()
    assert np.allclose(ancf.slope_angle(rod.end).value(run)[0], 0.0)


def test_effects_decide_between_elements():
    effects = Effects([{"shear": 1.0, "torsion": 0.1, "stretch": 50.0}])
    twist = Effects([{"shear": 0.0, "torsion": 1.0}])
    elements = [CABLE, TWISTED, SHEARED]
    assert cheapest_sufficient(elements, effects, [10.0]) == CABLE
    assert cheapest_sufficient(elements, effects, [2.0]) == SHEARED
    assert cheapest_sufficient(elements, twist, [1.0]) == TWISTED
    assert cheapest_sufficient([CABLE], effects, [0.1]) == CABLE


def test_effects_are_summed_and_compared_with_tolerances():
    effects = Effects([{"shear": 1.0, "bending": 2.0, "stretch": 3.0}, {"shear": 0.5}])
    assert effects.only(CABLE.neglects) == ({"shear": 1.0}, {"shear": 0.5})
    assert effects.only(STRING.neglects) == ({"shear": 1.0, "bending": 2.0}, {"shear": 0.5})
    assert effects.floors == (3.0, 0.0)
    assert effects.excess([12.0, 2.0]) == 0.5
    assert effects.is_negligible([13.0, 2.0])
    assert not effects.is_negligible([12.0, 2.0])
    both = effects + Effects([{"shear": 1.0}, {"torsion": 1.0}])
    assert both[0]["shear"] == 2.0
    assert both[1] == {"shear": 0.5, "torsion": 1.0}


def test_the_beams_with_the_smallest_effects_are_negligible_together():
    effects = {name: Effects([{"bending": x}]) for name, x in (("a", 3.0), ("b", 1.0), ("c", 2.0))}
    names, total = largest_negligible_set(effects, [7.0])
    assert names == ["b", "c"]
    assert total == ({"bending": 3.0},)
    assert largest_negligible_set(effects, [1.0]) == ([], ({},))
    assert largest_negligible_set(effects, [13.0])[0] == ["b", "c", "a"]


def test_what_the_scene_rejects_is_no_candidate():
    scene, rod = cantilever(ancf.Rectangle(0.05, 0.02), 1.0, (0.0, 0.0, 1.0), dim=3)
    trials = build_trials(scene, None, ancf.static_deflection(rod.end), "1 %")
    taken, refused = candidates(trials)
    assert taken == [TWISTED, SHEARED]
    assert "clamp" in refused[str(STRING)]
    assert "bending stiffness is the same" in refused[str(CABLE)]
    assert str(ElementChoice("thick", {"curvature": "section"})) == "\"thick\" curvature='section'"


def net(pull, radius, element="auto", n=2):
    """Four by four meshes of cables, whose rim is pulled apart and which sag by their weight."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    nodes, edges, number = level_grid(5)
    made = ancf.Circle(radius), ancf.Material(1e8, 1000)
    mesh = scene.add_mesh(nodes, edges, element, *made, n_elements=n)
    for k in np.unique([*number[[0, -1]].ravel(), *number[:, [0, -1]].ravel()]).tolist():
        scene.drive(mesh.node(k), nodes[k] + pull * (nodes[k] - 0.5) * (1.0, 1.0, 0.0))
    return scene, mesh, mesh.node(12)


@pytest.mark.parametrize(
    ("pull", "radius", "element"), [(0.02, 0.002, STRING), (0.002, 0.02, CABLE)]
)
@pytest.mark.filterwarnings("ignore::ancfsparse.ErrorNotMetWarning")
def test_a_net_under_tension_gets_strings_where_bending_does_not_matter(pull, radius, element):
    scene, mesh, middle = net(pull, radius)
    plan = ancf.plan(scene, quantity=ancf.static_deflection(middle), error="3 %")
    assert plan.model.elements == {mesh.name: element}
    trials = build_trials(scene, None, ancf.static_deflection(middle), "3 %")
    assert "is a mesh, which takes strings or cables" in candidates(trials)[1][str(SHEARED)]
    fine, _, its = net(pull, radius, "thin", 8)
    exact = ancf.solve_static(fine).displacement(its)
    error_model = plan.run().position(middle)[-1] - middle.position
    assert np.linalg.norm(error_model - exact) <= plan.predictions[0].tolerance
    with pytest.raises(ancf.InputError, match="element='auto', which a plan chooses"):
        ancf.solve_static(scene)
    with pytest.raises(ancf.InputError, match="slack of mesh 1 applies to strings only"):
        scene.add_mesh(
            [(0, 0, 2), (1, 0, 2)], [(0, 1)], "auto", ancf.Circle(0.01), RUBBER, slack=0.01
        )


def test_strings_are_tried_for_a_single_line_too():
    made = ancf.Circle(0.002), ancf.Material(1e9, 1000)
    scene, line = build_beam("auto", (0, 0), (1, 0), "auto", *made, "pin", "pin", tension=20.0)
    plan = ancf.plan(scene, 0.3, ancf.position(line.at(0.5)), "0.3 %")
    assert rung_of(plan) == STRING or "strings would suffice too" in str(plan)
    # Where a short run of cables is the answer, their pilots would take longer than they save.
    plan = ancf.plan(scene, 0.3, ancf.position(line.at(0.5)), "25 %")
    assert plan.result is not None
    assert rung_of(plan) == CABLE
    assert "strings" not in str(plan)


def test_below_what_models_agree_on_a_cable_is_as_good_as_any():
    """A soft pendulum: Green's and Biot's strain differ by more than the shear of thick beams."""

    def pendulum(element, n, **options):
        made = ancf.Rectangle(0.01, 0.01), ancf.Material(1e7, 4000)
        scene, rod = build_beam(element, (0, 0), (1, 0), n, *made, "pin", **options)
        return scene, rod.end

    def tip(n, element="thin", **options):
        scene, end = pendulum(element, n, **options)
        return ancf.simulate(scene, 1.0, dt=2.5e-4, save_every=40).position(end)

    def apart(one, other):
        return np.linalg.norm(one - other, axis=1).max()

    scene, end = pendulum("auto", "auto")
    plan = ancf.plan(scene, 1.0, ancf.position(end), 3e-4)
    (predicted,) = plan.predictions
    sheared = {"curvature": "section", "section_strain": "nodal"}
    coarse, fine = (tip(n, "thick", **sheared) for n in (128, 256))
    models = tip(48), tip(48, strain="biot"), fine + (fine - coarse) / 3.0
    most = max(apart(a, b) for a in models for b in models)
    assert most / 2.0 <= predicted.floor <= 2.0 * most
    assert predicted.sources["shear"] > 0.5 * predicted.tolerance
    assert rung_of(plan) == CABLE
    assert not plan.is_met
    assert "no model guarantees 3.0e-04 m" in str(plan)
    assert "and converged elements differ by" in str(plan)
    with pytest.warns(ancf.ErrorNotMetWarning, match="the difference between converged elements"):
        run = plan.run()
    error_model = CubicSpline(run.t, run.position(end))(np.linspace(0.0, 1.0, len(fine)))
    assert apart(error_model, models[0]) <= predicted.tolerance
    assert apart(error_model, models[2]) <= predicted.error + predicted.tolerance
