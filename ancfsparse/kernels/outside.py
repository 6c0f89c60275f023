"""Elements that are built outside this package, from a file with their energy."""

from __future__ import annotations

from functools import cache
from importlib import import_module

from ancfsparse.dispatch import instruction_set
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import ElementKind, from_module
from ancfsparse.openmp import brief_waits


@cache
def built(package: str) -> ElementKind:
    """Return the element of a package that ``ancfsparse element`` has built.

    Parameters
    ----------
    package : str
        Name of the package, as it is imported; its ``ELEMENT`` is the value of this function.

    Raises
    ------
    InputError
        If it cannot be imported, or was not built for this machine or this version.
    """
    name = package.rpartition(".")[2]
    module = f"{package}.{name}_{instruction_set()}"
    try:
        with brief_waits():
            found = import_module(module)
    except ModuleNotFoundError as missing:
        if missing.name == module:
            raise InputError(
                f"element {name} was not built for instruction set {instruction_set()} and this "
                "Python: build it again with `ancfsparse element`, on this machine or with "
                f"--instruction-set {instruction_set()}"
            ) from None
        raise InputError(
            f"element {name} is in the package {package}, which cannot be imported here: put the "
            "folder that contains it into PYTHONPATH, or build it again with `ancfsparse element`"
        ) from None
    return from_module(found, package)
