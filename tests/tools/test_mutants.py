"""The tool that changes code in wrong ways: what it counts as caught; it puts files back."""

import importlib.util
import signal
import subprocess
import sys
import time

import pytest

from tests.paths import ROOT

TOOLS = ROOT / "tools"

ENTRY = """
[[mutant]]
file = "doubled.py"
old = {old!r}
new = {new!r}
tests = ["{tests}"]
{more}
"""


@pytest.fixture(scope="module")
def mutants():
    spec = importlib.util.spec_from_file_location("mutants", TOOLS / "mutants.py")
    module = sys.modules["mutants"] = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    yield module
    del sys.modules["mutants"]


@pytest.fixture
def run(mutants, tmp_path, capsys):
    code = "def double(x):\n    unused = 1\n    return 2 * x\n"
    (tmp_path / "doubled.py").write_text(code)
    (tmp_path / "test_doubled.py").write_text(
        "from doubled import double\n\n\ndef test_double():\n    assert double(3) == 6\n"
    )

    def run(old, new, tests="test_doubled.py", more=""):
        entry = ENTRY.format(old=old, new=new, tests=tests, more=more)
        (tmp_path / "list.toml").write_text(entry)
        status = mutants.main(["--list", str(tmp_path / "list.toml"), "--root", str(tmp_path)])
        assert (tmp_path / "doubled.py").read_text() == code
        return status, capsys.readouterr().out

    return run


def test_a_mutant_whose_test_fails_is_caught(run):
    status, shown = run("2 * x", "3 * x")
    assert (status, shown.split()[0]) == (0, "caught")
    assert "caught 1 of 1: 100 %" in shown


def test_a_mutant_whose_tests_pass_survives(run):
    status, shown = run("unused = 1", "unused = 2")
    assert (status, shown.split()[0]) == (1, "SURVIVED")
    assert "caught 0 of 1: 0 %" in shown


def test_one_without_effect_is_explained_and_not_counted(run):
    status, shown = run("unused = 1", "unused = 2", more='equivalent = "nothing reads it"')
    assert (status, "(nothing reads it)" in shown) == (0, True)
    assert "caught 0 of 0: none; 1 without effect" in shown


@pytest.mark.parametrize(("old", "new"), [("4 * x", "5 * x"), ("x", "y"), ("2 * x", "2 * x")])
def test_a_text_that_is_not_there_once_is_reported(run, old, new):
    status, shown = run(old, new)
    assert (status, shown.split()[0]) == (1, "STALE")


def test_tests_that_do_not_exist_catch_nothing(run):
    status, shown = run("2 * x", "3 * x", tests="test_nothing.py")
    assert (status, shown.split()[0]) == (1, "BROKEN")


def test_the_list_is_read(mutants):
    listed = mutants.read()
    assert len(listed) >= 40
    texts = {each.file: (TOOLS.parent / each.file).read_text(encoding="utf-8") for each in listed}
    assert not [str(each) for each in listed if texts[each.file].count(each.old) != 1]


def test_a_run_that_is_ended_puts_the_file_back(tmp_path):
    code = "def slow():\n    return 60\n"
    (tmp_path / "doubled.py").write_text(code)
    (tmp_path / "test_doubled.py").write_text(
        "import time\n\ndef test_slow():\n    time.sleep(60)\n"
    )
    entry = ENTRY.format(old="60", new="61", tests="test_doubled.py", more="")
    (tmp_path / "list.toml").write_text(entry)
    paths = ["--list", str(tmp_path / "list.toml"), "--root", str(tmp_path)]
    with subprocess.Popen([sys.executable, str(TOOLS / "mutants.py"), *paths]) as run:
        until = time.monotonic() + 60.0
        while (tmp_path / "doubled.py").read_text() == code and time.monotonic() < until:
            time.sleep(0.05)
        assert (tmp_path / "doubled.py").read_text() != code
        run.terminate()
    assert run.returncode == 128 + signal.SIGTERM
    assert (tmp_path / "doubled.py").read_text() == code
