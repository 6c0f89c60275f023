"""Runs are resumed to the last bit, from copies of their files and after kills."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import n_four_bar
from ancfsparse.problems.meshes import lattice
from ancfsparse.solve.motion.fixed_step_run import FixedStepRun
from tests.soak.checkpoints import kills, trials
from tests.solve.preparation.test_factorization_choice import STEEL
from tests.solve.simulation.scenes import hanging_body


@pytest.mark.parametrize("index", range(12))
def test_random_runs_are_resumed_to_the_last_bit(index):
    assert trials.run(4, index).finds == []


def test_runs_of_more_than_a_thousand_events_are_resumed_with_the_same_events():
    assert trials.run(60001, 123).finds == []


def test_a_run_that_does_not_return_to_its_checkpoints_is_a_find(monkeypatch):
    monkeypatch.setattr(FixedStepRun, "save_checkpoint", lambda run: run.save())
    assert any(trials.run(4, index).finds for index in range(12))


@pytest.mark.slow
@pytest.mark.parametrize("index", range(2))
def test_killed_runs_end_as_if_they_were_not(index):
    report = kills.run(5, index)
    assert report.finds == []


@pytest.mark.parametrize(
    "integrator", [ancf.Newmark(0.0), ancf.EnergyMomentum(), ancf.DormandPrince()], ids=repr
)
def test_mechanisms_are_resumed_before_and_after_singular_configurations(integrator, rng):
    options = {"integrator": integrator, "checkpoint": 37}
    assert trials.attempt(n_four_bar(2).scene, 2.0, 2e-3, options, rng).finds == []


@pytest.mark.parametrize("factorization", ["auto", "incomplete"])
@pytest.mark.parametrize("every", [3, 8])
def test_runs_are_resumed_before_and_after_a_switch_to_complete_factors(factorization, every, rng):
    """The switch of "auto" is after step 5."""
    options = {"factorization": factorization, "checkpoint": every}
    report = trials.attempt(lattice(5, **STEEL).scene, 1.25, 0.05, options, rng)
    assert report.finds == []


@pytest.mark.parametrize("start", ["last", "equilibrium"])
def test_runs_from_other_states_are_resumed(start, rng):
    scene = hanging_body()
    if start == "last":
        start = ancf.simulate(scene, 0.05, 1e-3).last
        assert np.any(start.v)
    options = {"start": start, "checkpoint": 9}
    assert trials.attempt(scene, 0.1, 1e-3, options, rng).finds == []
