"""Run the examples and commands of README.md as they stand, in order, in an empty folder.

What needs an optional package that is not installed is left out and named.
"""

import importlib.util
import os
import re
import shlex
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
BLOCK = re.compile(r"^```(python|sh)\n(.*?)^```", re.DOTALL | re.MULTILINE)
DEMO = re.compile(r"<br>`(ancfsparse demo [^`]*)`")
OPTIONAL = {"extra `view`": "pyvista", "extra `data`": "pandas", "extra `gltf`": "pygltflib"}
"""Comments of lines, and their packages."""
STOPPED = "# stop it"  # comment of a command that is interrupted after its first checkpoint
MAX_SECONDS = 120.0  # until there is a checkpoint


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


def run_command(line: str) -> None:
    """Run a command of the page, and interrupt it if its comment says so."""
    start = time.perf_counter()
    program, *arguments = shlex.split(line, comments=True)
    path = Path(sys.executable).parent / program
    words = [str(path), *arguments]
    if not path.exists():  # a checkout that is not installed
        words = [sys.executable, "-c", "from ancfsparse.cli import main; main()", *arguments]
    if STOPPED in line:
        interrupt(words)
    else:
        subprocess.run(words, check=True, stdout=subprocess.DEVNULL)
    print(f"{time.perf_counter() - start:6.1f} s: {' '.join(line.split())}", flush=True)


def _heed_interrupts() -> None:
    """Let an interruption end this process, which shells ignore in background processes."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)


def interrupt(words: list[str]) -> None:
    """Interrupt a run after it has written its first checkpoint."""
    process = subprocess.Popen(
        words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, preexec_fn=_heed_interrupts
    )
    start = time.perf_counter()
    while not list(Path().glob("*.checkpoint")):
        if process.poll() is not None or time.perf_counter() - start > MAX_SECONDS:
            process.kill()
            raise RuntimeError(f"no checkpoint was written by {' '.join(words)}")
        time.sleep(0.01)
    process.send_signal(signal.SIGINT)
    if process.wait() == 0:
        raise RuntimeError(f"it ended before it was interrupted: {' '.join(words)}")


def main() -> None:
    """Run all examples and commands; an error ends it."""
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    blocks, films = BLOCK.findall(page), DEMO.findall(page)
    if not films or {kind for kind, _ in blocks} != {"python", "sh"}:
        raise ValueError("README.md has no films, no examples of Python or none of the shell")
    names: dict[str, object] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        for number, (kind, block) in enumerate(blocks, 1):
            if kind == "sh":
                for line in re.findall(r"^ancfsparse .*", block, re.MULTILINE):
                    run_command(line)
                continue
            start = time.perf_counter()
            code = compile(without_missing_extras(block), f"README.md, example {number}", "exec")
            exec(code, names)
            print(f"{time.perf_counter() - start:6.1f} s: example {number}", flush=True)
        for command in films:
            run_command(f"{command} --fps 2")
        os.chdir(ROOT)


if __name__ == "__main__":
    main()
