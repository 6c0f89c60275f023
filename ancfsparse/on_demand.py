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
        For each module, relative to the package, the names that it defines, separated by spaces. A
        name must differ from those of the modules in the package, which Python binds to the same
        attributes.
    """
    module_of = {name: module for module, names in modules.items() for name in names.split()}

    def load(name: str) -> object:
        if name not in module_of:
            raise AttributeError(f"module {package!r} has no attribute {name!r}")
        value = getattr(import_module(f"{package}.{module_of[name]}"), name)
        setattr(sys.modules[package], name, value)
        return value

    return load
