"""Words to kernels, errors included; choice of instruction set."""

import platform
import re

import numpy as np
import pytest

from ancfsparse import dispatch, instruction_sets
from ancfsparse.dispatch import available_instruction_sets, compiled_module, instruction_set
from ancfsparse.errors import InputError
from ancfsparse.instruction_sets import FAMILIES, REQUIRED_FLAGS, processor_family
from ancfsparse.kernels.catalog import REFERENCES, curved_form, element_kind, module_names
from ancfsparse.kernels.element_kind import from_module
from tests.instruction_sets import require

X86 = FAMILIES["x86_64"]


@pytest.mark.parametrize(
    ("element", "dim", "options", "name"),
    [
        ("l2t2", 2, {}, "l2t2"),
        ("thin", 2, {}, "thin_planar_green"),  # default options come first
        ("thin", 3, {"strain": "biot"}, "thin_spatial_biot"),
        ("thick", 3, {}, "thick_axis_consistent"),
        ("thick", 2, {"curvature": "section", "section_strain": "nodal"},
         "thick_planar_section_nodal"),
    ],
)  # fmt: skip
def test_every_choice_has_its_module(element, dim, options, name):
    kind = element_kind(element, dim, **options)
    assert kind.name == name
    assert not kind.is_curved
    if element == "thick" or name == "thin_planar_green":
        curved = curved_form(kind)
        assert (curved.is_curved, curved.name) == (True, f"{name}_curved")


@pytest.mark.parametrize("name", [*module_names(), *REFERENCES])
def test_modules_say_what_they_are(name):
    kind = from_module(compiled_module(name))
    assert kind.name == name
    name = name.removesuffix("_curved")
    cables = {"l2t2": 8, "thin_planar": 8, "thin_spatial": 12}
    strings = {"string_planar": 4, "string_spatial": 6}
    assert kind.n_coordinates == (cables | strings).get(
        name if name in strings else name.rpartition("_")[0] or name,
        14 if "planar" in name else 24,
    )
    expected = {"energy", "force"}
    if name not in REFERENCES:
        expected |= {"inertia", "residual", "tangent", "mass", "damping", "material"}
        expected |= {"discrete_gradient"}
    assert set(kind.kernels) == set(kind.operations) == expected
    derived = kind.prepare(np.ones((3, len(kind.parameters))))
    assert derived.shape == (3, kind.n_derived)


@pytest.mark.parametrize(
    ("element", "dim", "options", "words"),
    [
        ("thinn", 2, {}, "did you mean 'thin'?"),
        ("shell", 2, {}, "valid are 'string', 'l2t2', 'thin', 'thick'"),
        ("thin", 4, {}, "2 or 3 dimensions, not 4"),
        ("thin", 2, {"strian": "green"}, "did you mean 'strain'?"),
        ("thin", 2, {"strain": "gren"}, "did you mean 'green'?"),
        ("thick", 3, {"curvature": "axes"}, "did you mean 'axis'?"),
        ("l2t2", 2, {"strain": "green"}, "has no options"),
        ("l2t2", 3, {}, 'in a spatial scene use "thin"'),
    ],
)
def test_mistakes_are_answered_with_a_sentence(element, dim, options, words):
    with pytest.raises(InputError, match=re.escape(words)):
        element_kind(element, dim, **options)


def test_environment_chooses_the_instruction_set(monkeypatch):
    narrowest = next(iter(REQUIRED_FLAGS))
    require(narrowest)
    monkeypatch.setenv(dispatch.ENVIRONMENT_VARIABLE, narrowest)
    assert instruction_set() == narrowest
    assert element_kind("l2t2", 2).lanes == 2
    monkeypatch.delenv(dispatch.ENVIRONMENT_VARIABLE)
    assert instruction_set() == available_instruction_sets()[-1]


@pytest.mark.parametrize(
    ("machine", "family"),
    [("x86_64", "x86_64"), ("AMD64", "x86_64"), ("arm64", "aarch64"), ("aarch64", "aarch64")],
)
def test_other_systems_have_other_names_for_the_same_processors(monkeypatch, machine, family):
    monkeypatch.setattr(platform, "machine", lambda: machine)
    assert processor_family() == family
    assert next(iter(FAMILIES[family])) == family  # the set of every processor of the family


def test_unknown_instruction_set_is_refused(monkeypatch):
    monkeypatch.setenv(dispatch.ENVIRONMENT_VARIABLE, "sse9")
    with pytest.raises(InputError, match=f"not one of {', '.join(REQUIRED_FLAGS)}"):
        instruction_set()


def test_instruction_set_the_machine_lacks_is_refused(monkeypatch):
    elsewhere(monkeypatch, {"sse2"}, X86)
    monkeypatch.setenv(dispatch.ENVIRONMENT_VARIABLE, "x86_64_v3")
    with pytest.raises(InputError, match=r"this processor lacks .*avx2.*it supports x86_64"):
        instruction_set()


def test_a_build_for_a_newer_machine_is_refused(monkeypatch):
    monkeypatch.delenv(dispatch.ENVIRONMENT_VARIABLE, raising=False)
    elsewhere(monkeypatch, X86["x86_64_v3"], ["x86_64_v4"])
    words = (
        "compiled for x86_64_v4 only, and this processor lacks avx512bw, .* again on this machine"
    )
    with pytest.raises(InputError, match=words):
        instruction_set()


def test_a_set_that_was_not_compiled_is_refused(monkeypatch):
    elsewhere(monkeypatch, X86["x86_64_v4"], ["x86_64_v4"])
    assert dispatch.available_instruction_sets() == ("x86_64_v4",)
    monkeypatch.setenv(dispatch.ENVIRONMENT_VARIABLE, "x86_64_v3")
    with pytest.raises(
        InputError, match=r"not part of this installation, which has x86_64_v4\. Build"
    ):
        instruction_set()


def test_a_package_without_compiled_modules_says_so(monkeypatch):
    monkeypatch.delenv(dispatch.ENVIRONMENT_VARIABLE, raising=False)
    elsewhere(monkeypatch, (), ())
    with pytest.raises(InputError, match="no compiled modules here: build them with `make setup`"):
        instruction_set()


def elsewhere(monkeypatch, flags, built):
    """Move to an x86-64 machine with these flags and a package compiled for these sets."""
    for module in (dispatch, instruction_sets):
        monkeypatch.setattr(module, "REQUIRED_FLAGS", X86)
    monkeypatch.setattr(dispatch, "cpu_flags", lambda: frozenset(flags))
    monkeypatch.setattr(dispatch, "built_instruction_sets", lambda: tuple(built))
    monkeypatch.setattr(
        dispatch, "available_instruction_sets", available_instruction_sets.__wrapped__
    )
