"""`generated/` is what `codegen/` makes, every time, and a change by hand is noticed."""

import ast
import hashlib
import os
import shutil
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from codegen.__main__ import GENERATED, main
from codegen.elements import ELEMENTS
from codegen.stamp import dependencies, digest_of_inputs

ROOT = GENERATED.parent


def digests(root=ROOT):
    return {name: digest_of_inputs(*ELEMENTS[name], root) for name in ELEMENTS}


@pytest.fixture(scope="module")
def reference():
    """Return the digests of the tree as it is, and have each text parsed once in this module."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(ast, "parse", cache(ast.parse))
        yield digests()


def test_headers_carry_the_digest_of_the_sources(reference):
    for name, digest in reference.items():
        head = (GENERATED / f"{name}.pyx").read_text(encoding="utf-8")[:1000]
        assert f"sha256:{digest}" in head, f"{name} is stale: run `make codegen`"


def test_a_digest_does_not_depend_on_the_folder(reference, tmp_path):
    shutil.copytree(ROOT / "codegen", tmp_path / "codegen")
    assert digests(tmp_path) == reference


@pytest.mark.parametrize(
    ("file", "stale"),
    [
        ("elements/thin.py", "thin"),
        ("elements/thick.py", "thick"),
        ("declarations/fields.py", ""),
        ("tape.py", ""),
        ("emit.py", ""),
        ("stamp.py", ""),
        ("elements/__init__.py", "none"),
        ("__main__.py", "none"),
    ],
)
def test_a_digest_covers_what_its_module_depends_on_and_nothing_else(
    reference, tmp_path, file, stale
):
    shutil.copytree(ROOT / "codegen", tmp_path / "codegen")
    with (tmp_path / "codegen" / file).open("a", encoding="utf-8") as source:
        source.write("# one more line\n")
    after = digests(tmp_path)
    changed = {name for name, digest in reference.items() if after[name] != digest}
    assert changed == {name for name in ELEMENTS if name.startswith(stale)}


def test_a_digest_covers_the_options_of_the_element(reference):
    assert len(set(reference.values())) == len(ELEMENTS)


def test_imports_are_followed_however_they_are_written(tmp_path):
    folder = tmp_path / "codegen"
    folder.mkdir()
    (folder / "a.py").write_text("from codegen import b\nimport os\n")
    (folder / "b.py").write_text("def late():\n    import codegen.c\n")
    (folder / "c.py").write_text("from codegen.a import x\n")
    (folder / "d.py").write_text("")
    assert dependencies(["codegen/a.py"], tmp_path) == [f"codegen/{x}.py" for x in "abc"]


def test_sums_match_the_files():
    names = set()
    for line in (GENERATED / "SHA256SUMS").read_text(encoding="utf-8").splitlines():
        digest, name = line.split("  ")
        names.add(name)
        assert hashlib.sha256((GENERATED / name).read_bytes()).hexdigest() == digest, name
    assert names | {"SHA256SUMS"} == {p.name for p in GENERATED.iterdir()}


@pytest.mark.slow
def test_emission_does_not_depend_on_the_hash_seed(tmp_path):
    # As committed under other seeds; one element under two.
    for seed, names in (
        ("1", ["l2t2", "thin_spatial_green"]),
        ("2", ["l2t2", "thick_planar_axis_nodal"]),
    ):
        folder = tmp_path / seed
        shutil.copytree(GENERATED, folder)
        for name in names:
            (folder / f"{name}.pyx").unlink()
        command = [sys.executable, "-m", "codegen", "--folder", str(folder), *names]
        environment = os.environ | {"PYTHONHASHSEED": seed}
        subprocess.run(command, check=True, cwd=ROOT, env=environment, capture_output=True)
        made, committed = (
            {p.name: p.read_bytes() for p in each.iterdir()} for each in (folder, GENERATED)
        )
        assert made == committed


@pytest.fixture
def copy(tmp_path) -> Path:
    return Path(shutil.copytree(GENERATED, tmp_path / "generated"))


def test_check_passes_on_what_is_committed(copy, capsys):
    assert main(["--check", "--folder", str(copy), "l2t2"]) == 0
    assert capsys.readouterr().out == ""


def test_check_shows_a_change_made_by_hand(copy, capsys):
    path = copy / "l2t2.pyx"
    path.write_text(path.read_text(encoding="utf-8").replace("3.0 * t1", "4.0 * t1", 1))
    assert main(["--check", "--folder", str(copy), "l2t2"]) == 1
    shown = capsys.readouterr().out
    assert "-        4.0 * t1," in shown
    assert "+        3.0 * t1," in shown
    assert "Run `make codegen`." in shown
    assert main(["--folder", str(copy), "l2t2"]) == 0
    assert path.read_bytes() == (GENERATED / "l2t2.pyx").read_bytes()


def test_check_names_files_that_should_not_be_there(copy, capsys):
    (copy / "old.pyx").write_text("")
    (copy / "l2t2.pyx").unlink()
    assert main(["--check", "--folder", str(copy), "l2t2"]) == 1
    shown = capsys.readouterr().out
    assert "old.pyx: should not exist" in shown
    assert "l2t2.pyx: is missing" in shown


def test_untouched_files_keep_their_time(copy, capsys):
    before = {p.name: p.stat().st_mtime_ns for p in copy.iterdir()}
    assert main(["--folder", str(copy), "l2t2"]) == 0
    assert capsys.readouterr().out.startswith("0 of")
    assert {p.name: p.stat().st_mtime_ns for p in copy.iterdir()} == before


def test_unknown_names_are_refused(capsys):
    with pytest.raises(SystemExit):
        main(["shell"])
    assert "no element 'shell'" in capsys.readouterr().err


def test_nothing_in_codegen_imports_the_package():
    for path in (ROOT / "codegen").rglob("*.py"):
        assert "import ancfsparse" not in path.read_text(encoding="utf-8")
        assert "from ancfsparse" not in path.read_text(encoding="utf-8")
