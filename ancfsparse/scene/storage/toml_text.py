"""Scenes as TOML: a table for each part, with the arguments that are not defaults."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from inspect import Parameter, signature
from itertools import count
from typing import Any

from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import BodyRef, Record, equal
from ancfsparse.scene.storage.handle_names import name_of_reference
from ancfsparse.scene.storage.json_file import FORMAT, encoded

BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def written_as_toml(scene: SceneBase, settings: Mapping[str, Any] | None = None) -> str:
    """Return a scene as the text of its TOML file.

    Parameters
    ----------
    scene : Scene
        The scene.
    settings : mapping of str to object, optional
        Settings of a run, as data; integrators are dataclasses.

    Raises
    ------
    InputError
        If a file cannot hold it.
    """
    writer = _Writer(scene)
    head = {"format": FORMAT, "version": 2, "gravity": scene.gravity.tolist()}
    tables = ["".join(f"{name} = {toml(value)}\n" for name, value in head.items())]
    for number, record in enumerate(scene.records):
        values = {"method": record.method} | writer.arguments(record, number)
        rows = "".join(f"{_key(name)} = {toml(value)}\n" for name, value in values.items())
        tables.append(f"[parts.{_key(writer.names[number])}]\n{rows}")
    if settings:
        rows = "".join(f"{name} = {toml(value)}\n" for name, value in settings.items())
        tables.append(f"[run]\n{rows}")
    return "\n".join(tables)


class _Writer:
    """The names of the parts of a scene, and their arguments as data."""

    def __init__(self, scene: SceneBase) -> None:
        self.scene = scene
        self.functions: dict[str, object] = {}
        bodies = {body.name for body in scene.bodies}
        numbers_of: dict[str, Iterator[int]] = {}
        self.names: list[str] = []
        for record in scene.records:
            following = numbers_of.setdefault(record.method, count(1))
            numbered = (f"{record.method}-{k}" for k in following)
            name = record.given.get("name")
            self.names.append(name or next(each for each in numbered if each not in bodies))
        self.parts = frozenset(self.names)
        numbers = {id(record): number for number, record in enumerate(scene.records)}
        self.joints = {
            k: self.names[numbers[id(scene.record_of(joint))]]
            for k, joint in enumerate(scene.joints)
        }

    def arguments(self, record: Record, number: int) -> dict[str, Any]:
        """Return the arguments of a record that are not defaults."""
        parameters = signature(getattr(type(self.scene), record.method)).parameters
        where = f"record {number + 1} of the scene, {record.method}"
        return {
            name: self.data(value, where)
            for name, value in record.given.items()
            if name != "name" and not _is_default(value, parameters[name].default)
        }

    def data(self, value: Any, where: str) -> Any:
        """Return an argument as data, with names in place of references."""
        if isinstance(value, BodyRef):
            return name_of_reference(value, self.scene, self.joints, self.parts)
        if isinstance(value, tuple):
            return [self.data(each, where) for each in value]
        data = encoded(value, where, self.functions)
        if is_dataclass(value) and isinstance(data, dict) and "kind" in data:
            changed = {
                each.name: self.data(getattr(value, each.name), where)
                for each in fields(value)
                if each.init and not _is_default(getattr(value, each.name), each.default)
            }
            return {"kind": data["kind"]} | changed
        return data


def _is_default(value: Any, default: Any) -> bool:
    """Return True if an argument can be left out."""
    if default is Parameter.empty:
        return False
    return type(value) is type(default) and equal(value, default)


def toml(value: Any) -> str:
    """Return a value as TOML, in one line."""
    if isinstance(value, Mapping):
        pairs = ", ".join(f"{_key(name)} = {toml(each)}" for name, each in value.items())
        return f"{{ {pairs} }}"
    if is_dataclass(value):
        values = {each.name: getattr(value, each.name) for each in fields(value) if each.init}
        return toml({"kind": type(value).__name__} | values)
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(toml, value))}]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, bool):
        return str(value).lower()
    return repr(value)


def _key(name: str) -> str:
    return name if BARE_KEY.fullmatch(name) else toml(name)
