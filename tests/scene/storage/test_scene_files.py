"""Scenes in files: what is read is what was written, to the last bit, and damage is named."""

import copy
import json
import pickle
import re
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

import ancfsparse as ancf
from ancfsparse.kernels.catalog import element_kind
from ancfsparse.scene import Signal
from ancfsparse.scene.records import picklable_functions as sent_functions
from ancfsparse.scene.storage.json_file import name_of
from tests.paths import ROOT
from tests.scene import everything as all_of_it
from tests.scene.everything import everything
from tests.soak.scenes import draw

SECTION, MATERIAL = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)


def functions(scene):
    """Return what a file of a scene mentions by name."""
    values = [value for record in scene.records for value in record.given.values()]
    return {
        name_of(value): value
        for value in values
        if callable(value) and not isinstance(value, Signal)
    }


def read_again(scene, path):
    scene.save(path)
    return ancf.Scene.load(path, functions(scene))


def test_everything_comes_back(tmp_path):
    scene = everything(2)
    assert read_again(scene, tmp_path / "scene.json") == scene
    assert sorted(functions(scene)) == [
        f"tests.scene.everything.{name}"
        for name in ("bulge", "drag", "gust", "law", "length", "still")
    ]
    assert all_of_it.gust is functions(scene)["tests.scene.everything.gust"]


def test_a_motion_from_a_file_has_the_same_bits(tmp_path):
    scene = ancf.Scene()
    rod = scene.add_beam(
        "thin", (0.1, 0.2), (1 / 3, 0.7), 7, SECTION, MATERIAL, velocity=(0.1, 0.0)
    )  # fmt: skip
    scene.rod(rod.start, (0.1, 1.0))
    scene.point_force(rod.at(0.123), ancf.Sine((0.1, 1 / 7), 3.0))
    twin = read_again(scene, tmp_path / "scene.json")
    run, again = (ancf.simulate(each, 0.02, 1e-3) for each in (scene, twin))
    for name in ("q", "v", "a", "lam"):
        np.testing.assert_array_equal(getattr(run, name), getattr(again, name))


@settings(max_examples=25, deadline=None)
@given(number=st.integers(0, 10**6))
def test_random_scenes_come_back(tmp_path_factory, number):
    scene = draw(np.random.default_rng(number)).scene
    path = tmp_path_factory.mktemp("scenes") / "scene.json"
    other = draw(np.random.default_rng(number + 1)).scene
    for twin in (read_again(scene, path), copy.deepcopy(scene), scene.refined(1)):
        assert twin == scene
        assert twin.digest() == scene.digest()
        assert twin != other
    picklable_callback = pickle.loads(pickle.dumps(scene))
    assert picklable_callback.digest() == scene.digest()
    fine = scene.refined(2)
    assert fine.replaced(fine.beams[0], n_elements=scene.beams[0].n_elements).beams[0].n_nodes == (
        scene.beams[0].n_nodes
    )
    assert read_again(fine, path) == fine


def test_an_element_of_the_users_is_given_and_compared(tmp_path):
    element = replace(element_kind("thin", 2), package="mine", own={"extra": "ratios"})
    scene, path = ancf.Scene(), tmp_path / "scene.json"
    scene.add_beam(element.with_values(extra=2.0), (0, 0), (2, 0), 3, SECTION, MATERIAL)
    scene.save(path)
    assert f"element {element.name} {element.definition}, extra = 2, start" in str(scene)
    twin = ancf.Scene.load(path, {"mine": element})
    assert twin == scene
    assert twin.records[0].element.values == {"extra": 2.0}
    with pytest.raises(ancf.InputError, match="record 1: it needs 'mine', which a file cannot hol"):
        ancf.Scene.load(path)
    for other in (replace(element, definition="another"), "thin"):
        with pytest.raises(ancf.InputError, match="record 1: it was made with another element tha"):
            ancf.Scene.load(path, {"mine": other})


