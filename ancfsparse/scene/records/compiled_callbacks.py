"""C functions that a caller hands over in a capsule, as `scipy.LowLevelCallable` does."""

from __future__ import annotations

import ctypes as ct
from typing import Any

from ancfsparse.errors import InputError
from ancfsparse.scene.records.transferable_functions import Unsent, sendable

_name = ct.pythonapi.PyCapsule_GetName
_name.restype, _name.argtypes = ct.c_char_p, [ct.py_object]


def capsule_of(value: object) -> Any:
    """Return the capsule of a `scipy.LowLevelCallable`, or a capsule itself; else None.

    Its name is the signature of the function, its context what is passed as ``void *``.
    """
    if type(value).__name__ == "LowLevelCallable" and isinstance(value, tuple):
        value = tuple.__getitem__(value, 0)
    return value if type(value).__name__ == "PyCapsule" else None


def is_compiled(value: object) -> bool:
    """Whether a value is a C function in a capsule."""
    return capsule_of(value) is not None


def check_signature(what: str, value: object, *known: str) -> str:
    """Return the signature of a C function as one of those that are known.

    Raises
    ------
    InputError
        If it is neither of them.
    """
    name = _name(capsule_of(value))
    given = (name or b"").decode()
    plain = "".join(given.replace("const ", "").split())
    for word in ("ptrdiff_t", "ssize_t", "Py_ssize_t", "longlong"):
        plain = plain.replace(word, "long")
    for signature in known:
        if plain == "".join(signature.replace("ptrdiff_t", "long").split()):
            return signature
    raise InputError(
        f"{what} is a C function of the signature {given!r}: it must be {' or '.join(known)!r}"
    )


def sent(value: object, what: str) -> object:
    """Return a function as it may be pickled: one in a capsule is an address, of this process."""
    return Unsent(what) if is_compiled(value) else sendable(value)
