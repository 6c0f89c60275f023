"""Reports: the tables of a page, its numbers, and what cannot be written."""

import base64
import gzip
import json
import re

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.problems import heavy_top, net_on_sphere, pendulum
from ancfsparse.results.export.report.packing import LEVELS, pack
from ancfsparse.results.export.report.web_page import FOLDER
from ancfsparse.results.geometry.deformed_shape import spread_rows
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.results.geometry.tubes import make_tubes


def read_tables(text):
    """Return contents and tables of a packed text, by sums in the order of the format."""
    data = gzip.decompress(base64.b64decode(text))
    length = int.from_bytes(data[:4], "little")
    contents, data = json.loads(data[4 : 4 + length]), data[4 + length :]
    tables = {}
    for name, entry in contents["tables"].items():
        shape, start = entry["shape"], entry["start"]
        size = int(np.prod(shape))
        if "step" not in entry:
            tables[name] = np.frombuffer(data, "<f4", size, start).reshape(shape)
            continue
        low, high = (np.frombuffer(data, np.uint8, size, start + k * size) for k in (0, 1))
        second = (low.astype(int) + 256 * high.astype(int)).reshape(shape[::-1])
        levels = np.cumsum(np.cumsum(second, axis=1), axis=1) % (LEVELS + 1)
        tables[name] = entry["low"] + entry["step"] * levels.T
    return contents, tables


def read_page(path):
    text = re.search(r'id="data">([^<]*)<', path.read_text(encoding="utf-8"))[1]
    return read_tables(text)


def test_packed_numbers_are_rounded_to_the_stated_step():
    rng = np.random.default_rng(1)
    moving = {"smooth": np.sin(np.linspace(0, 9, 300))[:, None] * np.arange(1, 4), "odd": np.eye(3)}
    moving |= {"random": rng.normal(size=(40, 5)), "constant": np.full((7, 2), 3.0)}
    moving |= {"none": np.zeros((4, 0))}
    fixed = {"indices": np.arange(12.0).reshape(4, 3)}
    contents, tables = read_tables(pack({"a": 1}, moving, fixed))
    assert contents["a"] == 1
    for name, table in moving.items():
        assert tables[name].shape == table.shape
        limit = 0.5001 * np.ptp(table) / LEVELS if table.size else 0.0
        assert np.abs(tables[name] - table).max(initial=0.0) <= limit
    assert np.array_equal(tables["indices"], fixed["indices"])


@pytest.fixture(scope="module")
def fall(tmp_path_factory):
    scene, rod = pendulum(n_elements=4)
    run = ancf.simulate(scene, 0.3, 1e-3, output=tmp_path_factory.mktemp("runs") / "fall.h5")
    return run, rod, run.report(tmp_path_factory.mktemp("pages") / "fall.html")


def test_a_page_has_the_numbers_of_the_run(fall):
    run, rod, path = fall
    contents, tables = read_page(path)
    assert np.array_equal(contents["t"], run.t)
    tip = next(  # its points come first, in the order of coordinates; the last node is one of them
        p for p in range(5) if np.abs(tables["x"][0, p] - 2.0) < 1e-3
    )
    for axis, name in enumerate("xy"):
        step = contents["tables"][name]["step"]
        assert np.abs(tables[name][:, tip] - run.position(rod.end)[:, axis]).max() < 0.51 * step
    for name, values in (("N", run.section_force(rod).N), ("strain", run.strain(rod)),
                         ("curvature", run.curvature(rod))):  # fmt: skip
        assert np.abs(tables[name] - values).max() < 0.51 * contents["tables"][name]["step"]


def test_a_page_states_energies_solver_and_settings(fall):
    run, _, path = fall
    text = path.read_text(encoding="utf-8")
    assert f"{run.energy.kinetic[-1]:.6g}" in text
    assert f"{run.energy.drift:.3g}" in text
    assert run.stats.method in text
    assert "GeneralizedAlpha(rho_inf=0.9)" in text
    assert text.count("<svg") == 2 + 2 + 1 + 1  # histories, ranges, energies, axes
    assert path.read_bytes() == run.report(path.with_name("fall.html")).read_bytes()
    assert "Copyright" not in text  # compressed with the library, whose licence it is


def test_the_policy_of_a_page_allows_its_own_script_only(fall):
    text = fall[2].read_text(encoding="utf-8")
    assert "default-src 'none'; script-src 'sha256-" in text
    assert not re.findall(r"""(?:src|href)=["'](?!#)""", text)
    # A notebook may store the script in any encoding; its digest must not change.
    assert (FOLDER / "page.js").read_text(encoding="utf-8").isascii()
    library = re.search(r'id="library">([^<]*)<', text)[1]
    assert b"Permission is hereby granted" in gzip.decompress(base64.b64decode(library))


