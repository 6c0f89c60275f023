"""The command ``ancfsparse compare``."""

import re

import numpy as np
import pytest

import ancfsparse as ancf
from tests.cli.command import run

SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(1e8, 1000.0)


def saved(path, acceleration=-9.81, step=1e-3, **more):
    """Save the run of a bar and a rigid body that fall freely, and return its file."""
    scene = ancf.Scene((0.0, acceleration))
    scene.add_beam("thin", (0, 0), (1, 0), 4, SECTION, MATERIAL, name="bar")
    scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(0, 1), name="ball")
    if more:
        scene.add_beam("thin", (0, 2), (1, 2), 2, SECTION, MATERIAL, **more)
    nodes, edges = [(0, 3), (1, 3), (1, 4)], [(0, 1), (1, 2)]
    scene.add_mesh(nodes, edges, "thin", SECTION, MATERIAL, name="net")
    ancf.simulate(scene, 0.1, step, output=path)
    return path


def test_equal_runs_are_equal(tmp_path, capsys):
    one, other = (saved(tmp_path / name) for name in ("a.h5", "b.h5"))
    code, out, _ = run(capsys, "compare", one, other)
    assert code == 0
    assert "scene: equal\nsettings: equal\n" in out
    assert out.count("largest distance 0 m") == 3
    assert out.count("axial forces from") == 1  # of the beam


def test_distances_are_those_of_the_same_times(tmp_path, capsys):
    one = saved(tmp_path / "a.h5")
    other = saved(tmp_path / "b.h5", acceleration=-1.62, step=2e-3, name="more")
    code, out, _ = run(capsys, "compare", one, other)
    assert code == 0
    assert "-planar scene, gravity (0, -9.81)" in out
    assert "+planar scene, gravity (0, -1.62)" in out
    assert re.search(r"\+dt: 0.002", out)
    distances = [float(each) for each in re.findall(r"largest distance (\S+) m", out)]
    np.testing.assert_allclose(distances, [0.5 * (9.81 - 1.62) * 0.1**2] * 3, rtol=2e-4)
    assert "t = 0.1 s" in out
    assert f"more: in {other} alone" in run(capsys, "compare", other, one)[1]


def test_other_nodes_and_files_that_are_no_runs(tmp_path, capsys):
    one = saved(tmp_path / "a.h5", name="more")
    scene = ancf.Scene((0.0, -9.81))
    scene.add_beam("thin", (0, 0), (1, 0), 5, SECTION, MATERIAL, name="bar")
    ancf.simulate(scene, 0.1, 1e-3, output=tmp_path / "b.h5")
    assert "bar: with other nodes" in run(capsys, "compare", one, tmp_path / "b.h5")[1]
    (tmp_path / "c.h5").write_text("no run")
    code, _, err = run(capsys, "compare", one, tmp_path / "c.h5")
    assert code == 2
    assert "c.h5" in err
    assert pytest.approx(0.1) == ancf.load(one).t[-1]
