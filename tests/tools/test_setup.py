"""Set-up by several processes at once, where nothing has changed, and where pip fails."""

import os
import shutil
import subprocess
import sys
import time
from pathlib import Path

import pytest

from tests.paths import ROOT

# In place of the interpreter of .venv: pip waits while a file `hold` is there, and fails where one
# called `fails` is.
PYTHON = f"""#!/bin/sh
if [ "$1 $2" = "-m pip" ]; then
  echo "begin $*" >>pip.txt
  while [ -e hold ]; do sleep 0.01; done
  if [ -e fails ]; then
    echo "WARNING: Location 'file:///here/' is ignored: it is neither a file nor a directory."
    echo "ERROR: no matching distribution"
    exit 1
  fi
  echo end >>pip.txt
else
  exec {sys.executable} "$@"
fi
"""

NINJA = """
rule build
  command = echo begin >>log; while [ -e hold ]; do sleep 0.01; done; cp $in $out; echo end >>log
build module: build source
"""


def executable(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A checkout with little in it, whose .venv has a pip that does nothing."""
    monkeypatch.delenv("ANCFSPARSE_WHEEL", raising=False)  # these tests may run on a given wheel
    for name in "setup.sh", "ninja_in_turn.sh":
        (tmp_path / "tools").mkdir(exist_ok=True)
        shutil.copy(ROOT / "tools" / name, tmp_path / "tools")
    for name in (
        "ancfsparse/code.pyx",
        "ancfsparse/code.py",
        "codegen/code.py",
        "generated/code.pyx",
        "vendored/code.c",
    ):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text("")
    for name in "pyproject.toml", "meson.build", "meson.options":
        shutil.copy(ROOT / name, tmp_path)
    executable(tmp_path / ".venv/bin/python", PYTHON)
    return tmp_path


def start(checkout, *arguments):
    command = [checkout / "tools/setup.sh", *arguments]
    environment = {**os.environ, "PYTHON": sys.executable}
    return subprocess.Popen(command, stderr=subprocess.PIPE, text=True, env=environment)


def wait_for(file):
    """Wait until another process has begun, which this file shows."""
    deadline = time.monotonic() + 300.0
    while not file.exists() and time.monotonic() < deadline:
        time.sleep(0.01)


def runs_of_pip(checkout):
    return (checkout / "pip.txt").read_text().splitlines()


def run(checkout, *arguments):
    """Set up; return the exit status and the lines printed."""
    process = start(checkout, *arguments)
    shown = process.communicate()[1].splitlines()
    return process.returncode, shown


def finish_in_turn(hold, begun, start):
    """Start a process, when it has begun another one, and let the first end; return their lines."""
    hold.write_text("")
    first = start()
    wait_for(begun)
    second = start()
    line = second.stderr.readline()
    hold.unlink()
    shown = [first.communicate()[1], line + second.communicate()[1]]
    assert [first.returncode, second.returncode] == [0, 0], shown
    return shown


def test_one_process_sets_up_and_another_waits_and_finds_it_done(checkout):
    first, second = finish_in_turn(checkout / "hold", checkout / "pip.txt", lambda: start(checkout))
    assert first.endswith("setup: done\n")
    assert second == "setup: waiting for another process that sets up here\n"
    # requirements, the wheel, its own requirements, and the wheel again where it was installed
    assert [line.split()[0] for line in runs_of_pip(checkout)] == ["begin", "end"] * 4


def test_nothing_is_done_where_nothing_has_changed(checkout):
    run(checkout)
    before = runs_of_pip(checkout)
    (checkout / "ancfsparse/code.pyx").touch()
    (checkout / "ancfsparse/__pycache__").mkdir()
    (checkout / "ancfsparse/__pycache__/code.pyc").write_text("compiled")
    assert run(checkout) == (0, [])
    assert runs_of_pip(checkout) == before


@pytest.mark.parametrize("name", ["ancfsparse/code.py", "generated/code.pyx", "ancfsparse/new.py"])
def test_a_change_of_a_source_builds_again_without_dependencies(checkout, name):
    run(checkout)
    before = len(runs_of_pip(checkout))
    (checkout / name).write_text("changed")
    assert run(checkout)[0] == 0
    build, _, install, _ = runs_of_pip(checkout)[before:]
    assert " wheel --no-deps" in build
    assert " install --no-deps --force-reinstall" in install


def test_a_given_wheel_is_installed_and_not_built(checkout, monkeypatch):
    monkeypatch.setenv("ANCFSPARSE_WHEEL", "elsewhere/ancfsparse.whl")
    assert run(checkout)[0] == 0
    runs = runs_of_pip(checkout)
    assert not any(" wheel " in line for line in runs)
    assert "elsewhere/ancfsparse.whl[dev]" in runs[2]


def test_stale_compiled_modules_are_named(checkout):
    assert run(checkout, "check")[0] == 1
    run(checkout)
    (checkout / "ancfsparse/code.py").write_text("changed")  # not compiled: Python here reads it
    assert run(checkout, "check") == (0, [])
    (checkout / "ancfsparse/code.pyx").write_text("changed")
    status, shown = run(checkout, "check")
    assert status == 1
    assert "older than their sources: run make setup" in shown[-1]


def test_an_editable_install_follows_the_sources_until_it_is_undone(checkout):
    run(checkout, "develop")
    assert " -e ." in runs_of_pip(checkout)[-2]
    before = runs_of_pip(checkout)
    (checkout / "ancfsparse/code.pyx").write_text("changed")
    assert run(checkout) == run(checkout, "check") == (0, [])
    assert runs_of_pip(checkout) == before
    run(checkout, "plain")
    assert " -e ." not in runs_of_pip(checkout)[-2]


def test_what_fails_is_shown_without_noise_and_the_last_line_says_what_to_do(checkout):
    (checkout / "fails").touch()
    status, shown = run(checkout)
    assert status == 1
    assert shown[-2] == "ERROR: no matching distribution"
    assert "is ignored" not in "".join(shown)
    assert shown[-1].startswith("setup: could not install what ancfsparse requires.")
    assert shown[-1].endswith("run the same make command again.")
    (checkout / "fails").unlink()
    assert run(checkout)[0] == 0


def test_unknown_arguments_are_refused(checkout):
    status, shown = run(checkout, "evrything")
    assert (status, len(shown)) == (1, 1)
    assert "unknown argument evrything" in shown[0]


def test_of_two_imports_one_compiles_and_the_other_waits(tmp_path):
    executable(tmp_path / "tools/ninja_in_turn.sh", (ROOT / "tools/ninja_in_turn.sh").read_text())
    (tmp_path / ".venv/bin").mkdir(parents=True)
    (tmp_path / ".venv/bin/ninja").symlink_to(Path(sys.executable).with_name("ninja"))
    (tmp_path / "build").mkdir()
    (tmp_path / "build/build.ninja").write_text(NINJA)
    (tmp_path / "build/source").write_text("")

    def start():
        # As meson-python does: what ninja prints goes to a log; only its parent has a terminal.
        code = (
            "import subprocess, sys; subprocess.run(sys.argv[1:], check=True, capture_output=True)"
        )
        command = [sys.executable, "-c", code, tmp_path / "tools/ninja_in_turn.sh"]
        return subprocess.Popen(command, cwd=tmp_path / "build", stderr=subprocess.PIPE, text=True)

    build = tmp_path / "build"
    first, second = finish_in_turn(build / "hold", build / "log", start)
    assert first.startswith("ancfsparse: compiling changed files in ")
    assert second.startswith("ancfsparse: waiting for another process that builds in ")
    assert (build / "log").read_text().split() == ["begin", "end"]
