"""C functions of a user, in a capsule or a `scipy.LowLevelCallable`."""

from __future__ import annotations

import ctypes as ct
from typing import Any

from ancfsparse.errors import InputError
from ancfsparse.scene.records.picklable_functions import MissingFunction, picklable

# Names of integers as wide as a pointer.
LONG_NAMES = ("ptrdiff_t", "ssize_t", "Py_ssize_t", "longlong")

_capsule_name = ct.pythonapi.PyCapsule_GetName
_capsule_name.restype, _capsule_name.argtypes = ct.c_char_p, [ct.py_object]


def get_capsule(value: object) -> Any:
    """Return the capsule of a `scipy.LowLevelCallable`, or a capsule itself; else None.

    Its name is the signature of the function, its context the ``void *`` argument.
    """
    if type(value).__name__ == "LowLevelCallable" and isinstance(value, tuple):
        value = tuple.__getitem__(value, 0)
    return value if type(value).__name__ == "PyCapsule" else None


def is_compiled(value: object) -> bool:
    """Return True for a C function in a capsule."""
    return get_capsule(value) is not None


def check_signature(what: str, value: object, *valid: str) -> str:
    """Return the one of the valid signatures that a C function has.

    Raises
    ------
    InputError
        If it has another signature.
    """
    signature = (_capsule_name(get_capsule(value)) or b"").decode()
    plain = "".join(signature.replace("const ", "").split())
    for name in LONG_NAMES:
        plain = plain.replace(name, "long")
    for choice in valid:
        if plain == "".join(choice.replace("ptrdiff_t", "long").split()):
            return choice
    raise InputError(
        f"{what} is a C function of the signature {signature!r}: it must be {' or '.join(valid)!r}"
    )


def picklable_callback(value: object, what: str) -> object:
    """Return a value in a form that can be pickled; a capsule is an address in this process."""
    return MissingFunction(what) if is_compiled(value) else picklable(value)
