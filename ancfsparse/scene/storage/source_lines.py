"""Lines of keys in the text of a TOML or JSON file, for messages."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterator, Sequence

HEADER = re.compile(r"\s*\[([^\[\]]+)\]\s*(?:#.*)?")
TOKEN = re.compile(r'"(?:[^"\\]|\\.)*"|[{}\[\],:\n]')


def line_of(text: str, keys: Sequence[str], is_toml: bool) -> int | None:
    """Return the line of a value, from 1; of the innermost table that is found.

    Parameters
    ----------
    text : str
        The text of the file.
    keys : sequence of str
        The keys that lead to the value, such as ``("parts", "rope", "start")``.
    is_toml : bool
        Whether it is TOML, else JSON.

    Returns
    -------
    int or None
        The line; None if not even the first key is found.
    """
    best, best_line = 0, None
    for line, path in _toml_keys(text) if is_toml else _json_keys(text):
        common = 0
        while common < min(len(path), len(keys)) and path[common] == keys[common]:
            common += 1
        if common > best:
            best, best_line = common, line
    return best_line


def _toml_keys(text: str) -> Iterator[tuple[int, tuple[str, ...]]]:
    """Return the line and the keys of each header and each assignment at the begin of a line."""
    table: tuple[str, ...] = ()
    for number, line in enumerate(text.splitlines(), 1):
        if header := HEADER.fullmatch(line):
            table = _split(header[1])
            yield number, table
        elif "=" in line and (inner := _split(line.partition("=")[0])):
            keys = (*table, *inner)
            yield number, keys
            for inside in re.finditer(r"[{,]\s*([\w-]+)\s*=", line):
                yield number, (*keys, inside[1])


def _split(key: str) -> tuple[str, ...]:
    """Return the keys of a dotted key, none if it is not valid."""
    try:
        data = tomllib.loads(f"{key} = 0")
    except tomllib.TOMLDecodeError:
        return ()
    keys: list[str] = []
    while isinstance(data, dict) and data:  # a comment has none
        name, data = next(iter(data.items()))
        keys.append(name)
    return tuple(keys)


def _json_keys(text: str) -> Iterator[tuple[int, tuple[str, ...]]]:
    """Return the line and the keys of each member of an object."""
    keys: list[str] = []
    number, last = 1, ""
    for token in TOKEN.findall(text):
        if token == "\n":
            number += 1
        elif token == ":":
            keys[-1:] = [last]
            yield number, tuple(each for each in keys if each)
        elif token in "{[":
            keys.append("")
        elif token in "}]":
            keys = keys[:-1]
        elif token != ",":
            try:
                last = json.loads(token)
            except ValueError:
                last = token
