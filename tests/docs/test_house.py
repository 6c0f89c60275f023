"""What the repository says about itself is true."""

import importlib.metadata
import importlib.resources
import re
import subprocess

import pytest

import ancfsparse
from tests.paths import ROOT

PAPER = (
    "On the Numerical Treatment of Nonlinear Flexible Multibody Systems "
    "with the Use of Quasi-Newton Methods"
)


def output_of(*command):
    return subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True).stdout


def text_of(name):
    return (ROOT / name).read_text(encoding="utf-8")


def tracked(*patterns):
    return [ROOT / name for name in output_of("git", "ls-files", *patterns).splitlines()]


def test_help_lists_every_target():
    targets = re.search(r"^\.PHONY: (.*)$", text_of("Makefile"), re.MULTILINE)[1].split()
    listed = re.findall(r"^  (\S+) +\S", output_of("make", "--no-print-directory", "help"), re.M)
    assert sorted(listed) == sorted(targets)


def test_no_tracked_file_names_a_place_on_somebodys_machine():
    place = re.compile(r"(?<![\w.$}])/(?:tmp|root|home|work|Users)/")
    found = [
        f"{file.relative_to(ROOT)}: {line.strip()}"
        for file in tracked()
        if file.is_file() and file.suffix not in {".png", ".gif"}
        for line in file.read_text(encoding="utf-8").splitlines()
        if place.search(line)
    ]
    assert not found


def test_version_is_the_same_everywhere():
    version = re.search(r"^version: (\S+)$", text_of("CITATION.cff"), re.MULTILINE)[1]
    assert importlib.metadata.version("ancfsparse") == version
    assert re.search(r"^## (\S+)", text_of("CHANGELOG.md"), re.MULTILINE)[1] == version


def test_the_package_shows_its_public_names_alone():
    assert ancfsparse.__version__ == importlib.metadata.version("ancfsparse")
    assert set(dir(ancfsparse)) == {*ancfsparse.__all__, "__version__"}
    assert all(hasattr(ancfsparse, name) for name in ancfsparse.__all__)
    with pytest.raises(AttributeError, match="has no attribute 'simulat'"):
        ancfsparse.simulat  # noqa: B018


def test_licences_are_stated_and_go_along():
    assert text_of("LICENSE").startswith("BSD 3-Clause License")
    words = set(re.findall(r"[\w.-]+\w", text_of("NOTICE")))
    assert {"AMD", "METIS", "Apache", "CHOLMOD", "LGPL-2.1", "GPL-2.0"} <= words
    metadata = importlib.metadata.metadata("ancfsparse")
    assert metadata["License-Expression"] == "BSD-3-Clause AND Apache-2.0 AND MIT"
    texts = {str(f.relative_to(ROOT)) for f in tracked("vendored/*LICENSE*")}
    assert len(texts) == 3
    assert {"LICENSE", "NOTICE", *texts} <= set(metadata.get_all("License-File"))


def test_nothing_bundled_is_under_the_gpl():
    found = [
        f.name
        for f in tracked("vendored/*/*")
        if re.search(
            r"GNU (Lesser|General)|General Public|\bL?GPL\b", f.read_text(encoding="utf-8")
        )
    ]
    # One of ours names what it replaces.
    assert sorted(found) == ["plain_sort.h"]


def test_paper_is_cited():
    for name in "README.md", "CITATION.cff":
        assert PAPER in " ".join(text_of(name).split())


@pytest.mark.parametrize("file", tracked("*.md"), ids=lambda f: str(f.relative_to(ROOT)))
def test_links_between_pages_lead_somewhere(file):
    links = re.findall(r"\]\((?!https?:|#)([^)#]+)", file.read_text(encoding="utf-8"))
    missing = [link for link in links if not (file.parent / link).exists()]
    assert not missing


def test_the_package_is_marked_as_typed():
    assert (importlib.resources.files("ancfsparse") / "py.typed").is_file()


# Where any error of a foreign function becomes a value and not an error of ours: a row or a line
# that names it, or another way to the same result.
KEPT_AS_VALUE = {
    "ancfsparse/messages.py": 1,
    "ancfsparse/results/export/background_writer.py": 1,  # of a thread, raised by the one it is for
    "ancfsparse/system/loads/amplitudes.py": 2,
    "ancfsparse/sweeps/point.py": 1,
    "codegen/__main__.py": 1,
}


def test_whatever_catches_all_errors_says_why_and_passes_them_on():
    kept = {}
    for file in tracked("*.py"):
        name = str(file.relative_to(ROOT))
        if name.startswith("tests/") or not file.is_file():
            continue
        lines = file.read_text(encoding="utf-8").splitlines()
        for number, line in enumerate(lines):
            if re.search(r"except (Base)?Exception\b|except:", line):
                assert re.search(r"# \w+", line), f"{name}:{number + 1}: {line.strip()}"
                handler = " ".join(lines[number + 1 : number + 6])
                if not re.search(r"\braise\b", handler):
                    kept[name] = kept.get(name, 0) + 1
                elif "BaseException" not in line:
                    assert re.search(r"raise .* from error", handler), f"{name}:{number + 1}"
    assert kept == KEPT_AS_VALUE
