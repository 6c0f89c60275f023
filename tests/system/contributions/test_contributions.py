"""A contribution of a stranger's: one file, one name, and what it keeps from step to step."""

import sys
from types import ModuleType

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.results.hdf5_reader import load
from ancfsparse.system import System, contributions
from ancfsparse.system.contributions import selection
from ancfsparse.system.contributions.interface import Contribution
from tests.system.contributions.winch import Winch


class Stranger(Contribution):
    def __init__(self, place):
        self.winch = Winch(place)

    def compile(self, pattern):
        return self.winch


@pytest.fixture
def winches(monkeypatch):
    """Let every system have a winch at the end of its first beam."""
    made = []

    def of(system):
        made.append(Stranger(int(system.places[0][-1, 0])))
        return made[-1:]

    module = ModuleType("stranger")
    module.of = of
    monkeypatch.setitem(sys.modules, f"{contributions.__name__}.stranger", module)
    monkeypatch.setitem(selection.CONDITIONS, "stranger", lambda system: True)
    return made


def bar():
    """A bar of 8 kg that floats in space."""
    scene = ancf.Scene(gravity=(0.0, 0.0))
    beam = scene.add_beam(
        "l2t2", (0, 0), (2, 0), 2, ancf.Rectangle(0.1, 0.1), ancf.Material(1e7, 400)
    )
    return scene, beam


@pytest.mark.parametrize(
    ("integrator", "solver"),
    [
        (ancf.GeneralizedAlpha(0.9), "auto"),
        (ancf.Newmark(0.0), ancf.Newton()),
        (ancf.EnergyMomentum(), "auto"),
        (ancf.CentralDifference(), "auto"),
    ],
)
def test_memory_changes_on_accepted_steps_alone(winches, integrator, solver):
    scene, beam = bar()
    run = ancf.simulate(
        scene, 0.02, 1e-4, integrator=integrator, solver=solver, max_energy_gain=np.inf
    )
    winch = winches[-1].winch
    assert run.system.assembly.memory == [200.0]
    assert winch.calls >= 200
    np.testing.assert_array_equal(winch.seen, run.position(beam.end)[:, 0])
    # The momentum is the sum of the forces, each of which acts from one step to the next.
    momentum = float(run.system.assembly.inertia(run.v[-1])[run.system.places[0][:, 0]].sum())
    assert momentum == pytest.approx(1e-4 * 200 * 199 / 2, rel=2e-2)


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.CentralDifference()])
def test_a_run_in_two_parts_goes_on_with_the_memory_of_the_first(winches, integrator, tmp_path):
    scene, _ = bar()
    options = {"integrator": integrator, "max_energy_gain": np.inf}
    whole = ancf.simulate(scene, 0.02, 1e-4, **options)
    first = ancf.simulate(scene, 0.01, 1e-4, **options, output=tmp_path / "first.h5")
    for start in (first.last, load(tmp_path / "first.h5", scene).last):
        second = ancf.simulate(scene, 0.02, 1e-4, start=start, **options)
        assert second.system.assembly.memory == [200.0]
        np.testing.assert_allclose(second.q[-1], whole.q[-1], rtol=0, atol=1e-13)


def test_memory_can_be_restored(winches):
    assembly = System(bar()[0]).assembly
    assembly.memory = np.array([7.0])
    assert assembly.memory == [7.0]
    with pytest.raises(ValueError, match="memory has 1 numbers, got 2"):
        assembly.memory = np.zeros(2)


def test_without_memory_nothing_is_kept():
    assert System(bar()[0]).assembly.memory.shape == (0,)
