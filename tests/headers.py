"""Structures of the C headers of the package: their fields as text, and for ctypes."""

import ctypes as ct
import re
from functools import cache

from tests.paths import ROOT

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


C_TYPES = {"void": None, "double": ct.c_double, "int": ct.c_int, "ptrdiff_t": ct.c_ssize_t}
_new_capsule = ct.pythonapi.PyCapsule_New
_new_capsule.restype = ct.py_object
_new_capsule.argtypes = [ct.c_void_p, ct.c_char_p, ct.c_void_p]


def c_type(kind):
    """Return the type of a field or a parameter for ctypes."""
    if isinstance(kind, tuple):
        return ct.CFUNCTYPE(*map(c_type, (kind[0], *kind[1])))
    target, is_pointer, _ = kind.removeprefix("const ").partition(" *")
    if not is_pointer:
        return C_TYPES[target]
    if target == "double":
        return ct.POINTER(ct.c_double)
    return ct.POINTER(c_structure(target)) if target == "ancf_state" else ct.c_void_p


@cache
def c_structure(name):
    """Return a structure of the interfaces between compiled parts for ctypes."""
    fields = (structures("solver_abi.h") | structures("system_abi.h"))[name]
    made = [(field, c_type(kind)) for field, kind in fields.items()]
    return type(name, (ct.Structure,), {"_fields_": made, "name": name.encode()})


def implement(name, **members):
    """Return such a structure of numbers and functions of Python, and a capsule of it.

    Functions that are None are left out.  The structure must outlive the capsule.
    """
    structure = c_structure(name)
    types = dict(structure._fields_)
    made = structure(**{
        member: types[member](value) if callable(value) else value
        for member, value in members.items()
        if value is not None
    })  # fmt: skip
    return made, _new_capsule(ct.addressof(made), structure.name, None)
