"""Scenes of named parts in TOML and JSON: equal to those of Python; errors name their lines."""

import json
import tomllib

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.scene.records.record import RECORD_TYPES
from tests.scene.everything import everything
from tests.scene.storage.test_scene_files import functions

HEAD = "gravity = [0, -9.81]\n"
ROPE = """[parts.rope]
method = "add_beam"
element = "thin"
start = [0, 0]
end = ["50 cm", 0]
n_elements = 4
section = { kind = "Circle", diameter = "10 mm" }
material = { youngs_modulus = "2 GPa", density = 1500 }
"""


def loaded(tmp_path, text, own=None):
    file = tmp_path / "scene.toml"
    file.write_text(text, encoding="utf-8")
    return ancf.Scene.load(file, own)


def rope(gravity=(0.0, -9.81)):
    scene = ancf.Scene(gravity)
    zeros = [0.0] * (len(gravity) - 1)
    beam = scene.add_beam(
        "thin",
        (0, *zeros),
        (0.5, *zeros),
        4,
        ancf.Circle(0.01),
        ancf.Material(2e9, 1500),
        name="rope",
    )
    return scene, beam


def test_parts_are_calls_with_names_in_place_of_handles(tmp_path):
    scene, beam = rope((0.0, 0.0, -9.81))
    block = scene.add_body(ancf.Box(length=0.2, width=0.1, height=0.1), density=500.0,
                           position=(1.0, 0.0, 0.0), name="my block")  # fmt: skip
    hinge = scene.revolute(block.origin, axis=(0, 1, 0))
    scene.pin(beam.start)
    scene.drive(beam.end, ancf.Ramp((0.0, 0.1, 0.0), 0.5, smooth=True) + np.array([0.5, 0.0, 0.0]))
    scene.joint_spring(hinge, stiffness=10.0)
    scene.spring(beam.at(0.3), (0.0, 1.0, 0.0), stiffness=1e3)
    scene.spring(beam.node(1), block.at((0.1, 0.05, 0.0)), stiffness=1e3)
    scene.point_force(beam.at(0.2), ancf.Sine((0.0, 5.0, 0.0), 3.0))
    scene.distributed_force(beam, (0.0, 1.0, 0.0))
    scene.contact(beam, ancf.HalfSpace((0.0, -0.4, 0.0), (0.0, 1.0, 0.0)), friction=0.3)
    text = """gravity = [0, 0, "-9.81 m/s2"]
[parts.rope]
method = "add_beam"
element = "thin"
start = [0, 0, 0]
end = ["50 cm", 0, 0]
n_elements = 4
section = { kind = "Circle", diameter = "10 mm" }
material = { youngs_modulus = "2 GPa", density = 1500 }

[parts."my block"]
method = "add_body"
shape = { kind = "Box", length = "20 cm", width = 0.1, height = 0.1 }
density = "500 kg/m3"
position = [1, 0, 0]

[parts]
hinge = { method = "revolute", a = "my block.origin", axis = [0, 1, 0] }
left = { method = "pin", node = "rope.start" }

[parts.right]
method = "drive"
node = "rope.end"
position = { kind = "Sum", constant = ["500 mm", 0, 0], parts = [
  { kind = "Ramp", value = [0, "0.1 m", 0], end = "500 ms", smooth = true } ] }

[parts.torsion]
method = "joint_spring"
joint = "hinge"
stiffness = "10 N m/rad"

[parts.string]
method = "spring"
a = "rope.at(30 cm)"
b = [0, 1, 0]
stiffness = "1 kN/m"

[parts.tie]
method = "spring"
a = "rope.node(1)"
b = "my block.at(0.1, 0.05, 0)"
stiffness = "1 kN/m"

[parts.force]
method = "point_force"
node = "rope.at(0.2)"
value = { kind = "Sine", amplitude = [0, "5 N", 0], frequency = "3 Hz" }

[parts.weight]
method = "distributed_force"
beam = "rope"
value = [0, "1 N/m", 0]

[parts.floor]
method = "contact"
body = "rope"
obstacle = { kind = "HalfSpace", base = [0, -0.4, 0], normal = [0, 1, 0] }
friction = 0.3
"""
    again = loaded(tmp_path, text)
    assert again == scene
    assert again.digest() == scene.digest()
    file = tmp_path / "scene.json"  # the same in JSON
    file.write_text(json.dumps(tomllib.loads(text)), encoding="utf-8")
    assert ancf.Scene.load(file) == scene


