"""Compilation of kernel modules for user elements and for measurements.

Needs Cython and a C compiler; deriving an element needs SymPy too, in a separate process.
"""

from __future__ import annotations

import os
import subprocess
import sys
import sysconfig
import tempfile
from collections.abc import Sequence
from pathlib import Path

from ancfsparse.dispatch import instruction_set
from ancfsparse.errors import InputError
from ancfsparse.instruction_sets import REQUIRED_FLAGS

HEADERS = Path(__file__).parent
PACKAGE = HEADERS.parent
FLAGS = (  # those of kernels in meson.build
    *("-O2", "-fno-tree-vectorize", "-fno-tree-pre", "-fno-code-hoisting"),
    *("-ffp-contract=fast", "-fno-math-errno", "-shared", "-fPIC"),
    # The linker of macOS, unlike others, refuses names that Python defines later.
    *(("-undefined", "dynamic_lookup") if sys.platform == "darwin" else ()),
)
ARCHITECTURE_FLAGS = {
    name: "-march="
    + name.replace("x86_64", "x86-64").replace("_v", "-v").replace("aarch64", "armv8-a")
    for name in REQUIRED_FLAGS
}

OPENING = '''\
"""Element {name}, built by `ancfsparse element` from {source}."""

from ancfsparse.kernels.element_kind import external_element

ELEMENT = external_element(__name__)
'''


def build_element(
    source: str | Path, folder: str | Path = ".", instruction_sets: Sequence[str] = ()
) -> Path:
    """Derive the kernels of an element from its energy and compile them to a package.

    Parameters
    ----------
    source : str or Path
        A Python file with an ``ELEMENT = Element(...)`` made with ``codegen.declarations``.
    folder : str or Path, optional
        Parent folder of the package, which has the name of the element.
    instruction_sets : sequence of str, optional
        Instruction sets to compile for; by default the one in use on this machine.

    Returns
    -------
    Path
        The package.  `Scene.add_beam` takes its ``ELEMENT``, once `folder` is on the import path
        of Python.

    Raises
    ------
    InputError
        If the file has no such element, or a required tool is not installed.
    """
    for each in instruction_sets:
        if each not in ARCHITECTURE_FLAGS:
            raise InputError(
                f"{each!r} is not one of the instruction sets {', '.join(ARCHITECTURE_FLAGS)}"
            )
    with tempfile.TemporaryDirectory() as work:
        module = _derive(Path(source), Path(work))
        package = Path(folder) / module.stem
        package.mkdir(parents=True, exist_ok=True)
        text = translate(module, module.stem)
        for each in instruction_sets or (instruction_set(),):
            name = f"{module.stem}_{each}"
            library = package / f"{name}{sysconfig.get_config_var('EXT_SUFFIX')}"
            started = f"-DPyInit_{module.stem}=PyInit_{name}"
            compile_c(text, library, ARCHITECTURE_FLAGS[each], started)
        (package / module.name).write_bytes(module.read_bytes())
        opening = OPENING.format(name=module.stem, source=Path(source).name)
        (package / "__init__.py").write_text(opening, encoding="utf-8")
    return package


def translate(module: Path, name: str) -> Path:
    """Translate a module to C in the same folder.

    Parameters
    ----------
    module : Path
        The ``.pyx`` file.
    name : str
        Its name in imports.
    """
    target = module.with_suffix(".c")
    command = [sys.executable, "-m", "cython", "-3", "--module-name", name, str(module)]
    _run([*command, "-o", str(target)], "Cython")
    return target


def compile_c(source: Path, library: Path, *options: str) -> None:
    """Compile a translated module with the options of this package and others."""
    include = [f"-I{HEADERS}", f"-I{sysconfig.get_paths()['include']}"]
    compiler = os.environ.get("CC", "cc").split()
    unfinished = library.with_name(library.name + ".part")
    _run(
        [*compiler, *FLAGS, *options, *include, str(source), "-o", str(unfinished), "-lm"],
        "the C compiler",
    )
    unfinished.replace(library)  # a process that has loaded the old file keeps it


def _derive(source: Path, folder: Path) -> Path:
    """Write the module of an element by the generator, which this package does not import."""
    if not source.is_file():
        raise InputError(f"there is no file {source} with the energy of an element")
    folders = PACKAGE / "generator", PACKAGE.parent  # installed, or in a checkout
    present = [each for each in folders if (each / "codegen" / "derive.py").is_file()]
    if not present:
        raise InputError(f"the generator of kernels is missing: it is not in {folders[0]}")
    paths = [str(present[0]), os.environ.get("PYTHONPATH", "")]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, paths))}
    # -P: files in the working directory do not shadow the generator.
    command = [sys.executable, "-P", "-m", "codegen", "--element", str(source)]
    out = _run(
        [*command, "--folder", str(folder)],
        "the generator",
        environment,
    )
    return Path(out.strip().splitlines()[-1])


def _run(command: Sequence[str], what: str, environment: dict[str, str] | None = None) -> str:
    """Run a command and return its output, or raise an error with its message."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, env=environment)
    except OSError as failure:
        raise InputError(f"{what} cannot be run: {failure}") from None
    if not done.returncode:
        return done.stdout
    reason = done.stderr.strip() or done.stdout.strip()
    if "No module named" in reason:
        reason = reason.splitlines()[-1] + ': install it with pip install "ancfsparse[codegen]"'
    raise InputError(f"{what} refused: {reason}")
