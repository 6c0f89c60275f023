"""Configuration of the documentation site, for Sphinx; `make docs` builds it.

The source folder is the whole repository: README.md is the home page, and the pages in docs/ are
those that readers of the repository see.
"""

import shutil
from importlib.metadata import distribution, version as version_of
from pathlib import Path

from sphinx.application import Sphinx

MATHJAX = distribution("sphinx-mathjax-offline")

project = "ancfsparse"
author = copyright = "The ancfsparse developers"
version = release = version_of(project)
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.mathjax",
    "numpydoc",
    "sphinx_copybutton",
]
root_doc = "README"
include_patterns = ["README.md", "CHANGELOG.md", "CONTRIBUTING.md", "docs/*.md", "docs/site/**"]
include_patterns += ["vendored/README.md"]
exclude_patterns = [
    ".*",
    "build",
    "results",
    "benchmarks",
    "codegen",
    "generated",
    "tests",
    "tools",
]
exclude_patterns += ["ancfsparse", "vendored/amd", "vendored/metis"]

myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
myst_dmath_double_inline = True
default_role = "py:obj"  # names in docstrings become links where they are known
autodoc_member_order = "groupwise"
autodoc_typehints = "none"  # types are in the tables of parameters
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
copybutton_exclude = ".linenos, .gp, .go"

html_theme = "pydata_sphinx_theme"
html_title = project
html_theme_options = {
    "show_prev_next": False,
    "navbar_end": ["theme-switcher"],
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "header_links_before_dropdown": 6,
}
html_context = {"default_mode": "auto"}
html_show_sourcelink = False
html_show_search_summary = False  # which browsers refuse to read from local files
# MathJax is part of the site, so that formulas need no network. Its SVG form is one file.
html_static_path = [str(MATHJAX.locate_file("sphinx-mathjax-offline/static/mathjax/tex-svg.js"))]
mathjax_path = "tex-svg.js"

CONTENTS = """
```{toctree}
:hidden:

docs/site/guide
docs/gallery
docs/site/api
docs/site/methods
docs/site/development
```
"""


def _add_contents(app: Sphinx, page: str, source: list[str]) -> None:
    """Add the table of contents to the home page, where GitHub would show it as text."""
    if page == root_doc:
        source[0] += CONTENTS


def _copy_home(app: Sphinx, error: Exception | None) -> None:
    if error is None and app.builder.name == "html":
        shutil.copy(Path(app.outdir) / f"{root_doc}.html", Path(app.outdir) / "index.html")


def setup(app: Sphinx) -> None:
    """Connect what this file adds."""
    app.connect("source-read", _add_contents)
    app.connect("build-finished", _copy_home)
