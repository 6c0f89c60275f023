"""Cython sees the structures of C headers as the headers have them, field by field."""

import re

import pytest

from tests.paths import ROOT
from tests.system.contributions import winch

ROOM = ROOT / "ancfsparse"
HEADERS = {path.name: path for path in ROOM.rglob("*.h")}
NAME = r"[A-Za-z_]\w*"
QUALIFIERS = re.compile(
    r"\b(static|inline|struct|enum|noexcept|nogil|restrict|IC_INLINE|LDL_INLINE)\b"
)


def plain(text):
    """Leave out comments and what differs between both languages without a meaning."""
    text = re.sub(r"/\*.*?\*/", " ", text, flags=re.S)
    text = re.sub(r"#.*", "", text)
    return re.sub(r"\bbint\b", "int", QUALIFIERS.sub(" ", text))


def kind_of(text):
    """Return a type without spaces: ``const double *`` and ``const double*`` are one."""
    return re.sub(r"\s+", " ", text.replace("*", " * ")).strip()


def parameters(text):
    """Return the types of parameters, which may have names."""
    found = []
    for each in filter(None, (part.strip() for part in text.split(","))):
        each = re.sub(rf"\b{NAME}\s*(\[[^]]*\])", r"*", each)  # x[3] is a pointer to its first
        words = kind_of(each).split()
        named = len(words) > 1 and re.fullmatch(NAME, words[-1]) and words[-1] not in TYPES
        found.append(" ".join(words[:-1] if named and words[:-1] != ["const"] else words))
    return tuple(found)


TYPES = {"void", "int", "double", "float", "char", "short", "ptrdiff_t", "int32_t", "int64_t"}


def members(text):
    """Return the types of fields by name; of functions the result and the parameters."""
    found = {}
    for each in filter(None, (re.sub(r"\s+", " ", part).strip() for part in text.split(";"))):
        call = re.fullmatch(rf"(.*?)\(\s*\*\s*({NAME})\s*\)\s*\((.*)\)", each)
        if call:
            found[call[2]] = kind_of(call[1]), parameters(call[3])
            continue
        first, *others = each.split(",")
        size, head = re.search(r"(\[.*\])?$", first)[0], re.sub(r"\s*\[.*\]$", "", first)
        stars = re.fullmatch(rf"(.*?)([\s*]*)({NAME})", head)
        base = stars[1]
        for text_of in (stars[2] + stars[3] + size, *others):
            one = re.fullmatch(rf"([\s*]*)({NAME})\s*(\[.*\])?\s*", text_of)
            found[one[2]] = kind_of(base + one[1]) + (one[3] or "")
    return found


def structures(header):
    """Return the fields of every structure of a header."""
    text = plain(HEADERS[header].read_text(encoding="utf-8"))
    found = re.findall(rf"typedef\s*{{([^{{}}]*)}}\s*({NAME})\s*;", text)
    return {name: members(body) for body, name in found}


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
    assert len(shared) == 10
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


def test_the_contribution_in_python_has_the_fields_of_the_header():
    theirs = structures("system_abi.h")["ancf_contribution"]
    assert [name for name, *_ in winch._Interface._fields_] == list(theirs)
    state = structures("solver_abi.h")["ancf_state"]
    assert [name for name, *_ in winch._State._fields_] == list(state)
