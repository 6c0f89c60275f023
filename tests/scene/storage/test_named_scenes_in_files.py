"""Every named scene is written to a file and read again: the same records, the same digest."""

from inspect import isfunction

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse import problems
from ancfsparse.scene.storage.json_file import DATA, name_of
from ancfsparse.scene.storage.scene_file import open_scene_file
from tests.cli.command import run

NAMES = [name for name in problems.__all__ if isfunction(getattr(problems, name))]
# Scenes with functions of time or of positions, which a file names but does not hold.
WITH_FUNCTIONS = {
    "chain_over_pulley", "elastic_four_bar", "elastic_slider_crank",
}  # fmt: skip


def functions(scene):
    """Return what a file mentions by name: functions, and signals of the problems."""
    values = [value for record in scene.records for value in record.given.values()]
    return {
        name_of(value): value
        for value in values
        if callable(value) and type(value) not in DATA.values()
    }


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("ending", ["toml", "json"])
def test_a_named_scene_comes_back(tmp_path, name, ending):
    scene = getattr(problems, name)().scene
    file = tmp_path / f"scene.{ending}"
    scene.save(file)
    own = functions(scene)
    assert bool(own) == (name in WITH_FUNCTIONS)
    again = ancf.Scene.load(file, own)
    assert again == scene
    assert again.digest() == scene.digest()


def test_arguments_that_are_defaults_are_left_out(tmp_path):
    scene = problems.pendulum().scene
    scene.save(tmp_path / "scene.toml")
    parts = open_scene_file(tmp_path / "scene.toml").data["parts"]
    assert parts == {
        "beam 0": {
            "method": "add_beam", "element": "thin", "start": [0, 0], "end": [2, 0],
            "n_elements": 10,
            "section": {"kind": "Rectangle", "width": 0.01, "height": 0.01},
            "material": {"kind": "Material", "youngs_modulus": 1e8, "density": 4000},
        },
        "pin-1": {"method": "pin", "node": "beam 0.start"},
    }  # fmt: skip


@pytest.mark.parametrize("name", ["heavy_top", "catenary"])
def test_the_command_writes_a_problem_that_runs_as_in_python(tmp_path, capsys, name):
    case = problems.named.MECHANISMS[name]
    file, output = tmp_path / "scene.toml", tmp_path / "run.h5"
    assert run(capsys, "new", file, "--problem", name)[::2] == (0, "")
    code, _, err = run(capsys, "run", file, "-o", output, "--time", 10 * case.dt)
    assert (code, err) == (0, "")
    mechanism = case.make()
    expected = ancf.simulate(
        mechanism.scene, 10 * case.dt, case.dt, integrator=case.integrator,
        start="equilibrium" if mechanism.settles else None,
    )  # fmt: skip
    np.testing.assert_array_equal(ancf.load(output).q[:], expected.q)
    code, _, err = run(capsys, "new", tmp_path / "other.toml", "--problem", "catenery")
    assert code == 2
    assert "did you mean 'catenary'" in err
