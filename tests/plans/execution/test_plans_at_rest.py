"""Plans for equilibria and frequencies, and for motions from rest, beside exact numbers."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import cantilever, elastica
from tests.beams import build_beam
from tests.plans.comparison import largest_distance


@pytest.mark.parametrize("error", ["3 %", "0.1 %"])
def test_the_elastica_is_found_to_its_error(error):
    problem = elastica(3.0, "thin", "auto")
    plan = ancf.plan(problem.scene, quantity=ancf.static_deflection(problem.rod.end), error=error)
    run = plan.run(verify=True)
    fine = elastica(3.0, "thin", 64)
    exact = ancf.solve_static(fine.scene).displacement(fine.rod.end)
    off = np.linalg.norm(run.position(problem.rod.end)[0] - problem.rod.end.position - exact)
    assert off <= plan.predictions[0].tolerance
    assert plan.is_met
    assert run.measured[0] <= plan.predictions[0].tolerance
    assert plan.dt is None
    assert "statics" in str(plan)


def test_frequencies_of_a_cantilever_are_eulers():
    problem = cantilever("thin", "auto", load=0.0)
    rod = problem.rod
    plan = ancf.plan(problem.scene, quantity=[ancf.frequency(1), ancf.frequency(2)], error="0.1 %")
    error_model = [each.goal.quantity.value(plan.run())[0, 0] for each in plan.predictions]
    given = rod.stiffnesses()
    speed = np.sqrt(given["bending_stiffness"] / given["mass_per_length"]) / rod.length**2
    euler = np.array([1.8751040687, 4.6940911330]) ** 2 * speed / (2 * np.pi)
    assert error_model == pytest.approx(euler, rel=2e-3)
    assert max(each.error / each.tolerance for each in plan.predictions) < 1.0


@pytest.mark.parametrize("t_end", [1.0, 100.0])
def test_a_hanging_cable_is_moved_from_its_equilibrium(t_end):
    section, material = ancf.Circle(0.01), ancf.Material(2e9, 1500.0)
    ramp = ancf.Ramp((0.1, 0.0, 0.3), 0.5 * t_end, smooth=True) + np.array([1.0, 0.0, 0.0])

    def hung(n):
        scene, line = build_beam(
            "thin", (0, 0, 0), (1, 0, 0), n, section, material, "pin",
            gravity=(0.0, 0.0, -9.81), length=1.3,
        )  # fmt: skip
        scene.drive(line.end, ramp)
        return scene, line

    scene, line = hung("auto")
    middle = line.at(0.5)
    given = {"quantity": ancf.position(middle), "error": "2 %", "start": "equilibrium"}
    run = ancf.simulate(scene, t_end, **given)
    assert run.plan.is_met
    # The first state is at rest: without the start it falls.
    assert np.abs(run.v[0]).max() == 0.0
    # A finer mesh and shorter steps, from an equilibrium that was found for it.
    finer, its = hung(24)
    fine = ancf.simulate(finer, t_end, t_end / 2000, start=ancf.solve_static(finer), save_every=20)
    mine = run.position(middle)[:: (len(run.t) - 1) // 100]
    off = largest_distance(mine, fine.position(its.at(0.5)))
    assert off <= run.plan.predictions[0].tolerance


def test_bad_input_gets_a_sentence():
    scene, rod = cantilever("thin", "auto")
    rest, motion = ancf.static_deflection(rod.end), ancf.position(rod.end)
    moving, thrown = cantilever("thin", 4)
    moving = moving.replaced(thrown, velocity=lambda x: x**2 @ [[0, 1], [0, 0]])
    for make, words in (
        (lambda: ancf.plan(scene, 1.0, rest, 1e-3), "omit t_end"),
        (lambda: ancf.plan(scene, quantity=rest, error=1e-3, dt=1.0), "omit dt"),
        (lambda: ancf.plan(scene, quantity=motion, error=1e-3), "needs a time at the end"),
        (lambda: ancf.plan(scene, 1.0, [rest, motion], 1e-3), "a plan for each kind"),
        (lambda: ancf.plan(scene, quantity=rest, error=1, start="equilibrium"), "omit start"),
        (lambda: ancf.plan(scene, 1.0, motion, 1e-3, start="rest"), "start of a plan 'rest'"),
        (lambda: ancf.simulate(moving, 1.0, 0.1, start="equilibrium"), "begins at rest, but"),
        (lambda: ancf.simulate(moving, 1.0, 0.1, start="rest"), "unknown start 'rest'"),
        (lambda: ancf.plan(scene), "quantity is empty"),
        (lambda: ancf.plan(scene, quantity=rest), "needs an error"),
        (lambda: ancf.frequency(0), "at least 1"),
        (lambda: ancf.static_deflection("tip"), "needs a point"),
        (lambda: ancf.simulate(scene, 1.0, quantity=rest, error=1e-3), "omit t_end"),
    ):
        with pytest.raises(ancf.InputError, match=words):
            make()
