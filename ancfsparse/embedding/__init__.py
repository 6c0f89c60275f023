"""Scenes as parts of other programs: environments of Gymnasium."""

from importlib import import_module
from types import ModuleType

MODULES = ("gym",)


def __getattr__(name: str) -> ModuleType:
    """Load a module on first use: each needs another package."""
    if name not in MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module(f"{__name__}.{name}")
