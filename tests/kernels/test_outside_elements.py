"""What is answered where an element of a user's own cannot be built, loaded or used."""

import pickle
import sys
from dataclasses import replace
from types import ModuleType

import pytest

import ancfsparse as ancf
from ancfsparse.dispatch import compiled_module, instruction_set
from ancfsparse.errors import InputError
from ancfsparse.kernels.building import build_element, compile_c
from ancfsparse.kernels.catalog import element_kind
from ancfsparse.kernels.element_kind import external_element, from_module
from codegen.__main__ import main as generate

HEAD = "from codegen.declarations import Element, Term, interpolate, parameter\n"
CABLE = """
r = interpolate("r", (0, 1), "r", "r_x")
r_x = r.diff()
ELEMENT = Element(
    name="string", title="string", dim=2, node=(("r", (0, 1)), ("r_x", (0, 1))), section=("r_x",),
    fields=(r_x,), energy=(Term(parameter("axial_stiffness"), (r_x @ r_x - 1) / 2),),
    inertia=((parameter("mass_per_length"), r),),
)
"""


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = 1", "it has no `ELEMENT = Element(...)`"),
        ("1 / 0", "division by zero"),
        (CABLE.replace("axial_stiffness", "axial"), "'axial' is not one of the base parameters"),
        (CABLE.replace('"string"', '"my string"', 1), "must be an identifier, not 'my string'"),
        (CABLE.replace("dim=2", "dim=4"), "string has dim = 4; it must be 2 or 3"),
        (CABLE.replace('(("r", (0, 1)), ', "("), "must begin with ('r', (0, 1)) and ('r_x'"),
        (CABLE.replace('("r_x",),', '("r_y",),'), "must name some of its nodal vectors r_x, not"),
        (CABLE.replace('("r_x", (0, 1)))', '("r_x", (0, 1)), ("d", (0, 1)))'), "r, r_x, d; beside"),
        (CABLE.replace('((parameter("mass_per_length"), r),)', "()"), "an inertia"),
    ],
)  # fmt: skip
def test_a_file_that_describes_no_element(tmp_path, monkeypatch, capsys, text, words):
    file = tmp_path / "mine.py"
    file.write_text(HEAD + text)
    monkeypatch.setattr(sys, "path", [*sys.path])  # the generator adds the folder of the file
    assert generate(["--element", str(file), "--folder", str(tmp_path)]) == 2
    assert words in capsys.readouterr().err


def test_what_cannot_be_external_element(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"there is no file .*missing\.py with the energy"):
        build_element(tmp_path / "missing.py", tmp_path)
    with pytest.raises(InputError, match="'sse9' is not one of the instruction sets "):
        build_element(tmp_path / "missing.py", tmp_path, ["sse9"])
    file = tmp_path / "mine.py"
    file.write_text(HEAD + "1 / 0")
    with pytest.raises(InputError, match=r"the generator refused: .*division by zero"):
        build_element(file, tmp_path)
    monkeypatch.setenv("CC", "no-such-compiler")
    with pytest.raises(InputError, match=r"the C compiler cannot be run: .*no-such-compiler"):
        compile_c(tmp_path / "mine.c", tmp_path / "mine.so")


def test_packages_that_cannot_be_loaded(tmp_path, monkeypatch):
    with pytest.raises(InputError, match="package nowhere, which cannot be imported here: put the"):
        external_element("nowhere")
    (tmp_path / "elsewhere").mkdir()
    (tmp_path / "elsewhere" / "__init__.py").write_text("")
    monkeypatch.syspath_prepend(tmp_path)
    words = f"not built for instruction set {instruction_set()} and this Python: build it again"
    with pytest.raises(InputError, match=words):
        external_element("elsewhere")


def test_a_module_of_another_calling_convention_is_refused():
    module = ModuleType("old")
    vars(module).update(vars(compiled_module("l2t2")), SIGNATURE="ancf_kernel_v0")
    with pytest.raises(InputError, match="convention ancf_kernel_v0, and this version of ancfspar"):
        from_module(module, "old")


def own(**changes):
    usual = {"package": "mine", "own": {"limit": "ratios"}, "name": "mine"}
    return replace(element_kind("thin", 3), **{**usual, **changes})


@pytest.mark.parametrize(
    ("kind", "options", "words"),
    [
        (own(dim=2), {}, "element mine is planar, but the scene of beam 0 is spatial: give the"),
        (own(), {}, r"needs a value of its own parameter limit: give ELEMENT.with_values\(limit="),
        (own(own={}), {"curvature": "axis"}, "mine of beam 0 has no options: leave"),
        (own(own={}), {"strain": "biot"}, "mine of beam 0 has no options: leave strain='biot' out"),
    ],
)
def test_scenes_that_an_element_does_not_fit(kind, options, words):
    scene = ancf.Scene(gravity=(0, 0, 0))
    material = ancf.Material(1e8, 1e3)
    with pytest.raises(InputError, match=words):
        scene.add_beam(kind, (0, 0, 0), (1, 0, 0), 2, ancf.Circle(0.01), material, **options)


def test_values_of_own_parameters():
    kind = own().with_values(limit=2.0)
    assert kind.values == {"limit": 2.0}
    assert kind != own()
    assert kind == own().with_values(limit=2.0)
    with pytest.raises(InputError, match=r"has no own parameter 'limits' \(its own: limit\)"):
        own().with_values(limits=2.0)
    with pytest.raises(InputError, match="limit of element mine must be"):
        own().with_values(limit=float("nan"))


@pytest.mark.parametrize("name", ["thin", "thick"])
def test_elements_are_pickled_by_name(name):
    kind = element_kind(name, 3)
    assert pickle.loads(pickle.dumps(kind)) is kind


def test_an_element_of_the_catalog_can_be_given_itself():
    ends = []
    for element in ("thin", element_kind("thin", 2)):
        scene = ancf.Scene(gravity=(0, -9.81))
        rod = scene.add_beam(
            element, (0, 0), (1, 0), 2, ancf.Circle(0.01), ancf.Material(1e8, 4000)
        )
        scene.pin(rod.start)
        ends.append(ancf.simulate(scene, 0.01, 1e-3).q[-1])
    assert (ends[0] == ends[1]).all()
