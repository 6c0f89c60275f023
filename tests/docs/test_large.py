"""The example of docs/large.md runs as it stands; set-up is linear and lean."""

import re
import tracemalloc

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import chain
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.motion import fixed_step_run
from ancfsparse.solve.preparation.memory_estimate import estimate_memory
from ancfsparse.system import System
from tests.operations import operations
from tests.paths import ROOT

PAGE = ROOT / "docs" / "large.md"


def test_the_example_of_the_page(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    source = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]
    names = {}
    exec(compile(source, "docs/large.md", "exec"), names)
    assert "441 nodes, 840 thin elements, 42 line(s)" in capsys.readouterr().out
    run, middle = names["run"], names["middle"]
    # The middle does not know yet that the corners are held: it falls freely.
    np.testing.assert_allclose(run.t, np.arange(11) * 0.01, atol=1e-15)
    np.testing.assert_allclose(run.position(middle)[:, 2], -9.81 / 2 * run.t**2, atol=1e-4)
    assert (tmp_path / "net.h5").stat().st_size < 300_000  # whole states would take 680 kB


def test_setting_up_a_large_chain_is_quick_and_small():
    n = 100_000
    _, few, many = (operations(lambda n=n: System(chain(n)[0])) for n in (10, 1000, 10_000))
    assert many < 1.1 * few  # no loop over elements
    tracemalloc.start()
    scene, _ = chain(n)
    system = System(scene)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert system.n_free == 4 * (n + 1) - 2
    assert peak < 800 * n  # bytes


def traced_peak(n, **options):
    """Most bytes in arrays while a chain of n elements moves, and what was told beforehand."""
    scene, rod = chain(n)
    matrices = 2 if isinstance(options.get("integrator"), ancf.EnergyMomentum) else 1
    told = estimate_memory(
        scene, 3, 1, False, options.get("solver", "auto"), matrices=matrices
    ).total
    tracemalloc.start()
    ancf.simulate(scene, 2e-3, 1e-3, save_nodes=[rod.end], save_every=2, **options)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return peak, told


@pytest.mark.parametrize(
    "options",
    [
        {"solver": "auto"},
        {"solver": ancf.QuasiNewton("broyden", memory=10)},
        {"integrator": ancf.EnergyMomentum()},
    ],
)
def test_the_estimate_of_memory_is_near_the_truth(options):
    peak, told = traced_peak(50_000, **options)
    assert 0.7 * peak < told < 1.4 * peak


def test_an_element_of_a_chain_takes_less_than_1570_bytes():
    # Counted in the sizes of arrays.  A fifth of that is never touched, or not with a million
    # elements, whose states are passed on one by one: they take 1.45 GB.
    (small, _), (large, _) = traced_peak(20_000), traced_peak(50_000)
    assert (large - small) / 30_000 < 1570.0


def test_the_end_of_a_run_copies_the_state_alone(monkeypatch):
    n, last = 20_000, fixed_step_run.save_state

    def measured(system, *args):
        before, _ = tracemalloc.get_traced_memory()
        tracemalloc.reset_peak()
        state = last(system, *args)
        taken = tracemalloc.get_traced_memory()[1] - before
        assert taken < 1.1 * 3 * 8 * system.n_all  # q, v, a; not what else the next steps need
        return state

    monkeypatch.setattr(fixed_step_run, "save_state", measured)
    tracemalloc.start()
    run = ancf.simulate(chain(n)[0], 2e-3, 1e-3, integrator=ancf.HHT(0.05))
    tracemalloc.stop()
    assert run.last.b is not None


@pytest.mark.parametrize("threads", [1, 2])
def test_parts_that_stay_take_so_many_bytes_per_element(threads):
    n = 50_000
    system = System(chain(n)[0])
    seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free, threads)
    elements = sum(layout.nbytes for layout in system.contributions[0].layouts)
    assert elements < 16 * n / 2  # two numbers and a set of parameters for each block
    # 26 entries, 4 pivots, work space, two permutations, rows and supernodes, and 40 for the node.
    assert seed.own.nbytes < n * (8 * 26 + 8 * 4 + 4 * 4 * 4 + 40)
