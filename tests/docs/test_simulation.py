"""The examples of docs/simulation.md run unchanged, and reach the values that they set."""

import re
from importlib.util import find_spec

import pytest

from tests.paths import ROOT

PAGE = (ROOT / "docs/simulation.md").read_text(encoding="utf-8")
EXTRAS = {"ancf.gym": "gymnasium", "ancf.fmu": "pythonfmu3"}
BLOCKS = [
    block
    for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    if all(name not in block or find_spec(package) for name, package in EXTRAS.items())
]


def test_examples_run(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in BLOCKS:
        exec(compile(block, "docs/simulation.md", "exec"), names)
    sim, load = names["sim"], names["load"]
    assert sim.position(load.origin)[2] == pytest.approx(-1.5, abs=0.02)
    assert sim.tension(names["winch"]) == pytest.approx(5.0 * 9.81, rel=1e-3)
    up, still, down = (names["heights"][rate] for rate in (-0.1, 0.0, 0.1))
    assert (up - still, down - still) == pytest.approx((0.05, -0.05), abs=1e-6)
