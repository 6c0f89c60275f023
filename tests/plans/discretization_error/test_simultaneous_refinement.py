"""Pilots of mesh and steps together, also where none without numerical damping finishes."""

import numpy as np

import ancfsparse as ancf
from ancfsparse.plans.discretization_error import simultaneous_refinement as module
from ancfsparse.plans.discretization_error.simultaneous_refinement import ladder
from ancfsparse.plans.discretization_error.time_error import time_error
from ancfsparse.plans.models.model import FEWEST_ELEMENTS, Model
from ancfsparse.plans.quantities.functions import checked
from ancfsparse.plans.quantities.tolerances import wanted
from ancfsparse.plans.selection.discretization_search import search
from ancfsparse.plans.trial_runs.trial_runs import FEWEST, Pilots

DAMPED = ancf.GeneralizedAlpha(0.9)


def pilots_of(scene, t_end, quantity, error):
    return Pilots(scene, t_end, wanted(checked(quantity, scene), error), DAMPED)


def long_pendulum(n="auto"):
    """A pendulum of 2 m whose steps gain energy without damping, and with it if they are long."""
    scene = ancf.Scene()
    rod = scene.add_beam(
        "thin", (0, 0), (2, 0), n, ancf.Rectangle(0.01, 0.01), ancf.Material(2e9, 1000)
    )
    scene.pin(rod.start)
    return scene, rod.end


def test_pilots_begin_with_damping_where_those_without_fail():
    scene, end = long_pendulum()
    pilots = pilots_of(scene, 10.0, ancf.position(end), "3 %")
    found = ladder(pilots, Model(), 4, 2)
    assert found is not None
    assert all(run.integrator == DAMPED for run in found.runs)
    assert found.runs[0].model.counts == {"beam 0": FEWEST_ELEMENTS}
    last = found.runs[-1]
    fine, its = long_pendulum(12)
    exact = ancf.simulate(fine, 10.0, 10.0 / (8 * last.steps), save_every=8)
    mine = pilots.wanted[0].quantity.on(last.run.system.scene).history(last.run)
    off = np.linalg.norm(mine - exact.position(its), axis=1).max()
    assert 0.05 * found.pair[0] <= off <= found.pair[0]
    # Steps with which a run has failed are not tried on other meshes.
    failed = pilots.failed
    time_error(pilots, Model(counts={"beam 0": 8}), 2)
    tried = [key[-1] for key in pilots.done if ("beam 0", 8) in key]
    assert min(tried) > failed >= FEWEST


def test_motions_without_numerical_damping_must_agree_with_pilots_that_have_it(monkeypatch):
    scene, end = long_pendulum()
    monkeypatch.setattr(module, "undamped_is_alike", lambda *_: False)
    assert ladder(pilots_of(scene, 10.0, ancf.position(end), "3 %"), Model(), 4, 2) is None


def test_responses_are_measured_with_the_cheaper_of_two_like_pilots():
    scene = ancf.Scene()
    rod = scene.add_beam(
        "thin", (0, 0), (0, -1), "auto", ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000)
    )
    scene.drive(rod.start, lambda t: (0.1 * (1.0 - np.cos(6.0 * t)), 0.0))
    like = []
    for error in ("3 %", "0.3 %"):
        found = search(pilots_of(scene, 3.0, ancf.position(rod.end), error), Model(), None, None)
        assert found.pair is not None
        one, other = found.time.runs
        like.append(one.integrator == other.integrator)
        assert found.rough is (one if like[-1] else other)
        assert not like[-1] or one.cost.amount < other.cost.amount
    assert like == [False, True]
