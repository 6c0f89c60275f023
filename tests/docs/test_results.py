"""The examples of docs/results.md run unchanged."""

import re

from tests.paths import ROOT
from tools.run_readme import without_missing_extras

PAGE = (ROOT / "docs/results.md").read_text(encoding="utf-8")


def test_examples_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(compile(without_missing_extras(block), "docs/results.md", "exec"), names)
    assert (tmp_path / "net.html").stat().st_size > 1e6
    assert re.search(r"^\(101, 3\) ", capsys.readouterr().out, re.MULTILINE)
    assert "The scene shows 501 of 501 saved states" in (tmp_path / "net.html").read_text("utf-8")
