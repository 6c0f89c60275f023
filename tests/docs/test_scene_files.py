"""The files on the pages are scenes that run, and the messages on them are those of the command."""

import re

import pytest

import ancfsparse as ancf
from tests.cli.command import run
from tests.paths import ROOT

PAGE = (ROOT / "docs/scene-files.md").read_text(encoding="utf-8")
ROPE = re.search(r"```toml\n(.*?)```", PAGE, re.DOTALL)[1]
MESSAGES = re.search(r"## Errors.*?```\n(.*?)```", PAGE, re.DOTALL)[1].splitlines()


@pytest.fixture
def cable(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "cable.toml").write_text(ROPE, encoding="utf-8")
    return tmp_path / "cable.toml"


def test_the_cable_of_the_page_runs_and_rests_on_the_floor(cable, capsys):
    code, out, err = run(capsys, "run", cable, "-o", "run.h5")
    assert (code, err) == (0, "")
    assert "500 steps" in out
    result = ancf.load("run.h5")
    rope = result.system.scene.beams[0]
    heights = [result.position(rope.node(k))[-1, 1] for k in range(21)]
    assert min(heights) == pytest.approx(-0.295, abs=1e-3)  # floor and radius


def test_the_options_of_the_page_are_taken(cable, capsys):
    (words,) = re.findall(r"ancfsparse run cable.toml (--time .*)", PAGE)
    code, _, err = run(capsys, "run", cable, *words.replace("--time 2", "--time 0.1").split())
    assert (code, err) == (0, "")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        *zip(
            ('pin", node = "rope.start"', '"10 mm"', '"2 ms"'),
            ('pin", nod = "rope.start"', '"10 N"', '"3 ms"'),
            MESSAGES,
            strict=True,
        )
    ],
)
def test_messages_of_the_page_are_those_of_the_command(cable, capsys, old, new, message):
    assert old in ROPE
    cable.write_text(ROPE.replace(old, new), encoding="utf-8")
    code, _, err = run(capsys, "run", "cable.toml")
    assert code == 2
    assert err == f"ancfsparse: {message}\n"
