"""Scenes as parts of other programs, and parts of scenes from other programs."""

from importlib import import_module
from types import ModuleType

MODULES = ("environment", "fmu", "gym", "urdf")


def __getattr__(name: str) -> ModuleType:
    """Load a module on first use: each needs another package."""
    if name not in MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return import_module(f"{__name__}.{name}")
