"""The command ``ancfsparse demo``, and its films in README.md."""

import re

import pytest
from PIL import Image

from ancfsparse.cli.demo import FILMS
from ancfsparse.problems.named import MECHANISMS
from tests.cli.command import run
from tests.paths import ROOT

README = (ROOT / "README.md").read_text(encoding="utf-8")
MOST_BYTES = 300_000


def test_it_writes_a_film_and_compares_with_the_reference(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    code, out, err = run(capsys, "demo", "double_pendulum_bob", "--fps", "5", "--dpi", "30")
    assert (code, err) == (0, "")
    with Image.open("double_pendulum_bob.gif") as film:
        assert film.n_frames == 15
    at_end, reference = (re.search(rf"{word}.*?: ([-\d.]+), ([-\d.]+) ", out).groups() for word in (
        "bob at 1 s", "reference"))  # fmt: skip
    value = MECHANISMS["double_pendulum_bob"].value
    for one, other, exact in zip(at_end, reference, value, strict=True):
        assert float(one) == pytest.approx(exact, abs=1e-3)
        assert float(other) == pytest.approx(exact, rel=1e-4)
    # What it proposes next works.
    words = re.findall(
        r"^next: ancfsparse (demo \w+)|^ +ancfsparse ((?:new|run) .*?)(?:  |$)", out, re.M
    )
    assert len(words) == 3
    assert words[0][0].split()[1] in FILMS
    for _, command in words[1:]:
        assert (
            run(capsys, *command.split(), *(["--time", "0.02"] * command.startswith("run")))[0] == 0
        )


def test_an_unknown_scene_and_a_file_of_another_kind_are_refused(capsys):
    code, _, err = run(capsys, "demo", "serpentin")
    assert code == 2
    assert "unknown scene" in err
    code, _, err = run(capsys, "demo", "knot", "knot.png")
    assert code == 2
    assert ".gif" in err


def test_the_readme_shows_its_films_with_their_commands():
    pairs = re.findall(r"\(docs/gallery/demo-(\w+)\.gif\)<br>`ancfsparse demo ?(\w*)`", README)
    assert sorted(name for name, _ in pairs) == sorted(FILMS)
    assert all(command in (name, "") for name, command in pairs)
    for name in FILMS:
        assert (ROOT / f"docs/gallery/demo-{name}.gif").stat().st_size < MOST_BYTES
