"""Elements of a user's own: built elsewhere by one command, then used like any other."""

import pickle
import re
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.kernels import building
from tests.beams import build_beam

SOURCES = Path(__file__).parent / "elements"
SECTION = ancf.Circle(0.01)
MATERIAL = ancf.Material(youngs_modulus=1e8, density=4000)


@pytest.fixture(scope="module")
def elements(tmp_path_factory):
    """Build all and return them by name, with their folder importable."""
    folder = tmp_path_factory.mktemp("elsewhere")
    sources = sorted(SOURCES.glob("*.py"))
    with pytest.MonkeyPatch.context() as patch:
        # Optimization takes the compiler four times as long, and these runs are short.
        patch.setattr(building, "FLAGS", ("-O0", *building.FLAGS[1:]))
        with ThreadPoolExecutor(2) as pool:
            list(pool.map(lambda source: building.build_element(source, folder), sources))
        patch.syspath_prepend(folder)
        yield {each.stem: import_module(each.stem).ELEMENT for each in sources}


def pendulum(element, gravity, **options):
    scene = ancf.Scene(gravity=gravity)
    along = np.eye(len(gravity))[0]
    rod = scene.add_beam(element, 0 * along, along, 8, SECTION, MATERIAL, **options)
    scene.pin(rod.start)
    return scene, rod


@pytest.mark.slow
def test_a_motion_in_a_plane_is_that_of_the_planar_cable(elements):
    ends = []
    for element, gravity in (("l2t2", (0, -9.81)), (elements["chord_cable"], (0, -9.81, 0))):
        scene, rod = pendulum(element, gravity)
        run = ancf.simulate(scene, 0.5, 2e-3, integrator=ancf.Newmark(), solver=ancf.Newton())
        ends.append(run.position(rod.end))
    assert np.ptp(ends[0], axis=0).min() > 0.3
    np.testing.assert_allclose(ends[1][:, :2], ends[0], atol=1e-11)
    np.testing.assert_array_equal(ends[1][:, 2], 0.0)


@pytest.mark.slow
def test_a_cable_of_a_user_s_own_vibrates_as_a_beam(elements):
    scene = ancf.Scene(gravity=(0, 0, 0))
    sine = np.pi  # over 1 m
    rod = scene.add_beam(
        elements["chord_cable"], (0, 0, 0), (1, 0, 0), 8, SECTION, MATERIAL,
        velocity=lambda x: 1e-4 * np.sin(sine * x[:, :1]) * [[0, 0.6, 0.8]],
    )  # fmt: skip
    scene.pin(rod.start)
    scene.pin(rod.end)
    bending = 1e8 * SECTION.inertia_y
    omega = sine**2 * np.sqrt(bending / (4000 * SECTION.area))
    quarter = 0.5 * np.pi / omega
    run = ancf.simulate(scene, quarter, quarter / 200, integrator=ancf.Newmark())
    assert run.position(rod.node(4))[-1, 1:] == pytest.approx(
        1e-4 / omega * np.array([0.6, 0.8]), rel=1e-4
    )


@pytest.mark.slow
def test_an_own_parameter_enters_its_law(elements):
    limit, curvature = 3.0, 1.0
    kind = elements["weakening_cable"].with_values(curvature_limit=limit)
    scene, rod = build_beam(kind, (0, 0), (1, 0), 16, SECTION, MATERIAL, "clamp", gravity=(0, 0))
    moment = 1e8 * SECTION.inertia_z * curvature / (1 + (curvature / limit) ** 2) ** 2
    scene.point_moment(rod.end, moment)
    tip = ancf.solve_static(scene).position(rod.end)
    assert tip == pytest.approx([np.sin(curvature), 1 - np.cos(curvature)], abs=1e-4)


def ribbon(elements):
    scene, rod = build_beam(
        elements["ribbon"], (0, 0, 0), (1, 0, 0), 16, ancf.Rectangle(0.02, 0.01), MATERIAL, "clamp",
        gravity=(0, 0, 0),
    )  # fmt: skip
    return scene, rod


@pytest.mark.slow
def test_a_clamp_holds_and_a_moment_turns_the_vectors_that_an_element_has(elements):
    scene, rod = ribbon(elements)
    torsion = rod.stiffnesses()["torsion_stiffness"]
    scene.point_moment(rod.end, (0.5 * torsion, 0, 0))
    rest = ancf.solve_static(scene)
    system = rest.system
    held = system.place(rod.start)[:9]
    assert (held >= system.n_free).all()
    turned = rest.q[system.vectors("r_y")[0][-1]]
    assert turned == pytest.approx([0, np.cos(0.5), np.sin(0.5)], abs=1e-3)
    assert rest.curvature(rod)[:, 0] == pytest.approx(0.5, rel=3e-3)
    assert rest.section_force(rod).T == pytest.approx(0.5 * torsion, rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize("direction", [1, 2])
def test_a_section_vector_tells_both_bending_stiffnesses_apart(elements, direction):
    scene, rod = ribbon(elements)
    about = ("bending_stiffness_z", "bending_stiffness_y")[direction - 1]
    stiffness = rod.stiffnesses()[about]
    force = np.zeros(3)
    force[direction] = 3e-4 * stiffness
    scene.point_force(rod.end, force)
    tip = ancf.solve_static(scene).position(rod.end)
    assert tip[direction] == pytest.approx(1e-4, rel=1e-3)


@pytest.mark.slow
def test_scenes_and_runs_of_own_elements_go_to_files_and_other_processes(elements, tmp_path):
    kind = elements["weakening_cable"].with_values(curvature_limit=3.0)
    scene, _ = pendulum(kind, (0, -9.81))
    run = ancf.simulate(scene, 0.01, 1e-3, output=tmp_path / "run.h5")
    scene.save(tmp_path / "scene.json")
    own = {"weakening_cable": elements["weakening_cable"]}
    for same in (ancf.Scene.load(tmp_path / "scene.json", own), pickle.loads(pickle.dumps(scene))):
        assert same == scene
        assert same.beams[0].kind == kind
        again = ancf.load(tmp_path / "run.h5", same)
        np.testing.assert_array_equal(again.q[-1], run.q[-1])
    again = ancf.load(tmp_path / "run.h5", own=own)
    np.testing.assert_array_equal(again.system.scene.beams[0].kind.values["curvature_limit"], 3.0)
    for other in ("thin", kind.with_values(curvature_limit=4.0)):
        different, _ = pendulum(other, (0, -9.81))
        words = rf"element of body 0 there: {re.escape(repr(kind))}; here: "
        with pytest.raises(InputError, match=words):
            ancf.load(tmp_path / "run.h5", different)

    text = (tmp_path / "scene.json").read_text()
    (tmp_path / "changed.json").write_text(text.replace(kind.definition, "0" * 16))
    with pytest.raises(InputError, match=r"record 1: it was made with another element than the"):
        ancf.Scene.load(tmp_path / "changed.json", own)
    with pytest.raises(InputError, match="needs 'weakening_cable', which a file cannot hold: give"):
        ancf.Scene.load(tmp_path / "scene.json")
    sent = tmp_path / "scene.pickle"
    sent.write_bytes(pickle.dumps(scene))
    opened = f"import pickle; pickle.load(open({str(sent)!r}, 'rb'))"
    elsewhere = subprocess.run([sys.executable, "-c", opened], capture_output=True, text=True)
    assert "which cannot be imported here: put the folder that contains it" in elsewhere.stderr
