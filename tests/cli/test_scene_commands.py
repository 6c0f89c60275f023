"""Commands on files of scenes: what runs from a file is the same run as in Python."""

import json
import re
import tomllib

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.cli.scene_run import SETTINGS
from tests.cli.command import run


@pytest.fixture
def starter(tmp_path, capsys):
    file = tmp_path / "scene.toml"
    code, out, err = run(capsys, "new", file)
    assert (code, err) == (0, "")
    assert f"ancfsparse run {file} -o scene.h5" in out
    return file


def in_python():
    """Return the scene of the starter, made in Python."""
    scene = ancf.Scene(gravity=(0, -9.81))
    rope = scene.add_beam(
        "thin", (0, 0), (1, 0), 20, ancf.Circle(0.01), ancf.Material(2e9, 1500), length=1.2,
        name="rope",
    )  # fmt: skip
    scene.pin(rope.start)
    scene.pin(rope.end)
    scene.distributed_force(rope, ancf.Sine((5.0, 0.0), 2.0))
    return scene


def test_the_starter_runs_as_in_python(starter, tmp_path, capsys):
    assert ancf.Scene.load(starter) == in_python()
    output = tmp_path / "run.h5"
    code, out, err = run(capsys, "run", starter, "-o", output)
    assert (code, err) == (0, "")
    assert "500 steps" in out
    assert f"written: {output}" in out
    expected = ancf.simulate(in_python(), 1.0, 2e-3, save_every=5, start="equilibrium")
    np.testing.assert_array_equal(ancf.load(output).q[:], expected.q)


def test_options_replace_settings(starter, tmp_path, capsys):
    output = tmp_path / "run.h5"
    words = "--time", 0.1, "--step", 1e-3, "--integrator", "hht", "--solver", "newton"
    words += "--save-every", 100, "--set", "start=equilibrium", "--set", "tolerance=1e-3"
    code, _, err = run(capsys, "run", starter, "-o", output, *words)
    assert (code, err) == (0, "")
    settings = ancf.load(output).settings
    assert (settings["t_end"], settings["dt"], settings["save_every"]) == (0.1, 1e-3, 100)
    assert "HHT" in str(settings["integrator"])
    assert "Newton" in str(settings["solver"])
    code, out, _ = run(capsys, "run", starter, "--time", 0.1, "--accuracy", 1e-3)
    assert code == 0
    assert "estimated" in out or "steps" in out


def test_comments_of_the_starter_are_parts_too(starter, capsys):
    text = starter.read_text()
    begin = text.index("# [parts.floor]")
    floor = text[begin : text.index("# The arguments")]
    starter.write_text(text.replace(floor, floor.replace("# ", "")))
    code, out, err = run(capsys, "check", starter)
    assert (code, err) == (0, "")
    assert "contact: body rope, obstacle HalfSpace" in out
    assert "run: t_end 1.0, dt 0.002, start equilibrium, save_every 5\n" in out


def test_methods_and_points_are_settings(starter, capsys, tmp_path):
    data = tomllib.loads(starter.read_text())
    data["run"] |= {
        "integrator": {"kind": "GeneralizedAlpha", "rho_inf": 0.8},
        "solver": {"kind": "QuasiNewton", "update": "bfgs", "memory": 10},
        "save_nodes": ["rope.at(60 cm)"],
    }
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(data), encoding="utf-8")
    code, _, err = run(capsys, "run", file, "-o", tmp_path / "run.h5")
    assert (code, err) == (0, "")
    result = ancf.load(tmp_path / "run.h5")
    assert result.settings["integrator"] == "GeneralizedAlpha(rho_inf=0.8)"
    middle = result.system.scene.beams[0].at(0.6)
    assert np.isfinite(result.position(middle)).all()


