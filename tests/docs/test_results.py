"""The examples of docs/results.md run unchanged."""

import re

from tests.paths import ROOT

PAGE = (ROOT / "docs/results.md").read_text(encoding="utf-8")


def test_examples_run(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL):
        exec(compile(block, "docs/results.md", "exec"), names)
    assert (tmp_path / "net.html").stat().st_size > 1e6
    assert capsys.readouterr().out.startswith("(101, 3) ")
    assert "The scene shows 501 of 501 saved states" in (tmp_path / "net.html").read_text("utf-8")
