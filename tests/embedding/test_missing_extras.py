"""Without the package of an extra, a call is refused in a sentence that names the command."""

import ancfsparse as ancf
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
