"""Run the examples of docs/gallery.md, and `ancfsparse demo`, which write docs/gallery."""

from __future__ import annotations

import argparse
import os
import re
from pathlib import Path

import matplotlib as mpl

from ancfsparse.cli.demo import FILMS, demo

DOCS = Path(__file__).resolve().parents[1] / "docs"


def examples(page: str) -> list[tuple[str, str]]:
    """Return name and source of every example of a page."""
    return re.findall(r"^## (.*?)$.*?```python\n(.*?)```", page, re.MULTILINE | re.DOTALL)


def main() -> None:
    """Run the examples whose headings contain one of the given words, or all of them."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("words", nargs="*", help="words in the headings of examples to run")
    parser.add_argument("--to", type=Path, default=DOCS / "gallery", help="folder of the pictures")
    options = parser.parse_args()
    mpl.use("Agg")
    page = (DOCS / "gallery.md").read_text(encoding="utf-8")
    os.chdir(options.to)
    for name, source in examples(page):
        if not options.words or any(word.lower() in name.lower() for word in options.words):
            print(f"== {name}", flush=True)
            exec(compile(source, f"gallery: {name}", "exec"), {})
    for name in FILMS:
        if not options.words or any(word.lower() in f"demo-{name}" for word in options.words):
            print(f"== demo {name}", flush=True)
            demo(name, Path(f"demo-{name}.gif"), fps=10, dpi=45)  # small, for README.md


if __name__ == "__main__":
    main()
