"""The JSON schema of files of scenes, from the methods of `Scene` that have records.

It is published in scene.schema.json, which ``ancfsparse schema`` writes.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from ancfsparse.cli.scene_run import METHOD_KINDS, SETTINGS
from ancfsparse.file_names import check_target
from ancfsparse.plans.goal_oriented_run import simulate
from ancfsparse.scene import Scene
from ancfsparse.scene.records.record import RECORD_TYPES, REFERENCE_TYPES
from ancfsparse.scene.records.signals import Table
from ancfsparse.scene.storage.handle_names import TYPES as HANDLES
from ancfsparse.scene.storage.json_file import DATA, FORMAT
from ancfsparse.scene.storage.named_parts import Argument, arguments_of, descriptions_of
from ancfsparse.scene.storage.quantities import QUANTITY
from ancfsparse.scene.storage.scene_file import VERSION

Schema = dict[str, Any]

NUMBER = {"anyOf": [{"type": "number"}, {"type": "string", "pattern": f"^{QUANTITY.pattern}$"}]}
NUMBERS = {
    "anyOf": [
        {"$ref": "#/$defs/number"},
        {"type": "array", "items": {"$ref": "#/$defs/numbers"}},
        {"$ref": "#/$defs/packed numbers"},
    ]
}
PACKED = {
    "type": "object",
    "required": ["array", "shape", "base64"],
    "properties": {
        "array": {"type": "string"},
        "shape": {"type": "array", "items": {"type": "integer"}},
        "base64": {"type": "string"},
    },
}
OWN = {"type": "object", "required": ["own"], "properties": {"own": {"type": "string"}}}
HANDLE = {
    "anyOf": [
        {"type": "string"},
        {"type": "object", "properties": {"kind": {"enum": sorted(REFERENCE_TYPES)}}},
    ]
}
SIMPLE: dict[str, Schema] = {
    "float": {"$ref": "#/$defs/number"},
    "int": {"type": "integer"},
    "str": {"type": "string"},
    "bool": {"type": "boolean"},
    "ArrayLike": {"$ref": "#/$defs/numbers"},
    "Vector": {"$ref": "#/$defs/numbers"},
    "ElementKind": {"$ref": "#/$defs/own"},
}
CONTAINERS = frozenset({"tuple", "Sequence", "Iterable"})
ALIASES = {
    "AnyCurve": "Arc Helix ArrayLike Callable",
    "Angle": "float Callable",
    "Corners": "ArrayLike",
    "Direction": "ArrayLike Callable",
    "Eigencurvature": "ArrayLike Signal Callable",
    "Eigenstrain": "float Signal Callable",
    "Function": "Callable",
    "Method": "NonlinearMethod",
    "Stiffness": "float Callable",
    "Value": "float ArrayLike",
    "VelocityField": "Callable",
}
"""Names of unions in annotations, with their members."""
NOT_IN_FILES = frozenset({"None", "bodies", "State", "Equilibrium"})
"""Words in annotations without a form in files."""


def scene_schema() -> Schema:
    """Return the JSON schema (2020-12) of files of named parts."""
    methods = {name: getattr(Scene, name) for name in sorted(RECORD_TYPES)}
    calls = {name: _object(call, DATA, {"method": name}) for name, call in methods.items()}
    kinds = dict(sorted((DATA | METHOD_KINDS).items()))
    data = {name: _object(kind, kinds, {"kind": name}) for name, kind in kinds.items()}
    table = data[Table.__name__]
    table["properties"]["csv"] = {"type": "string", "description": "CSV file: times and values."}
    table["anyOf"] = [{"required": table.pop("required")}, {"required": ["csv"]}]
    texts = descriptions_of(simulate)
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A scene of ancfsparse: parts, which are calls of methods of Scene, and a run",
        "type": "object",
        "additionalProperties": False,
        "properties": {
            "$schema": {"type": "string"},
            "format": {"const": FORMAT},
            "version": {"const": VERSION},
            **{each.name: _value(each, DATA, "") for each in arguments_of(Scene)},
            "parts": {
                "type": "object",
                "additionalProperties": {
                    "type": "object",
                    "required": ["method"],
                    "properties": {"method": {"enum": list(calls)}},
                    "allOf": [_if_method(name) for name in calls],
                },
            },
            "run": {
                "type": "object",
                "additionalProperties": False,
                "properties": {
                    name: _value(each, METHOD_KINDS, texts.get(name, ""))
                    for name, each in SETTINGS.items()
                },
            },
        },
        "$defs": {
            "number": NUMBER,
            "numbers": NUMBERS,
            "packed numbers": PACKED,
            "own": OWN,
            **calls,
            **data,
        },
    }


def _if_method(name: str) -> Schema:
    is_method = {"properties": {"method": {"const": name}}}
    return {"if": is_method, "then": {"$ref": f"#/$defs/{name}"}}


def _object(call: Callable[..., Any], kinds: Mapping[str, Any], head: Mapping[str, str]) -> Schema:
    """Return the schema of the arguments of a call; `head` has its name."""
    texts = descriptions_of(call)
    is_part = "method" in head
    arguments = [each for each in arguments_of(call) if not (is_part and each.name == "name")]
    summary = (call.__doc__ or "").strip().split("\n", 1)[0]
    return {
        "type": "object",
        "description": summary,
        "additionalProperties": False,
        "required": [each.name for each in arguments if each.required],
        "properties": {
            **{name: {"const": value} for name, value in head.items()},
            **{each.name: _value(each, kinds, texts.get(each.name, "")) for each in arguments},
        },
    }


def _value(argument: Argument, kinds: Mapping[str, Any], text: str) -> Schema:
    """Return the schema of an argument."""
    words = argument.words.difference(ALIASES, NOT_IN_FILES).union(
        *(ALIASES[word].split() for word in argument.words.intersection(ALIASES))
    )
    forms = [form for word in sorted(words - CONTAINERS) for form in _forms(word, kinds)]
    if words & CONTAINERS:
        items = [*forms, {"$ref": "#/$defs/numbers"}]
        forms.append({"type": "array", "items": {"anyOf": items}})
    return {"anyOf": forms} | ({"description": text} if text else {}) if all(forms) else {}


def _forms(word: str, kinds: Mapping[str, Any]) -> Iterator[Schema]:
    """Return the forms of values of a type; an empty one if the type is unknown here."""
    bases = {name: kind.__mro__ for name, kind in kinds.items()}
    if word in SIMPLE:
        yield SIMPLE[word]
    elif word in HANDLES:
        yield HANDLE
    elif word == "Callable":
        yield {"$ref": "#/$defs/own"}
        callables = (k for k, each in bases.items() if any("__call__" in b.__dict__ for b in each))
        yield from ({"$ref": f"#/$defs/{name}"} for name in callables)
    else:
        members = [k for k, each in bases.items() if word in {base.__name__ for base in each}]
        yield from ({"$ref": f"#/$defs/{name}"} for name in members)
        if not members:
            yield {}


def schema(
    file: Annotated[Path | None, typer.Argument(help="File to write, .json.")] = None,
) -> None:
    """Write the JSON schema of files of scenes, or print it."""
    text = json.dumps(scene_schema(), indent=1, ensure_ascii=False) + "\n"
    if file is None:
        typer.echo(text, nl=False)
        return
    check_target("the schema", file, (".json",)).write_text(text, encoding="utf-8")
    typer.echo(f"written: {file}")
