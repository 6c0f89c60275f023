"""Without the package of an extra, a call is refused in a sentence that names the command."""

import sys

import ancfsparse as ancf
from ancfsparse import embedding
from ancfsparse.embedding import fmu, robot_file
from tests.solve.refusals import assert_refused


def test_robots_need_the_extra_urdf(monkeypatch):
    monkeypatch.setattr(robot_file, "URDF", None)
    scene = ancf.Scene((0, 0, -9.81))
    assert_refused(r"pip install 'ancfsparse\[urdf\]'", ancf.urdf.add, scene, "arm.urdf")


def test_fmus_need_the_extra_fmu(monkeypatch):
    monkeypatch.setattr(fmu, "FmuBuilder", None)
    scene = ancf.Scene((0, 0, -9.81))
    assert_refused(
        r"pip install 'ancfsparse\[fmu\]'", ancf.fmu.write, "a.fmu", scene, outputs={}, dt=1e-3
    )


def test_environments_need_the_extra_gym(monkeypatch):
    monkeypatch.setitem(sys.modules, "gymnasium", None)
    monkeypatch.delitem(sys.modules, "ancfsparse.embedding.environment", raising=False)
    monkeypatch.delitem(vars(embedding), "environment", raising=False)
    scene = ancf.Scene()
    force = ancf.Input(2)
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, ancf.Circle(0.01), ancf.Material(1e7, 1e3))
    scene.point_force(rod.end, force)
    arguments = {force: (-1.0, 1.0)}, [lambda sim: sim.t], lambda sim: 0.0, 1e-3
    assert_refused(r"pip install 'ancfsparse\[gym\]'", ancf.gym.make, scene, *arguments)
