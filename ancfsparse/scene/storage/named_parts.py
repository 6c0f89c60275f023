"""Scenes of named parts, as users write them: a table of arguments for each call.

The names and types of arguments come from the methods of `Scene` that have a record, and from the
classes of data; their units come from the records, or from the docstrings.
"""

from __future__ import annotations

import itertools
import re
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cache
from inspect import Parameter, cleandoc, signature
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from ancfsparse.checks import check_choice
from ancfsparse.errors import AncfError, InputError
from ancfsparse.messages import format_value
from ancfsparse.scene.records.record import RECORD_TYPES, REFERENCE_TYPES
from ancfsparse.scene.records.signal import Signal
from ancfsparse.scene.records.signals import Table
from ancfsparse.scene.storage.handle_names import TYPES as HANDLES, find_handle, part_in
from ancfsparse.scene.storage.json_file import DATA, decoded
from ancfsparse.scene.storage.quantities import is_quantity, parse_quantity, parse_unit

PARAMETER = re.compile(r"(\w+(?:, \w+)*) : ")
IN_BRACKETS = re.compile(r"(?<!\bt )(?<!\bs )\[([^\]]+)\]")  # not those of arguments t and s
MAX_CSV_SIZE = 1e8  # bytes; 13 million numbers took 20 s to read, and 0.1 GB of memory


class KeyedError(InputError):
    """An error at a key of a file."""

    def __init__(self, text: str, keys: tuple[str, ...] = ()) -> None:
        super().__init__(text)
        self.args = text, keys
        self.keys = keys


class Argument(NamedTuple):
    """A parameter as files see it.

    Attributes
    ----------
    name : str
        Its name.
    words : frozenset of str
        The types in its annotation.
    units : tuple of str
        Units that it may have; none if it is not a number with a unit.
    required : bool
        Whether it has no default.
    """

    name: str
    words: frozenset[str]
    units: tuple[str, ...]
    required: bool


@dataclass
class Reader:
    """Reads arguments from the data of a file.

    Attributes
    ----------
    scene : Scene
        The scene that parts are added to.
    own : mapping of str to object
        Functions and elements of the user.
    folder : Path
        Folder of CSV files.
    kinds : mapping of str to type
        Classes of data by name.
    handles : dict of str to object
        The preceding parts.
    """

    scene: Any
    own: Mapping[str, Any]
    folder: Path
    kinds: Mapping[str, type[Any]] = field(default_factory=lambda: DATA)
    handles: dict[str, Any] = field(default_factory=dict)

    def add_part(self, name: str, entry: Any) -> None:
        """Call a method of the scene with the arguments of a table."""
        keys = ("parts", name)
        with locate_errors(keys):
            if not isinstance(entry, dict):
                raise InputError(
                    f"a part must be a table with a method and its arguments, got "
                    f"{format_value(entry)}"
                )
            if "method" not in entry:
                raise InputError('a part needs the name of a method, as in method = "pin"')
        with locate_errors((*keys, "method")):
            method = check_choice("method", entry["method"], RECORD_TYPES)
        rest = {key: value for key, value in entry.items() if key != "method"}
        call = getattr(type(self.scene), method)
        known = {each.name: each for each in arguments_of(call)}
        is_body = known.pop("name", None) is not None
        values = self.arguments(known, rest, keys, method)
        with locate_errors(keys, rest):
            self.handles[name] = call(self.scene, **values, **({"name": name} if is_body else {}))

    def arguments(
        self,
        known: Mapping[str, Argument],
        entry: Mapping[str, Any],
        keys: tuple[str, ...],
        what: str,
        outer: tuple[str, ...] = (),
    ) -> dict[str, Any]:
        """Return the arguments of a call or of a class of data.

        Parameters
        ----------
        known : mapping of str to Argument
            Its parameters.
        entry : mapping of str to object
            The data.
        keys : tuple of str
            The keys that lead there.
        what : str
            Its name.
        outer : tuple of str, optional
            Units of the argument that it is a part of, which its values have.
        """
        for name in entry:
            with locate_errors((*keys, name)):
                check_choice(f"argument of {what}", name, known)
        with locate_errors(keys):
            for each in known.values():
                if each.required and each.name not in entry:
                    raise InputError(f"{what} lacks {each.name}")
        values = {}
        for name, value in entry.items():
            argument = known[name]
            if outer and len(argument.units) != 1:
                argument = argument._replace(units=outer)
            values[name] = self.value(value, (*keys, name), argument)
        return values

    def value(self, value: Any, keys: tuple[str, ...], argument: Argument) -> Any:
        """Return an argument from its data."""
        if isinstance(value, list):
            return tuple(self.value(each, keys, argument) for each in value)
        if isinstance(value, dict):
            return self.data(value, keys, argument)
        if not isinstance(value, str):
            return value
        with locate_errors(keys):
            if argument.words & HANDLES and (
                part_in(value, self.handles) is not None or not is_quantity(value)
            ):
                return find_handle(value, self.handles)
            if "str" in argument.words:
                return value
            return parse_quantity(value, argument.units)

    def data(self, value: dict[str, Any], keys: tuple[str, ...], argument: Argument) -> Any:
        """Return an object from the table of its fields."""
        if "own" in value or "base64" in value:
            with locate_errors(keys):
                return decoded(value, self.own)
        kinds = [name for name in self.kinds if name in argument.words]
        kind = value.get("kind", kinds[0] if len(kinds) == 1 else None)
        if argument.words & HANDLES and isinstance(kind, str) and kind in REFERENCE_TYPES:
            with locate_errors(keys):
                return decoded(value, self.own).of(self.scene)
        with locate_errors((*keys, "kind") if "kind" in value else keys):
            if kind is None:
                raise InputError('a table needs its kind, as in kind = "Circle"')
            kind_of_data: Any = self.kinds[check_choice("kind", kind, self.kinds)]
        entry = {name: each for name, each in value.items() if name != "kind"}
        if "csv" in entry and issubclass(kind_of_data, Table):
            with locate_errors((*keys, "csv")):
                entry = self.read_csv(entry.pop("csv")) | entry
        outer = argument.units if issubclass(kind_of_data, Signal) else ()
        known = {each.name: each for each in arguments_of(kind_of_data)}
        values = self.arguments(known, entry, keys, kind, outer)
        with locate_errors(keys, entry):
            return kind_of_data(**values)

    def read_csv(self, name: Any) -> dict[str, Any]:
        """Return times and values of a CSV file: a column of times [s], and one or more of values.

        It may begin with a heading.
        """
        if not isinstance(name, str) or "\0" in name:
            raise InputError(f"a CSV file needs its name, got {format_value(name)}")
        file = self.folder / name
        if not file.is_file():
            raise InputError(f"{file} is not a file")
        if file.stat().st_size > MAX_CSV_SIZE:
            raise InputError(f"{file} has more than {MAX_CSV_SIZE / 1e6:.3g} MB")
        try:
            with file.open(encoding="utf-8") as lines, warnings.catch_warnings():
                warnings.simplefilter("ignore", UserWarning)  # a file without rows, see below
                first = lines.readline()
                has_heading = re.match(r"\s*[-+.\d]", first) is None
                rows = lines if has_heading else itertools.chain([first], lines)
                numbers = np.loadtxt(rows, delimiter=",", ndmin=2)
        except (OSError, ValueError) as error:
            raise InputError(f"{file} cannot be read: {error}") from error
        if numbers.shape[1] < 2:
            raise InputError(f"{file} needs rows of a time [s] and one value or more")
        values = numbers[:, 1] if numbers.shape[1] == 2 else numbers[:, 1:]
        return {"times": numbers[:, 0], "values": values}


