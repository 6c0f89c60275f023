"""The documentation site: complete, without warnings, and without a network."""

import inspect
import re
import subprocess
import sys
import tomllib
from importlib.util import find_spec

import pytest

import ancfsparse as ancf
from tests.paths import ROOT
from tests.results.report.browser import open_page

NAMES = "sphinx", "pydata_sphinx_theme", "myst_parser", "numpydoc", "sphinx_copybutton"
IN_MODULES = {name: f"ancfsparse.{name}.{what}" for name, what in (
    ("gym", "make"), ("fmu", "write"), ("urdf", "add"))}  # fmt: skip
FETCHED = re.compile(r'<(?:script|img|iframe)[^>]*\bsrc="([^"]*)|<link[^>]*\bhref="([^"]*)')


def test_the_reference_has_each_public_name_once():
    text = "".join(f.read_text(encoding="utf-8") for f in (ROOT / "docs/site/api").glob("*.rst"))
    entries = re.findall(r"^\.\. auto(class|function):: (\S+)$", text, re.MULTILINE)
    assert sorted(name for _, name in entries) == sorted(
        IN_MODULES.get(name, name) for name in ancf.__all__
    )
    for kind, name in entries:
        if name not in IN_MODULES.values():
            assert inspect.isclass(getattr(ancf, name)) == (kind == "class")


def test_the_build_has_what_its_extra_installs():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    named = " ".join(project["optional-dependencies"]["docs"]).replace("-", "_")
    configuration = (ROOT / "docs/site/conf.py").read_text(encoding="utf-8")
    assert all(name in named for name in NAMES)
    assert all(name in configuration for name in NAMES[1:])


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    missing = [name for name in (*NAMES, "gymnasium") if find_spec(name) is None]
    if missing:
        pytest.skip(f"{missing[0]} is missing: pip install 'ancfsparse[docs]'")
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "sphinx", "-b", "html", "-c", "docs/site", "-W"]
    done = subprocess.run(
        [*command, "--keep-going", "-q", "-d", folder / "trees", ".", folder / "html"],
        cwd=ROOT, capture_output=True, text=True,
    )  # fmt: skip
    assert (done.returncode, done.stderr) == (0, "")
    return folder / "html"


@pytest.mark.slow
def test_pages_fetch_nothing_from_other_hosts(site):
    pages = [page for page in site.rglob("*.html") if "_static" not in page.parts]
    assert len(pages) > 30
    for page in pages:
        for script, sheet in FETCHED.findall(page.read_text(encoding="utf-8")):
            address = (script or sheet).partition("?")[0].partition("#")[0]
            assert not address.startswith(("http", "//")), page
            assert (page.parent / address).exists(), (page, address)


TYPESET = "MathJax.startup.promise.then(() => document.querySelectorAll('{}').length)"
RESULTS = """
new Promise(found => setInterval(() => {
    const n = document.querySelectorAll('#search-results li').length;
    if (n) found(n);
}, 100))
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    ("page", "script", "least", "most"),
    [
        ("index.html", "[...document.images].filter(i => i.naturalWidth > 200).length", 9, 20),
        ("index.html", "[...document.images].filter(i => !i.naturalWidth).length", 0, 0),
        ("docs/theory.html", TYPESET.format("mjx-container"), 300, 1e4),
        ("docs/theory.html", TYPESET.format("[data-mjx-error], merror"), 0, 0),
        ("docs/site/api/results.html", "document.querySelectorAll('dt.sig').length", 40, 500),
        ("search.html?q=winch", RESULTS, 4, 100),
    ],
)
def test_pages_work_from_the_folder(site, tmp_path, page, script, least, most):
    name, _, query = page.partition("?")
    with open_page(site / name, tmp_path, fragment=f"?{query}" if query else "") as opened:
        assert least <= opened.run(script) <= most
        assert all(each.startswith(("file:", "data:")) for each in opened.requests)
        kinds = {m.get("type") or m.get("entry", {}).get("level", "error") for m in opened.messages}
        assert "error" not in kinds, opened.messages
