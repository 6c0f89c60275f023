"""Files that a study cannot write are refused before it runs."""

import pytest

from benchmarks.commands import STUDIES, main


def run(capsys, *words):
    with pytest.raises(SystemExit) as left:
        main(words)
    out, err = capsys.readouterr()
    return left.value.code, out, err


@pytest.mark.parametrize("words", STUDIES)
def test_outputs_are_checked_before_a_study(capsys, tmp_path, words):
    file = tmp_path / "a.md"
    file.write_text("a page without markers\n", encoding="utf-8")
    cases = [
        (("--page", str(file)), "has no place for"),
        (("--page", str(tmp_path / "no.md")), "no such page"),
        *((("--output", str(each)), "cannot be a folder") for each in (file, file / "deeper")),
    ]
    for options, sentence in cases:
        code, out, err = run(capsys, *words.split(), *options)
        assert (code, out) == (2, "")
        assert sentence in err
