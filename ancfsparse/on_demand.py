"""Names of a package that are loaded on first use, to keep short runs fast."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping
from importlib import import_module


def on_demand(package: str, modules: Mapping[str, str]) -> Callable[[str], object]:
    """Return the ``__getattr__`` of a package that loads some of its names on first use.

    Parameters
    ----------
    package : str
        Its ``__name__``.
    modules : mapping of str to str
        For each name the module that defines it, relative to the package. A name must differ from
        those of the modules in the package, which Python binds to the same attributes.
    """

    def load(name: str) -> object:
        if name not in modules:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f"{package}.{modules[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    return load
