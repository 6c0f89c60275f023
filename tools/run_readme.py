"""Run the examples of README.md as they stand, in order, in an empty folder.

What needs an optional package that is not installed is left out and named.
"""

import importlib.util
import os
import re
import shlex
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"^```python\n(.*?)^```", re.DOTALL | re.MULTILINE)
COMMAND = re.compile(r"`\.venv/bin/(ancfsparse [^`]*)`")
OPTIONAL = {"extra `view`": "pyvista", "extra `data`": "pandas"}  # comment of a line, its package


def without_missing_extras(block: str) -> str:
    """Return an example without the lines that need a package that is not installed."""
    lines = []
    for line in block.splitlines():
        missing = [
            package for comment, package in OPTIONAL.items()
            if comment in line and importlib.util.find_spec(package) is None
        ]  # fmt: skip
        if missing:
            print(f"left out without {missing[0]}: {line.strip()}", flush=True)
        else:
            lines.append(line)
    return "\n".join(lines)


def main() -> None:
    """Run all examples; an error ends it."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks, commands = BLOCK.findall(page), COMMAND.findall(page)
    if not blocks or not commands:
        raise ValueError("README.md has no examples of Python or none of the shell")
    names: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for number, block in enumerate(blocks, 1):
            start = time.perf_counter()
            code = compile(without_missing_extras(block), f"README.md, example {number}", "exec")
            exec(code, names)
            print(f"example {number} ran in {time.perf_counter() - start:.1f} s", flush=True)
        for command in commands:
            program, *arguments = shlex.split(command)
            path = Path(sys.executable).parent / program
            subprocess.run([path, *arguments], check=True, stdout=subprocess.DEVNULL)
            print(f"{command} ran", flush=True)
        os.chdir(ROOT)


if __name__ == "__main__":
    main()
