"""The last pilot is the answer, and corrects estimates that were too good."""

from dataclasses import replace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.models.model import Model, built
from ancfsparse.plans.quantities.functions import checked
from ancfsparse.plans.quantities.tolerances import wanted
from ancfsparse.plans.selection.confirmation_run import confirmed
from ancfsparse.plans.selection.discretization_search import thorough
from ancfsparse.plans.trial_runs.trial_runs import Pilots, distances, rounded
from ancfsparse.problems import pendulum

T_END = 1.0


def pilots_of(error):
    scene, rod = pendulum("thin", "auto")
    asked = wanted(checked(ancf.position(rod.end), scene), error)
    return Pilots(scene, T_END, asked, ancf.GeneralizedAlpha(0.9))


def test_a_system_that_was_marched_before_gives_the_same_numbers():
    pilots, model = pilots_of(1e-3), Model(counts={"beam 0": 8})
    first = pilots.run(model, 100)
    again = pilots.run(model, 200)
    assert again.run.system is first.run.system
    how = {"integrator": again.integrator, "solver": again.solver}
    fresh = ancf.simulate(built(pilots.scene, model), T_END, T_END / 200, **how)
    for name in ("t", "q", "v", "a", "lam"):
        assert np.array_equal(getattr(again.run, name), getattr(fresh, name))


def test_one_mesh_is_run_once_however_it_was_asked_for():
    """Five places on a beam make ten elements of eight, of ten and of twelve."""
    scene = ancf.Scene()
    rod = scene.add_beam(
        "thin", (0, 0), (1, 0), "auto", ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000)
    )
    scene.clamp(rod.start)
    for share in (0.1, 0.3, 0.5, 0.7, 0.9):
        scene.point_force(rod.at(share), (0.0, -0.01))
    asked = wanted(checked(ancf.position(rod.end), scene), 1e-3)
    pilots = Pilots(scene, 0.1, asked, ancf.GeneralizedAlpha(0.9))
    model = Model()
    one, *others = (pilots.run(model.with_counts({rod.name: n}), 100) for n in (8, 10, 12))
    assert one.run.system.scene.body(rod.name).n_elements == 10
    assert all(other is one for other in others)
    assert pilots.find(model.with_counts({rod.name: 12}), 100) is one
    assert pilots.built(model.with_counts({rod.name: 12})) is one.run.system.scene
    assert pilots.find(model.with_counts({rod.name: 16}), 100) is None
    assert len(pilots.bill) == len(pilots.systems) == 1


def test_the_answer_is_not_marched_again_and_is_the_run_of_the_plan():
    scene, rod = pendulum("thin", "auto")
    plan = ancf.plan(scene, T_END, ancf.position(rod.end), "1 %")
    assert plan.answer is not None
    run = plan.run()
    assert run.q is plan.answer.q
    again = plan.run(save_every=1)
    assert again.q is not run.q
    assert np.array_equal(again.position(rod.end), run.position(rod.end))
    # Longer runs are not made before they are asked for.
    assert ancf.plan(scene, 3.0, ancf.position(rod.end), 5e-5).answer is None


def test_an_estimate_that_is_too_good_is_corrected():
    pilots = pilots_of(2e-4)
    found = thorough(pilots, Model(), None, None)
    exact = pilots.run(Model(counts={"beam 0": 64}), 12800)
    (mesh,) = found.mesh.estimates
    blind = replace(
        found, mesh=replace(found.mesh, estimates=(replace(mesh, error=mesh.error / 50),))
    )
    finest, steps = replace(blind, sure=0.85).choice()
    wrong = pilots.run(Model(counts={"beam 0": int(finest)}), steps)
    assert distances(pilots.wanted, wrong, exact)[0] > 2e-4
    seen = confirmed(pilots, blind)
    assert seen.missed(finest, steps) > 1.0
    finest, steps = seen.choice()
    run = pilots.run(Model(counts={"beam 0": int(finest)}), steps)
    assert distances(pilots.wanted, run, exact)[0] <= 2e-4


@pytest.mark.parametrize("base", [1, 50, 100, 333])
def test_numbers_of_steps_share_times(base):
    for steps in (base, 1.01 * base, 7.3 * base, 129.7 * base):
        found = rounded(steps, base)
        assert steps <= found <= max(1.13 * steps, steps + base)
        assert np.gcd(found, base << 10) >= base // 2
