"""The example of docs/robots.md runs; the hand goes where the angles of its drives put it."""

import re

import numpy as np
import pytest

from tests.paths import ROOT

pytest.importorskip("yourdfpy")
PAGE = (ROOT / "docs/robots.md").read_text(encoding="utf-8")


def test_the_arm_carries_its_hose(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (file,) = re.findall(r"```xml\n(.*?)```", PAGE, re.DOTALL)
    (example,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "arm.urdf").write_text(file, encoding="utf-8")
    names = {}
    exec(compile(example, "docs/robots.md", "exec"), names)
    run, rest, scene = names["run"], names["rest"], names["scene"]

    one = -0.8 + 0.5
    two = one + 1.2 - 0.6
    expected = [
        0.6 * np.cos(one) + 0.5 * np.cos(two) - 0.05 * np.sin(two),
        0.0,
        1.0 - 0.6 * np.sin(one) - 0.5 * np.sin(two) - 0.05 * np.cos(two),
    ]
    np.testing.assert_allclose(run.position(names["hand"])[-1], expected, atol=1e-8)

    # At rest the supports of the hose bear its weight, and each part hangs in one plane.
    weight = sum(each.length for each in scene.beams) * 9.81 * 1100 * np.pi * (0.01**2 - 0.007**2)
    held = sum(
        rest.joint_force(each).force for each in scene.joints if each.nodes[0].beam in scene.beams
    )
    np.testing.assert_allclose(np.abs(held), (0, 0, weight), atol=1e-6)
