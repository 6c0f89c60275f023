"""Trial runs of mesh and steps together, also where none without numerical damping finishes."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.discretization_error import refinement as module
from ancfsparse.plans.discretization_error.refinement import refine_together
from ancfsparse.plans.discretization_error.run_estimates import elements_of
from ancfsparse.plans.discretization_error.run_series import RunSeries
from ancfsparse.plans.models.model import MIN_LONGEST_COUNT, Model
from ancfsparse.plans.selection.discretization_search import search
from ancfsparse.plans.trial_runs.trial_runs import MIN_STEPS
from tests.beams import build_beam
from tests.plans.comparison import DAMPED, build_trials, largest_distance


def long_pendulum(n="auto"):
    """A pendulum of 2 m whose steps gain energy without damping, and with it if they are long."""
    scene, rod = build_beam(
        "thin", (0, 0), (2, 0), n, ancf.Rectangle(0.01, 0.01), ancf.Material(2e9, 1000), "pin"
    )
    return scene, rod.end


def test_trial_runs_begin_with_damping_where_those_without_fail():
    scene, end = long_pendulum()
    trials = build_trials(scene, 10.0, ancf.position(end), "3 %")
    error_model = refine_together(trials, Model(), 4)
    done = [run for run in trials.done.values() if run is not None]
    assert all(run.integrator == DAMPED for run in done)
    assert done[0].model.counts == {"beam 0": MIN_LONGEST_COUNT}
    last = error_model.time.runs[-1]
    fine, its = long_pendulum(12)
    exact = ancf.simulate(fine, 10.0, 10.0 / (8 * last.steps), save_every=8)
    mine = trials.goals[0].quantity.in_scene(last.run.system.scene).history(last.run)
    off = largest_distance(mine, exact.position(its))
    assert 0.05 * error_model.combined_errors[0] <= off <= error_model.combined_errors[0]
    # Steps with which a run has failed are not tried again.
    failed, n_done = trials.failed, len(trials.done)
    refine_together(trials, Model(), 4)
    assert min(key[-1] for key in list(trials.done)[n_done:]) > failed >= MIN_STEPS


def test_motions_without_numerical_damping_must_agree_with_trial_runs_that_have_it(monkeypatch):
    """Where they do not, as for vibrations that long steps remove, the steps are shortened."""
    scene, end = long_pendulum()
    steps = {}
    for least in (1, 3):
        agrees = iter([False] * (least - 1) + [True] * 8).__next__
        monkeypatch.setattr(module, "agrees_with_undamped", lambda *_, agrees=agrees: agrees())
        trials = build_trials(scene, 10.0, ancf.position(end), "3 %")
        steps[least] = refine_together(trials, Model(), 4).time.runs[-1].steps
    assert steps[3] == 4 * steps[1]


def test_responses_are_measured_with_the_cheapest_of_the_last_trial_runs():
    scene, rod = build_beam(
        "thin", (0, 0), (0, -1), "auto", ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000)
    )
    scene.drive(rod.start, lambda t: (0.1 * (1.0 - np.cos(6.0 * t)), 0.0))
    numbers = []
    for error in ("3 %", "0.3 %"):
        trials = build_trials(scene, 3.0, ancf.position(rod.end), error)
        error_model = search(trials, Model(), None, None)
        assert error_model.combined_errors is not None
        runs = error_model.time.runs
        numbers.append(len(runs))
        assert error_model.coarse_run is runs[0]
        assert all(one.cost.work < other.cost.work for one, other in pairwise(runs))
    assert numbers == [2, 3]


def test_every_mesh_is_finer_than_the_one_before():
    """Five places on a beam turn six, seven and eight requested elements into ten."""
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), "auto", ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000),
        "clamp",
    )  # fmt: skip
    for place in (0.1, 0.3, 0.5, 0.7, 0.9):
        scene.point_force(rod.at(place), (0.0, -0.01))
    trials = build_trials(scene, 0.1, ancf.position(rod.end), 1e-3)
    meshes, n_longest = [trials.with_mesh(Model(), 6.0)], 6.0
    for _ in range(6):
        mesh, n_longest = module._refine_mesh(trials, meshes[-1], n_longest, 1.1)
        meshes.append(mesh)
    counts = [trials.build(mesh).body(rod.name).n_elements for mesh in meshes]
    assert (np.diff(counts) > 0).all()


@pytest.mark.parametrize("counts", [(4, 7, 10), (4, 6, 8), (4, 6, 9)])
@pytest.mark.parametrize("order", [1.8, 2.5])
def test_errors_of_meshes_that_grow_unevenly_are_continued_exactly(counts, order):
    """Histories have an error by a power of the number of elements, and none of the steps."""
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), "auto", ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000),
        "clamp",
    )  # fmt: skip
    trials = build_trials(scene, 0.1, ancf.position(rod.end), 1e-3)
    runs, errors = [], []
    for i, count in enumerate(counts):
        run = trials.run(Model({}, {"beam 0": count}), 100 * 2**i)
        errors.append(0.1 * elements_of(run) ** -order)
        runs.append(replace(run, histories=(np.full((11, 2), [1.0 + errors[-1], 0.0]),)))
    trials.run = lambda *_: runs[-1]  # with any steps
    found = RunSeries(trials, runs, 4)._estimate(0, 4)
    assert found.error == pytest.approx(errors[-1], rel=1e-6)


def test_steps_that_are_short_enough_are_kept():
    """A force of 1 kHz moves resonances with the mesh; steps that resolve it change nothing."""
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), "auto", ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000),
        "clamp", gravity=(0.0, 0.0),
    )  # fmt: skip
    scene.point_force(rod.end, ancf.Sine((0.0, 3.0), 999.0))
    trials = build_trials(scene, 0.1, ancf.position(rod.end), "10 %", base=800)
    last = refine_together(trials, Model(), 4).time.runs[-1]
    steps = sorted({key[-1] for key in trials.done})
    meshes = {run.model.counts["beam 0"] for run in trials.done.values() if run.steps == steps[-1]}
    assert last.steps == steps[-1]
    assert len(meshes) > 2