def test_everything_can_be_written_as_toml_and_comes_back(tmp_path):
    scene = everything(2)
    assert {record.method for record in scene.records} == set(RECORD_TYPES)
    scene.save(tmp_path / "scene.toml")
    again = ancf.Scene.load(tmp_path / "scene.toml", functions(scene))
    assert again == scene
    assert again.digest() == scene.digest()


def test_texts_of_any_letters_come_back(tmp_path):
    scene, beam = rope()
    for name in ('a "quoted" \\ name', "δ\x7f\n\t", "rope.end", "run", "1 m", "😀"):
        scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(0.0, 1.0), name=name)
        scene.connect(beam.end, scene.body(name).origin, apart=True)
    scene.save(tmp_path / "scene.toml")
    assert ancf.Scene.load(tmp_path / "scene.toml") == scene


def test_a_table_is_read_from_csv(tmp_path):
    (tmp_path / "gust.csv").write_text("t [s],x,y\n0,0,0\n0.5,1,2\n1,0,-1\n")
    text = (
        HEAD
        + ROPE
        + """[parts.gust]
method = "point_force"
node = "rope.end"
value = { kind = "Table", csv = "gust.csv", outside = "hold" }
"""
    )
    scene, beam = rope()
    scene.point_force(beam.end, ancf.Table([0, 0.5, 1], [(0, 0), (1, 2), (0, -1)], outside="hold"))
    assert loaded(tmp_path, text) == scene
    for content, message in (
        ("0,0\n1\n", "cannot be read: the number of columns changed from 2 to 1 at row 2"),
        ("0\n1\n", "needs rows of a time"),
        ("", "needs rows of a time"),
        ("t,x,y\n", "needs rows of a time"),
        ("0,0,0\n1,x,0\n", "could not convert string 'x'"),
        ("0,0,0\n1,,0\n", "could not convert string ''"),
        ("0,0,0\n0,1,0\n", "line 13, parts.gust.value.times: times of a table must increase"),
    ):
        (tmp_path / "gust.csv").write_text(content)
        with pytest.raises(ancf.InputError, match=message):
            loaded(tmp_path, text)
    for name in ("/dev/zero", "missing.csv", ".", "a\\u0000b"):
        with pytest.raises(
            ancf.InputError, match=r"line 13, parts.gust.value.csv: .*(not a|needs)"
        ):
            loaded(tmp_path, text.replace("gust.csv", name))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            '[parts.left]\nmethod = "pin"\n\nnod = "rope.start"',
            r"line 13, parts.left.nod: unknown argument of pin 'nod': did you mean 'node'\?",
        ),
        ('[parts.left]\nmethod = "pinn"', "line 11, parts.left.method: .* did you mean 'pin'"),
        ("[parts.left]\nnode = 3", "line 10, parts.left: a part needs the name of a method"),
        ("[parts]\nleft = 3", "line 11, parts.left: a part must be a table"),
        ('[parts.left]\nmethod = "pin"', "line 10, parts.left: pin lacks node"),
        (
            '[parts]\nleft = { method = "pin", node = "rop.start" }',
            "line 11, parts.left.node: no part before this one is named 'rop': did you mean 'rope'",
        ),
        (
            '[parts]\nleft = { method = "pin", node = "rope.strat" }',
            "line 11, parts.left.node: unknown point of rope 'strat': did you mean 'start'",
        ),
        (
            '[parts]\nleft = { method = "pin", node = "rope.at" }',
            r"line 11, parts.left.node: this point is written rope.at\(...\)",
        ),
        ('[parts]\nleft = { method = "pin", node = "rope.at(1)" }', "lies outside rope"),
        ('[parts]\nleft = { method = "pin", node = "rope.at(q=1)" }', "unknown argument of at 'q'"),
        ('[parts]\nleft = { method = "pin", node = "rope.at(1, 2)" }', "too many positional"),
        ('[parts]\nleft = { method = "pin", node = "rope.__class__" }', "unknown point of rope"),
        (
            '[parts]\na = { method = "pin", node = "rope.end" }\n'
            'b = { method = "pin", node = "a.end" }',
            "line 12, parts.b.node: a is not a body and has no points",
        ),
        (
            '[parts.load]\nmethod = "point_force"\nnode = "rope.end"\nvalue = [0, "1 m"]',
            "line 13, parts.load.value: a unit such as N is needed, got '1 m'",
        ),
        (
            '[parts.load]\nmethod = "point_force"\nnode = "rope.end"\n'
            'value = { kind = "Sin", amplitude = 1 }',
            "line 13, parts.load.value.kind: unknown kind 'Sin': did you mean 'Sine'",
        ),
        (
            '[parts.load]\nmethod = "point_force"\nnode = "rope.end"\n'
            'value = { kind = "Sine", amplitude = [0, 1], frequency = -3 }',
            "line 13, parts.load.value.frequency: frequency of a sine must be positive",
        ),
        (
            '[parts.load]\nmethod = "point_force"\nnode = "rope.end"\n'
            'value = { own = "os.system" }',
            "line 13, parts.load.value: it needs 'os.system', which a file cannot hold",
        ),
        (
            '[parts.other]\nmethod = "add_beam"\nname = "x"',
            "line 12, parts.other.name: unknown argument of add_beam 'name'",
        ),
        ("[runs]\n", "line 10, runs: unknown key 'runs': did you mean 'run'"),
        ("[parts.left\n", "is not a file of a scene: .*line 10"),
        ("[parts]\nx = " + "[" * 500 + "]" * 500, "is not a file of a scene: maximum recursion"),
    ],
)  # fmt: skip
def test_errors_name_line_key_and_nearest_key(tmp_path, text, message):
    with pytest.raises(ancf.InputError, match=message) as error:
        loaded(tmp_path, HEAD + ROPE + text)
    assert "scene.toml" in str(error.value)


