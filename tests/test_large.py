"""The example of docs/large.md runs as it stands; set-up is linear and lean."""

import re
import time
import tracemalloc
from pathlib import Path

import numpy as np

import ancfsparse as ancf
from ancfsparse.solve.memory import estimate
from ancfsparse.system import System

PAGE = Path(__file__).parents[1] / "docs" / "large.md"


def chain(n):
    scene = ancf.Scene()
    stuff = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    rod = scene.add_beam("l2t2", (0, 0), (0.2 * n, 0), n, *stuff)
    scene.pin(rod.start)
    return scene, rod


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
    begin = time.process_time()
    tracemalloc.start()
    scene, _ = chain(n)
    system = System(scene)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert system.n_free == 4 * (n + 1) - 2
    assert peak < 800 * n  # bytes
    assert time.process_time() - begin < 5.0


def test_the_estimate_of_memory_is_near_the_truth():
    scene, rod = chain(20_000)
    told = estimate(scene, 3, 1, False, "auto").total
    tracemalloc.start()
    ancf.simulate(scene, 2e-3, 1e-3, save_nodes=[rod.end])
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert 0.5 * peak < told < 2.0 * peak
