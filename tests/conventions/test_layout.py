"""Folders are small, and imports flow one way: no circle of files or of folders."""

import ast
from collections import Counter
from functools import cache
from graphlib import CycleError, TopologicalSorter

import pytest

from tests.paths import ROOT

PACKAGES = ("ancfsparse", "benchmarks", "codegen")
MAX_FILES = 12  # files of a folder besides __init__.py
SOURCES = {".c", ".h", ".pxi", ".py", ".pyx"}


def sources(folder):
    return [f for f in folder.rglob("*") if f.suffix in SOURCES and f.name != "__init__.py"]


def module_name(file):
    return ".".join(file.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


MODULES = {module_name(f): f for name in PACKAGES for f in sorted((ROOT / name).rglob("*.py"))}


@cache
def parsed(module):
    return ast.parse(MODULES[module].read_text(encoding="utf-8"))


@cache
def defining_module(module, name):
    """Return the module that defines a name which `module` has, through the faces of packages."""
    if f"{module}.{name}" in MODULES and name not in exports(module):
        return f"{module}.{name}"
    if MODULES[module].name == "__init__.py" and name in exports(module):
        return defining_module(exports(module)[name], name)
    return module


@cache
def exports(module):
    """Return the names that the face of a package imports, with the modules they come from."""
    if MODULES[module].name != "__init__.py":
        return {}
    return {
        alias.asname or alias.name: node.module
        for node in ast.walk(parsed(module))
        if isinstance(node, ast.ImportFrom) and node.module in MODULES
        for alias in node.names
    }


def imported(module):
    """Return the modules that this one imports: at its top, in functions, and for types."""
    found = set()
    for node in ast.walk(parsed(module)):
        if isinstance(node, ast.ImportFrom) and node.module in MODULES:
            found |= {defining_module(node.module, alias.name) for alias in node.names}
        elif isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names if alias.name in MODULES}
    return found - {module}


def folder_of(module):
    file = MODULES[module]
    return ".".join(file.parent.relative_to(ROOT).parts)


@cache  # not when tests are collected, which each process does
def imports_of_files():
    return {m: imported(m) for m, f in MODULES.items() if f.name != "__init__.py"}


def circle(graph):
    """Return a circle of a graph of imports, or None."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return error.args[1]
    return None


def test_no_circle_of_files():
    assert circle(imports_of_files()) is None


def test_no_circle_of_folders():
    # A folder with the face of its room, such as scene/ with scene.py, is above its subfolders.
    folders = {}
    for module, targets in imports_of_files().items():
        here = folder_of(module)
        folders.setdefault(here, set()).update({folder_of(t) for t in targets} - {here})
    assert circle(folders) is None


def test_a_circle_is_found():
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"a"}}) is not None
    assert circle({"a": {"b", "c"}, "b": {"c"}}) is None


@pytest.mark.parametrize("package", [*PACKAGES, "tests"])
def test_folders_hold_at_most_a_dozen_files(package):
    counts = Counter(str(f.parent.relative_to(ROOT)) for f in sources(ROOT / package))
    assert not {folder: n for folder, n in counts.items() if n > MAX_FILES}


def in_functions(module):
    """Return the lines of a module on which a function imports this package."""
    return [
        inner.lineno
        for node in ast.walk(parsed(module))
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef)
        for inner in ast.walk(node)
        if (isinstance(inner, ast.ImportFrom) and (inner.module or "").split(".")[0] in PACKAGES)
        or (isinstance(inner, ast.Import) and inner.names[0].name.split(".")[0] in PACKAGES)
    ]


def test_no_function_imports_the_package():
    found = {m: lines for m in MODULES if (lines := in_functions(m))}
    assert not found
