"""The gallery shows every named scene, by examples that run as they stand."""

import re
import subprocess
import sys

import ancfsparse.problems
from tests.paths import ROOT

PAGE = (ROOT / "docs/gallery.md").read_text(encoding="utf-8")
MOST_BYTES = 300_000


def test_every_named_scene_is_there():
    scenes = [name for name in ancfsparse.problems.__all__ if name.islower()]
    assert len(scenes) > 6
    for name in scenes:
        assert re.search(rf"= {name}\(", PAGE), name


def test_its_pictures_are_those_of_its_examples_and_small():
    shown = set(re.findall(r"\]\(gallery/(.*?)\)", PAGE))
    written = set(re.findall(r'(?:savefig|animate)\("(.*?)"', PAGE))
    assert shown == written
    for name in shown:
        assert (ROOT / "docs/gallery" / name).stat().st_size < MOST_BYTES


def test_an_example_draws_its_picture(tmp_path):
    command = [sys.executable, "tools/gallery.py", "cantilever", "--to", str(tmp_path)]
    subprocess.run(command, cwd=ROOT, check=True, capture_output=True)
    assert [file.name for file in tmp_path.iterdir()] == ["cantilever.png"]
