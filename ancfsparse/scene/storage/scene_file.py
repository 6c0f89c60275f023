"""Files of scenes, TOML and JSON, written by users or by scenes."""

from __future__ import annotations

import json
import os
import tomllib
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ancfsparse.checks import check_choice
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_file_name, check_target
from ancfsparse.messages import format_value
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.storage.json_file import FORMAT, AnyScene, built_from_records, written
from ancfsparse.scene.storage.named_parts import KeyedError, Reader, arguments_of, locate_errors
from ancfsparse.scene.storage.source_lines import line_of
from ancfsparse.scene.storage.toml_text import written_as_toml

VERSION = 2  # of files with named parts
ENDINGS = ".json", ".toml"


@dataclass(frozen=True)
class SceneFile:
    """The data of a file of a scene.

    Attributes
    ----------
    file : Path
        The file.
    text : str
        Its text.
    data : dict of str to object
        Its data.
    """

    file: Path
    text: str
    data: dict[str, Any]

    @cached_property
    def has_records(self) -> bool:
        """True for a list of records, as `Scene.save` writes it to JSON."""
        return "records" in self.data or (
            "version" in self.data and self.data["version"] != VERSION
        )

    def read(self, kind: Callable[..., AnyScene], own: Mapping[str, Any]) -> Reader:
        """Build the scene of a class; return it with its parts, for further arguments."""
        if self.has_records:
            scene = built_from_records(kind, self.data, self.file, own)
            bodies = {body.name: body for body in scene.bodies}
            return Reader(scene, own, self.file.parent, handles=bodies)
        known = {each.name: each for each in arguments_of(kind)}
        reader = Reader(None, own, self.file.parent)
        with self.messages():
            with locate_errors(()):
                for name in self.data:
                    with locate_errors((name,)):
                        check_choice(
                            "key", name, ("format", "version", *known, "parts", "run", "$schema")
                        )
                if self.data.get("format", FORMAT) != FORMAT:
                    raise InputError(f"its format is not {FORMAT!r}")
                parts = self.data.get("parts", {})
                if not isinstance(parts, dict):
                    raise InputError("parts must be a table of parts by name")
            head = {name: value for name, value in self.data.items() if name in known}
            values = reader.arguments(known, head, (), "a scene")
            with locate_errors((), head):
                reader.scene = kind(**values)
            for name, entry in parts.items():
                reader.add_part(name, entry)
        return reader

    @contextmanager
    def messages(self) -> Iterator[None]:
        """Add the file, the line and the keys to the message of an error."""
        try:
            yield
        except KeyedError as error:
            line = line_of(self.text, error.keys, self.file.suffix == ".toml")
            where = [str(self.file), *([f"line {line}"] if line else [])]
            where += [".".join(error.keys)] if error.keys else []
            raise InputError(f"{', '.join(where)}: {error}") from error
        except RecursionError as error:
            raise InputError(f"{self.file} is nested too deeply") from error


def open_scene_file(path: str | Path) -> SceneFile:
    """Read the data of a file of a scene.

    Raises
    ------
    InputError
        If it cannot be read, or is neither TOML nor JSON.
    """
    file = check_file_name("the file of a scene", path, "scene.toml")
    try:
        if file.exists() and not file.is_file():
            raise InputError(f"the scene {file} cannot be read: it is not a file")
        text = file.read_bytes().decode("utf-8")
        data = tomllib.loads(text) if file.suffix == ".toml" else _from_json(text)
    except OSError as error:
        raise InputError(f"the scene {file} cannot be read: {error.strerror}") from error
    except (ValueError, RecursionError) as error:  # not text, or neither TOML nor JSON
        if isinstance(error, InputError):
            raise
        raise InputError(f"{file} is not a file of a scene: {error}") from error
    if not isinstance(data, dict):
        raise InputError(f"{file} is not a file of a scene: its format is not {FORMAT!r}")
    return SceneFile(file, text, data)


def _from_json(text: str) -> Any:
    return json.loads(text, object_pairs_hook=_without_repetition)


def _without_repetition(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    data = dict(pairs)
    if len(data) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"the key {twice!r} occurs twice in one object")
    return data


def load(kind: Callable[[Any], AnyScene], path: str | Path, own: Mapping[str, Any]) -> AnyScene:
    """Read a scene; see `Scene.load`."""
    if not isinstance(own, Mapping):
        raise InputError(
            f"own must be a mapping of names to functions and elements, got {format_value(own)}"
        )
    scene: AnyScene = open_scene_file(path).read(kind, own).scene
    return scene


def save(scene: SceneBase, path: str | Path) -> None:
    """Write a scene; see `Scene.save`."""
    file = check_target("the file of a scene", path, ENDINGS)
    text = written_as_toml(scene) if file.suffix == ".toml" else written(scene)
    part = file.with_name(f".{file.name}.{os.getpid()}")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(file)
    except OSError as error:
        with suppress(OSError):
            part.unlink(missing_ok=True)
        raise InputError(f"the scene cannot be written to {file}: {error.strerror}") from error