def test_large_arrays_come_back(tmp_path):
    scene = ancf.Scene()
    nodes = np.column_stack([np.linspace(0.0, 1.0, 900), np.random.default_rng(0).random(900)])
    edges = np.column_stack([np.arange(899), np.arange(1, 900)])
    scene.add_mesh(nodes, edges, "thin", SECTION, MATERIAL)
    twin = read_again(scene, tmp_path / "scene.json")
    assert twin == scene
    assert '"base64"' in (tmp_path / "scene.json").read_text()


def test_a_file_can_be_written_by_hand(tmp_path):
    path = tmp_path / "scene.json"
    path.write_text("""{"format": "ancfsparse scene", "version": 1, "gravity": [0, -9.81],
        "records": [
        {"method": "add_beam", "element": "thin", "start": [0, 0], "end": [2, 0], "n_elements": 3,
         "section": {"kind": "Rectangle", "width": 0.01, "height": 0.01},
         "material": {"kind": "Material", "youngs_modulus": 1e8, "density": 4000}},
        {"method": "pin", "node": {"kind": "Point", "body": "beam 0", "index": 0}}]}""")
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (2, 0), 3, SECTION, MATERIAL)
    scene.pin(rod.start)
    assert ancf.Scene.load(path) == scene


def pinned(path):
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (2, 0), 3, SECTION, MATERIAL)
    scene.pin(rod.start)
    rise = ancf.Ramp((0.0, 1.0), 1.0)
    scene.point_force(rod.at(0.3), rise + np.array([0.5, 0.0]))
    scene.save(path)
    return json.loads(path.read_text())


JOINT_SPRING = {
    "method": "joint_spring",
    "joint": {"kind": "Joint", "body": "beam 0", "number": "first"},
}


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (
            lambda d: d.update(format="xml"),
            "is not a file of a scene: its format is not 'ancfsparse",
        ),
        (lambda d: d.update(version=2), "has version 2 .*this program reads version 1"),
        (lambda d: d.update(records={}), "is damaged: it has no list of records"),
        (lambda d: d.update(gravity=[1]), "gravity must have 2 components"),
        (lambda d: d["records"].append(3), "record 4: it must be a method and its arguments, got"),
        (lambda d: d["records"][1].update(method="pinn"), "record 2: unknown method 'pinn': did"),
        (lambda d: d["records"][1].update(nod=3), "record 2: unknown argument of pin 'nod': did"),
        (lambda d: d["records"][0].pop("start"), "record 1: beam 0 has no start: give"),
        (lambda d: d["records"][0].pop("section"), "record 1: add_beam lacks section"),
        (lambda d: d["records"][0].update(n_elements=0), "record 1: n_elements of beam 0 must be"),
        (lambda d: d["records"][1].update(node=3), "record 2: a pin needs a point"),
        (lambda d: d["records"][1]["node"].update(index=9), "record 2: beam 0 has nodes 0 to 3"),
        (lambda d: d["records"][1]["node"].update(body="b"), "record 2: the scene has no body 'b'"),
        (
            lambda d: d["records"][2]["node"].update(xi=1.5),
            "record 3: .*no point at xi = 1.5 in element 0",
        ),
        (lambda d: d["records"][2]["node"].update(kind="P"), "record 3: unknown kind 'P'"),
        (lambda d: d["records"][2]["value"].update(parts=3), "parts of a sum must be signals"),
        (lambda d: d["records"][2].update(value={"own": "f"}), "needs 'f', which a file cannot"),
        (
            lambda d: d["records"].append(JOINT_SPRING),
            "record 4: the number of a joint must be an integer, got 'first'",
        ),
        (
            lambda d: d["records"][2].update(value={"base64": "AAAA", "array": "<f8", "shape": 1}),
            "record 3: its array is damaged",
        ),
    ],
)
def test_what_is_wrong_with_a_file_is_named(tmp_path, spoil, message):
    path = tmp_path / "scene.json"
    data = pinned(path)
    spoil(data)
    path.write_text(json.dumps(data))
    with pytest.raises(ancf.InputError, match=message):
        ancf.Scene.load(path)