def test_tubes_follow_the_lines_and_meet_smoothly():
    scene, rod = pendulum(n_elements=3)
    run = ancf.simulate(scene, 0.1, 1e-3)
    (part,) = make_outline(run.system).parts
    tubes = make_tubes(run.q, part, 2)
    s = np.array([0.0, 1 / 3, 2 / 3, 1.0, 4 / 3, 5 / 3, 2.0])
    expected = np.stack([run.position(rod.at(x)) for x in s], axis=1)
    order = np.argsort(tubes.points[0, :, 0])
    assert tubes.points[:, order] == pytest.approx(expected, abs=1e-12)
    point = tubes.rings[:, 0].astype(int)
    before, after = tubes.rings[:, 1].astype(int), tubes.rings[:, 2].astype(int)
    for k in np.flatnonzero(tubes.rings[:, 5] == 0):  # neighbours along the line, or the end itself
        place = int(np.flatnonzero(order == point[k])[0])
        assert order[max(place - 1, 0)] == before[k]
        assert order[min(place + 1, 6)] == after[k]
    assert sorted(tubes.rings[:, 5])[:1] + sorted(tubes.rings[:, 5])[-1:] == [-1.0, 1.0]
    assert len(tubes.strips) == 6 + 2


def test_large_scenes_have_fewer_states():
    t = np.array([0.0, 0.1, 0.11, 0.12, 0.5, 1.0])
    assert spread_rows(t, 3).tolist() == [0, 4, 5]
    assert spread_rows(t, 6).tolist() == [0, 1, 2, 3, 4, 5]


@pytest.mark.parametrize("problem", [heavy_top, net_on_sphere])
def test_scenes_in_space(tmp_path, problem):
    scene = problem().scene
    run = ancf.simulate(scene, 0.02, 2e-3)
    contents, tables = read_page(run.report(tmp_path / "a.html"))
    assert contents["dim"] == 3
    assert len(contents["bodies"]) + len(contents["solids"]) == len(scene.bodies)
    if contents["solids"]:
        origin = run.position(scene.bodies[0].origin)
        assert tables["origin 0"] == pytest.approx(origin, abs=1e-4)


def test_equilibria_and_single_states(tmp_path):
    scene = ancf.Scene((0, -9.81))
    rod = scene.add_beam("string", (0, 0), (1, 0), 4, ancf.Circle(0.01), ancf.Material(1e6, 1e3))
    scene.pin(rod.start)
    scene.pin(rod.end)
    scene.point_force(rod.node(2), lambda t: (0.0, -t))
    path = ancf.quasi_static(scene, 1.0, 0.5).report(tmp_path / "a.html")
    assert "error of the balance" not in path.read_text(encoding="utf-8")  # without kinetic energy
    contents, _ = read_page(path)
    assert [each["name"] for each in contents["quantities"]] == ["N", "strain"]


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"path": "a.pdf"}, "a report must end in .html, got 'a.pdf'"),
        ({"path": "no/a.html"}, "there is no folder no"),
        ({"points": 3}, "points must be a list such as"),
        ({"points": [3]}, "a report needs a point on a beam"),
        ({"lines": ["rod"]}, "lines must be a list of beams such as"),
    ],
)
def test_what_cannot_be_reported_is_refused(fall, tmp_path, arguments, message):
    with pytest.raises(InputError, match=message):
        fall[0].report(**{"path": tmp_path / "a.html"} | arguments)


def test_a_file_that_cannot_be_written_is_named(fall, tmp_path):
    target = tmp_path / "a.html"
    target.symlink_to(tmp_path / "missing" / "b.html")
    with pytest.raises(InputError, match=r"the report cannot be written to .*a\.html: No such"):
        fall[0].report(target)


def test_a_run_of_some_points_has_no_scene(tmp_path):
    scene, rod = pendulum(n_elements=2)
    run = ancf.simulate(scene, 0.01, 1e-3, save_nodes=[rod.end])
    with pytest.raises(InputError, match="the run did not keep this"):
        run.report(tmp_path / "a.html")
    assert run._repr_html_() is None


def test_arrows_are_loads_and_forces_of_joints(tmp_path):
    scene = ancf.Scene((0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 6, ancf.Circle(0.01), ancf.Material(1e8, 1e3))
    pin = scene.pin(rod.start)
    scene.pin(rod.end)
    scene.point_force(rod.node(3), lambda t: (0.0, 100.0 * t))
    scene.point_force(rod.node(2), (0.0, -0.1), follow=True)  # turns with the rod: left out
    run = ancf.simulate(scene, 0.05, 1e-3)
    contents, tables = read_page(run.report(tmp_path / "a.html"))
    assert contents["arrows"] == ["load", "reaction", "reaction"]
    forces, points = (
        tables["arrow forces"].reshape(-1, 3, 2),
        tables["arrow points"].reshape(-1, 3, 2),
    )
    step = contents["tables"]["arrow forces"]["step"]
    assert np.abs(forces[:, 0] - np.outer(run.t, [0.0, 100.0])).max() < 0.52 * step
    assert np.abs(forces[:, 1] - run.reaction(rod.start)).max() < 0.52 * step
    assert np.abs(forces[:, 1] - run.joint_force(pin).force).max() < 0.52 * step
    assert np.abs(points[:, 0] - run.position(rod.node(3))).max() < 1e-4
    assert contents["force"] == pytest.approx(np.linalg.norm(forces, axis=2).max(), rel=1e-3)