@contextmanager
def locate_errors(keys: tuple[str, ...], entry: Mapping[str, Any] | None = None) -> Iterator[None]:
    """Add keys of a file to an error; the last is the argument of `entry` that it names."""
    try:
        yield
    except KeyedError:
        raise
    except AncfError as error:
        word = argument_named_by(error)
        raise KeyedError(str(error), (*keys, word) if word in (entry or ()) else keys) from error


def argument_named_by(error: AncfError) -> str:
    """Return the first word of a message, which is the argument if it names one."""
    named = getattr(error, "parameter", None) or str(error).removeprefix("unknown ")
    return str(named).split(" ", 1)[0]


@cache
def arguments_of(call: Any) -> tuple[Argument, ...]:
    """Return the parameters of a class, a function or a method of `Scene`."""
    record = RECORD_TYPES.get(call.__name__)
    units = documented_units(call)
    units |= {name: (unit,) for name, unit in record.units.items()} if record else {}
    return tuple(
        Argument(
            each.name,
            frozenset(re.findall(r"[A-Za-z]\w*", str(each.annotation))),
            units.get(each.name, ()),
            each.default is Parameter.empty,
        )
        for each in signature(call).parameters.values()
        if each.name != "self"
    )


def documented_units(call: Callable[..., Any]) -> dict[str, tuple[str, ...]]:
    """Return the units of parameters, in brackets in the docstring, such as ``"[N or N m]"``."""
    units = {}
    for name, text in descriptions_of(call).items():
        groups = [re.split(r", | or ", group) for group in IN_BRACKETS.findall(text)]
        units[name] = tuple(
            dict.fromkeys(each for group in groups for each in group if _is_unit(each))
        )
    return units


def descriptions_of(call: Callable[..., Any]) -> dict[str, str]:
    """Return the descriptions of parameters in the docstring."""
    lines: dict[str, list[str]] = {}
    names: list[str] = []
    for line in cleandoc(call.__doc__ or "").splitlines():
        if head := PARAMETER.match(line):
            names = head[1].split(", ")
        elif line and not line.startswith(" "):
            names = []
        else:
            for name in names:
                lines.setdefault(name, []).append(line.strip())
    return {name: " ".join(filter(None, words)) for name, words in lines.items()}


def _is_unit(text: str) -> bool:
    try:
        parse_unit(text)
    except InputError:
        return False
    return True
