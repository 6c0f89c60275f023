"""Reports in a browser: no error, the numbers of the run, and the rate of pictures."""

import time

import numpy as np
import pytest
from PIL import Image

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from ancfsparse.results import RunStats, Trajectory
from tests.grids import grid
from tests.results.report.browser import open_page


@pytest.fixture(scope="module")
def fall(tmp_path_factory):
    scene, rod = pendulum(n_elements=8)
    run = ancf.simulate(scene, 1.0, 1e-3)
    return run, rod, run.report(tmp_path_factory.mktemp("pages") / "fall.html")


def coloured_rows_and_columns(page, path):
    """Return where the picture of the beams alone is neither white nor grey."""
    page.run("report.then(() => { bar.hidden = true; if (forces.checked) forces.click() })")
    page.save_picture(path)
    box = page.run("(r => [r.x, r.y, r.right, r.bottom])(canvas.getBoundingClientRect())")
    with Image.open(path) as image:
        pixels = np.asarray(image.convert("RGB").crop([round(x) for x in box])).astype(int)
    rows, columns = (np.ptp(pixels, axis=2) > 40).nonzero()
    return rows, columns, pixels.shape


def test_a_page_runs_without_errors_and_has_the_numbers_of_the_run(fall, tmp_path):
    run, rod, path = fall
    with open_page(path, tmp_path / "profile") as page:
        loaded = page.run(
            "report.then(r => ({t: r.contents.t, N: [...r.tables.N.values], "
            "x: [...r.tables.x.values], n: r.tables.x.shape[1], tables: r.contents.tables}))"
        )
        times = np.array(loaded["t"])
        rows = np.searchsorted(run.t, times - 1e-9)
        assert len(times) == 501
        assert np.array_equal(run.t[rows], times)
        forces = np.array(loaded["N"]).reshape(501, -1)
        step = loaded["tables"]["N"]["step"]
        assert np.abs(forces - run.section_force(rod).N[rows]).max() < 0.52 * step
        x = np.array(loaded["x"]).reshape(501, loaded["n"])
        assert x.max(axis=1) == pytest.approx(
            np.max([run.position(rod.at(s))[rows, 0] for s in np.linspace(0, 2, 65)], axis=0),
            abs=0.52 * loaded["tables"]["x"]["step"],
        )
        # The picture: a horizontal beam of its length first, hanging further down later.
        page.run("report.then(r => r.player.show(0))")
        first, across, shape = coloured_rows_and_columns(page, tmp_path / "a.png")
        metre = page.run(
            "ruler.clientWidth / parseFloat(document.getElementById('length').textContent)"
        )
        assert np.ptp(across) == pytest.approx(2.0 * metre, rel=0.03)
        assert np.ptp(first) < 0.02 * shape[0]
        page.run("slider.value = 300, slider.dispatchEvent(new Event('input'))")
        later, *_ = coloured_rows_and_columns(page, tmp_path / "b.png")
        drop = np.ptp([run.position(rod.at(s))[rows[300], 1] for s in np.linspace(0, 2, 65)])
        assert np.ptp(later) == pytest.approx(drop * metre, rel=0.03)
        assert page.run("time.textContent") == f"t = {times[300]:.4g} s"
        low, high = page.run("[low.textContent, high.textContent].map(Number)")
        limits = forces.min(), forces.max()
        assert [low, high] == pytest.approx(limits, rel=1e-3, abs=1e-6 * np.ptp(limits))
        page.run("play.click()")
        time.sleep(0.5)
        assert page.run("report.then(r => r.player.frame)") not in (0, 300)
        assert page.messages == []
        assert page.requests == [path.absolute().as_uri()]


def test_an_address_can_contain_a_time(fall, tmp_path):
    with open_page(fall[2], tmp_path / "profile", fragment="#t=0.5") as page:
        assert page.run("report.then(r => r.contents.t[r.player.frame])") == pytest.approx(0.5)
        assert page.run("time.textContent") == "t = 0.5 s"


def test_the_camera_follows_a_body(fall, tmp_path):
    run, rod, path = fall
    with open_page(path, tmp_path / "profile") as page:
        page.run(f"report.then(() => {{ follow.value = '{rod.name}' }})")
        page.run("follow.dispatchEvent(new Event('change'))")
        page.run("report.then(r => r.player.show(500))")
        target = page.run("report.then(r => r.view.controls.target.toArray())")
        start = page.run("report.then(r => (reset.click(), r.view.controls.target.toArray()))")
        s = np.linspace(0.0, 2.0, 65)
        paths = np.mean([run.position(rod.at(x))[[0, -1]] for x in s], axis=0)
        assert np.subtract(target, start)[:2] == pytest.approx(paths[1] - paths[0], abs=1e-2)


def test_without_webgl_a_sentence_is_shown(fall, tmp_path):
    options = ("--disable-3d-apis",)
    with open_page(fall[2], tmp_path / "profile", options=options) as page:
        assert page.run("report") is None
        assert "does not offer WebGL" in page.run("message.innerText")
        assert page.run("controls.offsetHeight") == 0
        assert page.run("document.querySelectorAll('figure svg').length") == 5
        assert page.messages == []


def test_notebooks_show_runs_and_scenes(fall, tmp_path):
    run = fall[0]
    assert ancf.Scene((0, -9.81))._repr_html_() is None  # without bodies
    pages = [run._repr_html_(), run.system.scene._repr_html_()]
    path = tmp_path / "notebook.html"
    path.write_text("<!DOCTYPE html><meta charset='utf-8'>" + "".join(pages), encoding="utf-8")
    with open_page(path, tmp_path / "profile") as page:
        shown = page.in_frames("report.then(r => [r.contents.t.length, r.contents.bodies.length])")
        assert sorted(shown) == [[1, 1], [200, 1]]
        assert page.messages == []


def wave(frames):
    """Return a net of 50 x 20 nodes in a travelling wave, without a simulation."""
    nodes, edges, _ = grid(50, 20)
    scene = ancf.Scene((0, 0, -9.81))
    steel = ancf.Circle(0.05), ancf.Material(1e7, 1e3)
    net = scene.add_mesh(np.pad(nodes, ((0, 0), (0, 1))), edges, "string", *steel)
    scene.pin(net.node(0))
    system = ancf.simulate(scene, 1e-3, 1e-3).system
    t = np.linspace(0.0, 10.0, frames)
    q = np.tile(system.q_ref, (frames, 1))
    places = np.array([system.point(net.node(k))[0][:, 0] for k in range(1000)])
    x, y = q[0, places[:, 0]], q[0, places[:, 1]]
    for direction, size in enumerate((0.2, 0.3, 2.0)):
        phase = 0.3 * x + 0.2 * direction * y - (1.5 + direction) * t[:, None]
        q[:, places[:, direction]] += size * np.sin(phase)
    return Trajectory(system, t, q, 0 * q, 0 * q, np.empty((frames, 0)), RunStats())


@pytest.mark.slow
def test_a_thousand_nodes_in_five_hundred_frames(tmp_path):
    path = wave(500).report(tmp_path / "net.html")
    assert path.stat().st_size < 8e6
    with open_page(path, tmp_path / "profile", size=(900, 700)) as page:
        assert page.run("report.then(r => r.contents.t.length)") == 500
        page.run("play.click()")
        drawn = page.run("report.then(r => r.player.drawn)")
        deadline = time.monotonic() + 300.0
        while page.run("report.then(r => r.player.drawn)") < drawn + 10:
            assert time.monotonic() < deadline
            time.sleep(0.1)
        assert page.messages == []
