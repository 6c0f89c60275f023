"""The tool that changes code in wrong ways: what it counts as caught; it puts files back."""

import signal
import subprocess
import sys
import time

import pytest

from tests.paths import ROOT
from tools import mutants

TOOLS = ROOT / "tools"

ENTRY = """
[[mutant]]
file = "doubled.py"
old = {old!r}
new = {new!r}
tests = ["{tests}"]
{more}
"""


@pytest.fixture
def run(tmp_path, capsys):
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


@pytest.mark.parametrize(
    ("change", "options", "code", "words"),
    [
        (("2 * x", "3 * x"), {}, 0, ("caught ", "caught 1 of 1: 100 %")),
        (("unused = 1", "unused = 2"), {}, 1, ("SURVIVED ", "caught 0 of 1: 0 %")),
        (("unused = 1", "unused = 2"), {"more": 'equivalent = "nothing reads it"'}, 0,
         ("(nothing reads it)", "caught 0 of 0: none; 1 without effect")),
        # A text that is not there once.
        (("4 * x", "5 * x"), {}, 1, ("STALE ",)),
        (("x", "y"), {}, 1, ("STALE ",)),
        (("2 * x", "2 * x"), {}, 1, ("STALE ",)),
        (("2 * x", "3 * x"), {"tests": "test_nothing.py"}, 1, ("BROKEN ",)),
    ],
)  # fmt: skip
def test_what_becomes_of_a_mutant_is_printed(run, change, options, code, words):
    status, shown = run(*change, **options)
    assert status == code
    assert all(each in shown for each in words)


def test_the_list_is_read():
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
        until = time.monotonic() + 300.0
        while (tmp_path / "doubled.py").read_text() == code and time.monotonic() < until:
            time.sleep(0.05)
        assert (tmp_path / "doubled.py").read_text() != code
        run.terminate()
    assert run.returncode == 128 + signal.SIGTERM
    assert (tmp_path / "doubled.py").read_text() == code