def test_lines_in_json_are_found(tmp_path):
    data = tomllib.loads(HEAD + ROPE)
    data["parts"]["left"] = {"method": "pin", "nod": '"parts": {,]'}
    file = tmp_path / "scene.json"
    file.write_text(json.dumps(data, indent=1), encoding="utf-8")
    line = file.read_text().splitlines().index(r'   "nod": "\"parts\": {,]"') + 1
    with pytest.raises(ancf.InputError, match=f"line {line}, parts.left.nod: unknown argument"):
        ancf.Scene.load(file)
    file.write_text('{"gravity": [0, 0], "parts": {}, "parts": {}}')
    with pytest.raises(ancf.InputError, match="the key 'parts' occurs twice"):
        ancf.Scene.load(file)
    file.write_text("[]")
    with pytest.raises(ancf.InputError, match="is not a file of a scene"):
        ancf.Scene.load(file)
    with pytest.raises(ancf.InputError, match="it is not a file"):
        ancf.Scene.load(tmp_path)


def test_the_head_of_a_file_is_checked(tmp_path):
    for text, message in (
        ("gravity = [0, 1e300]", "line 1, gravity: gravity must be at most 1e\\+100 m/s2, got 1e"),
        ("gravity = 3", "line 1, gravity: gravity must have 2 components"),
        (
            'gravity = { kind = "Point", body = "x", index = 0 }',
            "line 1, gravity.kind: unknown kind",
        ),
        ('gravity = [0, "1 m"]', "line 1, gravity: a unit such as m/s2 is needed"),
        ("parts = 3", "line 1, parts: parts must be a table|parts must be a table"),
        ('format = "xml"', "its format is not 'ancfsparse scene'"),
        ("version = 3", "its format is not|has version 3"),
    ):
        with pytest.raises(ancf.InputError, match=message):
            loaded(tmp_path, text)
