"""Codes of outcomes and rungs are those of the header that compiled code includes."""

import re
from pathlib import Path

import pytest

import ancfsparse
from ancfsparse.nonlinear import Attempt, Outcome


@pytest.mark.parametrize(("kind", "name"), [(Outcome, "ancf_outcome"), (Attempt, "ancf_rung")])
def test_python_has_the_names_and_codes_of_the_header(kind, name):
    text = (Path(ancfsparse.__file__).parent / "abi" / "outcome.h").read_text(encoding="utf-8")
    body = text.partition(f"enum {name} {{")[2].partition("};")[0]
    codes = {each.name: each.value for each in kind}
    assert codes == {key: int(code) for key, code in re.findall(r"ANCF_(\w+) = (\d+)", body)}
    assert list(codes.values()) == list(range(len(codes)))


def test_every_code_has_words_of_its_own():
    assert len({each.message for each in Outcome}) == len(Outcome)
    assert len({each.description for each in Attempt}) == len(Attempt)


def test_no_compiled_file_types_a_code_again():
    for file in Path(ancfsparse.__file__).parent.rglob("*.p[xy][xi]"):
        typed = re.findall(r"^ +([A-Z_]+) = \d+$", file.read_text(encoding="utf-8"), re.MULTILINE)
        assert not set(typed) & {*Outcome.__members__, *Attempt.__members__}, file
