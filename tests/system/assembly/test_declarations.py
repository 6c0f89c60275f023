"""Cython sees the structures of C headers as the headers have them, field by field."""

import re

import pytest

from tests.headers import HEADERS, NAME, ROOM, members, plain, structures


def blocks():
    """Return every ``cdef extern from`` of a header of ours: file, header, lines below."""
    for path in sorted([*ROOM.rglob("*.pyx"), *ROOM.rglob("*.pxi")]):
        lines = path.read_text(encoding="utf-8").splitlines()
        for k, line in enumerate(lines):
            header = re.match(r'cdef extern from "([^"]+)"', line)
            if header and header[1] in HEADERS:
                end = k + 1
                while end < len(lines) and (not lines[end] or lines[end].startswith(" ")):
                    end += 1
                yield path, header[1], lines[k + 1 : end]


def declared(lines):
    """Return the structures of a block of Cython, which ends a line where C has a semicolon."""
    joined, depth = [], 0
    for line in lines:
        if depth:
            joined[-1] += " " + line.strip()
        elif line.strip():
            joined.append(line)
        depth += line.count("(") - line.count(")")
    found, inside = {}, None
    for line in map(plain, joined):
        opened = re.match(rf"    ctypedef\s+({NAME})\s*:", line)
        if opened:
            inside = found.setdefault(opened[1], {})
        elif not line.startswith("     "):
            inside = None
        elif inside is not None:
            inside |= members(line.strip())
    return found


BLOCKS = [block for block in blocks() if declared(block[2])]


@pytest.mark.parametrize(
    ("path", "header", "lines"), BLOCKS, ids=[f"{b[0].name}-{b[1]}" for b in BLOCKS]
)
def test_declarations_are_those_of_the_header(path, header, lines):
    theirs = structures(header)
    for name, fields in declared(lines).items():
        if path.parent.name == "abi":
            assert list(fields) == list(theirs[name]), name
        for field, kind in fields.items():
            assert kind == theirs[name][field], f"{name}.{field}"


def test_every_structure_that_modules_share_is_declared():
    seen = {name for _, _, lines in BLOCKS for name in declared(lines)}
    headers = "solver_abi.h", "system_abi.h", "energy_watch.h"
    shared = [name for header in headers for name in structures(header)]
    assert len(shared) == 11
    assert set(shared) <= seen


def test_a_wrong_declaration_is_noticed():
    _, header, lines = next(block for block in BLOCKS if block[1] == "system_abi.h")
    right = structures(header)["ancf_contribution"]
    for old, new in (("double *memory", "float *memory"), ("int damped", "double damped")):
        wrong = declared([line.replace(old, new) for line in lines])["ancf_contribution"]
        assert wrong != right
    without = declared([line for line in lines if "n_memory" not in line])["ancf_contribution"]
    assert without != right
    assert declared(lines)["ancf_contribution"] == right
