"""The JSON schema of files of scenes: published as generated, accepts files, refuses mistakes."""

import importlib.util
import json
import tomllib
from dataclasses import fields
from functools import cache
from inspect import isfunction
from pathlib import Path

import pytest

from ancfsparse import cli, problems
from ancfsparse.cli.scene_run import METHOD_KINDS, SETTINGS, STARTER
from ancfsparse.cli.scene_schema import ALIASES, NOT_IN_FILES, scene_schema
from ancfsparse.scene import Scene
from ancfsparse.scene.records.record import RECORD_TYPES
from ancfsparse.scene.storage.json_file import DATA
from ancfsparse.scene.storage.named_parts import arguments_of
from tests.cli.command import run
from tests.scene.everything import everything

needs_jsonschema = pytest.mark.skipif(
    importlib.util.find_spec("jsonschema") is None, reason="jsonschema is not installed"
)
PUBLISHED = Path(cli.__file__).parent / "scene.schema.json"


@cache
def validator():
    from jsonschema import Draft202012Validator

    schema = scene_schema()
    Draft202012Validator.check_schema(schema)
    return Draft202012Validator(schema)


def errors_of(data):
    return list(validator().iter_errors(data))


def starter():
    return tomllib.loads(STARTER.read_text(encoding="utf-8"))


def test_the_published_schema_is_the_generated_one(tmp_path, capsys):
    file = tmp_path / "scene.schema.json"
    assert run(capsys, "schema", file) == (0, f"written: {file}\n", "")
    assert file.read_text() == PUBLISHED.read_text(), (
        "run: ancfsparse schema ancfsparse/cli/scene.schema.json"
    )
    code, out, _ = run(capsys, "schema")
    assert (code, json.loads(out)) == (0, scene_schema())


def test_every_argument_of_every_method_is_in_the_schema():
    schema = scene_schema()
    assert set(
        schema["properties"]["parts"]["additionalProperties"]["properties"]["method"]["enum"]
    ) == (set(RECORD_TYPES))
    for name, record in RECORD_TYPES.items():
        there = set(schema["$defs"][name]["properties"]) - {"method"}
        assert there == {each.name for each in fields(record)} - {"name"}
    assert set(schema["properties"]["run"]["properties"]) == set(SETTINGS)


def test_every_word_of_annotations_is_known():
    known = {"Any", "float", "int", "str", "bool", "ArrayLike", "Vector", "ElementKind"}
    known |= {"tuple", "Sequence", "Iterable", "Callable"} | ALIASES.keys() | NOT_IN_FILES
    known |= {base.__name__ for k in (DATA | METHOD_KINDS).values() for base in k.__mro__}
    known |= {"Point", "Joint", "Beam", "Mesh", "RigidBody", "ElasticBody"}
    calls = [*(getattr(Scene, name) for name in RECORD_TYPES), *DATA.values()]
    arguments = [each for call in calls for each in arguments_of(call)] + [*SETTINGS.values()]
    assert set().union(*(each.words for each in arguments)) <= known


@pytest.mark.slow
@needs_jsonschema
def test_files_of_all_scenes_satisfy_the_schema(tmp_path):
    file = tmp_path / "scene.toml"
    makers = [getattr(problems, name) for name in problems.__all__]
    scenes = [make().scene for make in makers if isfunction(make)]
    for scene in [*scenes, everything(2)]:
        scene.save(file)
        assert errors_of(tomllib.loads(file.read_text())) == []
    assert errors_of(starter()) == []


def _set(*keys, value):
    data = starter()
    inner = data
    for key in keys[:-1]:
        inner = inner[key]
    inner[keys[-1]] = value
    return data


@needs_jsonschema
@pytest.mark.parametrize(
    "data",
    [
        _set("part", value={}),
        _set("gravity", value="down"),
        _set("parts", "left", value=3),
        _set("parts", "left", "nod", value="rope.end"),
        _set("parts", "left", "method", value="pinn"),
        _set("parts", "left", "as_constraint", value="yes"),
        _set("parts", "rope", "name", value="x"),
        _set("parts", "rope", "n_elements", value=2.5),
        _set("parts", "rope", "section", "kind", value="Circ"),
        _set("parts", "rope", "section", "diameter", value=[1]),
        _set("parts", "wind", "value", "frequency", value="often"),
        _set("run", "tend", value=1),
        _set("run", "solver", value={"kind": "Newto"}),
    ],
)
def test_mistakes_in_files_violate_the_schema(data, tmp_path, capsys):
    assert errors_of(data)
    (tmp_path / "scene.json").write_text(json.dumps(data))
    code, _, err = run(capsys, "run", tmp_path / "scene.json")
    assert code == 2
    assert "scene.json, line 1, " in err