ODD = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=5),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner),
    max_leaves=4,
)


def places(data, path=()):
    """Return all places in nested data."""
    yield path
    inside = data if isinstance(data, dict | list) else ()
    for key, value in inside.items() if isinstance(inside, dict) else enumerate(inside):
        yield from places(value, (*path, key))


@settings(max_examples=300, deadline=None)
@given(choice=st.randoms(use_true_random=False), odd=ODD)
def test_whatever_stands_in_a_file_it_is_a_scene_or_refused(tmp_path_factory, choice, odd):
    path = tmp_path_factory.mktemp("spoiled") / "scene.json"
    data = pinned(path)
    *above, last = choice.choice([each for each in places(data) if each])
    inner = data
    for key in above:
        inner = inner[key]
    inner[last] = odd
    path.write_text(json.dumps(data))
    try:
        scene = ancf.Scene.load(path)
    except ancf.AncfError:
        return
    assert isinstance(scene, ancf.Scene)


def test_what_cannot_be_written_is_named(tmp_path):
    scene, other = ancf.Scene(), ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (2, 0), 3, SECTION, MATERIAL)
    for factor in (1.0, 2.0):
        scene.point_force(rod.end, lambda t, factor=factor: (factor * t, 0.0))
    with pytest.raises(ancf.InputError, match=r"record 3 of the scene, point_force: two functions"):
        scene.save(tmp_path / "scene.json")
    assert not list(tmp_path.iterdir())
    with pytest.raises(ancf.InputError, match=r"scene\.json cannot be written: there is no folder"):
        other.save(tmp_path / "nowhere" / "scene.json")
    with pytest.raises(ancf.InputError, match=r"the scene .* cannot be read: No such file"):
        ancf.Scene.load(tmp_path / "scene.json")
    with pytest.raises(
        ancf.InputError, match=r"must be the name of .* such as 'result\.json', got 3"
    ):
        other.save(3)
    (tmp_path / "folder.json").mkdir()
    refused = {
        "folder.json": "it is a folder",
        "x" * 300: "File name too",
        "t.tex": "must end in .json",
    }
    for name, reason in refused.items():
        with pytest.raises(ancf.InputError, match=reason):
            other.save(tmp_path / name)
    with pytest.raises(ancf.InputError, match=r"must end in \.json"):
        other.save("")
    (tmp_path / "scene.json").write_text("[" * 10**5)
    with pytest.raises(ancf.InputError, match="is not a file of a scene"):
        ancf.Scene.load(tmp_path / "scene.json")


def test_a_function_that_was_not_sent_is_not_written(tmp_path, monkeypatch):
    monkeypatch.setattr(sent_functions, "_pickle_by_value", lambda function: None)
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (2, 0), 3, SECTION, MATERIAL)
    scene.point_force(rod.end, lambda t: (t, 0.0))
    with pytest.raises(ancf.InputError, match=r"record 2 .*lambda> of this scene was not sent"):
        pickle.loads(pickle.dumps(scene)).save(tmp_path / "scene.json")
    ancf.Scene().save(tmp_path / "scene.json")
    with pytest.raises(ancf.InputError, match=r"own must be a mapping of names .* got 3"):
        ancf.Scene.load(tmp_path / "scene.json", own=3)


def test_the_file_on_the_page_is_a_scene(tmp_path):
    page = (ROOT / "docs" / "large.md").read_text(encoding="utf-8")
    path = tmp_path / "scene.json"
    path.write_text(re.search(r"```json\n(.*?)```", page, re.DOTALL)[1])
    scene = ancf.Scene.load(path)
    assert [record.method for record in scene.records] == ["add_beam", "pin", "point_force"]
    assert scene.loads[0].node.s == pytest.approx(0.65)