def test_a_list_of_records_runs_too(tmp_path, capsys):
    in_python().save(tmp_path / "scene.json")
    words = "--set", 'save_nodes=["rope.at(0.6)"]', "--time", 0.1, "--step", 2e-3
    code, out, err = run(capsys, "run", tmp_path / "scene.json", *words)
    assert (code, err) == (0, "")
    assert "50 steps" in out
    code, _, err = run(
        capsys, "run", tmp_path / "scene.json", *words[2:], "--set", "save_nodes=[3]"
    )
    assert code == 2
    assert "save_nodes" in err


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("t_end =", "tend =", "line 37, run.tend: .* 'tend': did you mean 't_end'?"),
        ('"2 ms"', '"2 mm"', "line 38, run.dt: a unit such as s is needed, got '2 mm'"),
        ('"2 ms"', '"3 ms"', "line 38, run.dt: dt = 0.003 s does not divide t_end = 1 s"),
        ('"equilibrium"', '"rest"', "line 39, run.start: unknown start 'rest'"),
        ("save_every = 5", "save_every = 0", "line 40, run.save_every: save_every must be"),
        ("save_every = 5", 'output = "x.h5"', "line 40, run.output: unknown argument of run"),
        ("save_every = 5", 'solver = "newtom"', "line 40, run.solver: .* did you mean 'newton'"),
        ("save_every = 5", "solver = { kind = 'Newto' }", "line 40, run.solver.kind: unknown kind"),
        ("[run]", "[[run]]", "line 36, run: run must be a table of settings|run must be a table"),
        ('node = "rope.end"', 'node = "rope.en"', "line 22, parts.right.node: .* mean 'end'"),
    ],
)
def test_errors_name_the_line(starter, capsys, old, new, message):
    text = starter.read_text()
    assert old in text
    starter.write_text(text.replace(old, new))
    code, out, err = run(capsys, "run", starter)
    assert (code, out) == (2, "")
    assert err.startswith("ancfsparse: ")
    assert err.count("\n") == 1
    assert re.search(message, err)


def test_errors_of_options_name_the_option(starter, capsys):
    for words, message in (
        (("--step", 3e-3), "--step 0.003 s does not divide --time 1 s"),
        (("--integrator", "newmrk"), "unknown integrator 'newmrk': did you mean 'newmark'?"),
        (("--set", "t_end=true"), "--time must be a number, got True"),
        (("--set", "threads"), "--set needs key=value, got 'threads'"),
        (("--set", "thread=1"), "unknown key of --set 'thread': did you mean 'threads'?"),
    ):
        code, _, err = run(capsys, "run", starter, *words)
        assert code == 2
        assert message in err


def test_a_file_without_settings_needs_the_time(starter, capsys):
    text = starter.read_text()
    starter.write_text(text[: text.index("[run]")])
    code, _, err = run(capsys, "run", starter)
    assert code == 2
    assert "has no t_end in its table run: give it there, or --time" in err
    code, _, err = run(capsys, "run", starter, "--time", 0.01, "--step", 1e-3)
    assert (code, err) == (0, "")


def test_a_run_that_fails_is_reported_in_one_line(starter, capsys):
    text = starter.read_text()
    begin = text.index("value = { kind")
    table = "value = { kind = 'Table', times = [0, 0.1], values = [[0, 0], [1, 1]] }\n"
    starter.write_text(text[:begin] + table + text[text.index("# [parts.floor]") :])
    code, _, err = run(capsys, "run", starter)
    assert code == 1
    assert "the table has values from t = 0 s to 0.1 s" in err
    assert "trajectory" not in err
    assert err.count("\n") == 1


def test_new_replaces_nothing(starter, capsys):
    starter.write_text("mine")
    code, _, err = run(capsys, "new", starter)
    assert code == 2
    assert "exists: give the name of a new file" in err
    assert starter.read_text() == "mine"
    code, _, err = run(capsys, "new", starter.with_suffix(".json"))
    assert code == 2
    assert "must end in .toml" in err


def test_settings_are_arguments_of_simulate_that_are_data():
    assert {"t_end", "dt", "accuracy", "integrator", "solver", "save_every"} <= SETTINGS.keys()
    assert not {"scene", "output", "quantity"} & SETTINGS.keys()


def test_data_of_the_scene_are_replaced_by_their_keys(starter, tmp_path, capsys):
    output = tmp_path / "run.h5"
    words = "--time", 0.02, "--set", "parts.rope.length=1.3 m", "--set", "gravity=[0, -1.62]"
    assert run(capsys, "run", starter, *words, "-o", output)[0] == 0
    scene = ancf.load(output).system.scene
    assert scene.beams[0].length == 1.3
    assert scene.gravity.tolist() == [0.0, -1.62]


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ("parts.rop.length=1", "unknown key of --set parts 'rop': did you mean 'rope'?"),
        ("parts.rope.lenght=1", "unknown key of --set parts.rope 'lenght': did you mean 'length'?"),
        ("gravity.x=1", "--set gravity.x: gravity is not a table"),
        ("parts.rope.length=-1", "line 12, parts.rope.length: length of rope must be positive"),
        ("parts.rope=1", "parts.rope"),
        (".=1", "unknown key of --set ''"),
    ],
)
def test_replaced_data_are_checked(starter, capsys, change, message):
    code, _, err = run(capsys, "run", starter, "--set", change)
    assert code == 2
    assert message in err
