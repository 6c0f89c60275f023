"""Simulations in a browser: the numbers of the page, who may see it, and when it ends."""

import gc
import http.client
import socket
import time
from urllib.parse import urlsplit

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from tests.results.report.browser import open_page

PATIENCE = 20.0  # s


def start():
    """Return a simulation of a rod that falls about its end, and the rod."""
    scene = ancf.Scene((0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 10, ancf.Circle(0.02), ancf.Material(1e8, 1e3))
    scene.pin(rod.start)
    box = scene.add_body(ancf.Box(length=0.2, width=0.1, height=0.1), mass=0.1, position=(1, 0))
    scene.weld(rod.end, box.origin)
    return ancf.Simulation(scene, dt=1e-3), rod, box


def wait_for(condition):
    begin = time.monotonic()
    while not condition():
        assert time.monotonic() - begin < PATIENCE
        time.sleep(0.02)


def answer(view, path=None, host=None, address="127.0.0.1"):
    """Return status and headers of the answer to a request."""
    parts = urlsplit(view.url)
    connection = http.client.HTTPConnection(address, parts.port, timeout=PATIENCE)
    connection.request("GET", path or parts.path, headers={"Host": host or parts.netloc})
    response = connection.getresponse()
    return response.status, dict(response.getheaders())


def is_refused(view, address="127.0.0.1"):
    with socket.socket() as probe:
        return probe.connect_ex((address, urlsplit(view.url).port)) != 0


def numbers_of(page):
    return page.run(
        "report.then(({contents, tables}) => ({t: contents.t[0], names: Object.fromEntries("
        "contents.live.map(([name]) => [name, [...tables[name].values]]))}))"
    )


def assert_shows(page, sim, rod, box):
    """Compare the numbers of a page with those of a simulation, to single precision."""
    wait_for(lambda: numbers_of(page)["t"] == sim.t)
    names = numbers_of(page)["names"]
    shown = np.column_stack([names["x"], names["y"]])
    exact = np.array([sim.position(rod.at(s)) for s in np.linspace(0.0, 1.0, 81)])
    assert shown.shape == exact.shape
    for one, other in ((shown, exact), (exact, shown)):
        distances = np.linalg.norm(one[:, None] - other[None], axis=2).min(axis=1)
        assert distances.max() < 2e-7
    force = sim.section_force(rod).N
    assert names["N"] == pytest.approx(force, rel=1e-6, abs=1e-6 * np.abs(force).max())
    assert names["origin 0"] == pytest.approx(sim.position(box.origin), abs=1e-7)
    assert page.run("time.textContent") == f"t = {sim.t:.4g} s"


def test_a_page_shows_the_numbers_of_the_simulation(tmp_path):
    sim, rod, box = start()
    with sim.view() as view:
        sim.step(20)
        with open_page(view.url, tmp_path / "profile") as page:
            assert page.run("report.then(r => r.view.renderer.info.render.triangles)") > 100
            assert_shows(page, sim, rod, box)
            sim.step(150)
            assert_shows(page, sim, rod, box)
            for _ in range(130):
                sim.step()
            assert_shows(page, sim, rod, box)
            before = page.run("report.then(r => r.player.drawn)")
            sim.run_real_time(1.3)
            wait_for(lambda: page.run("report.then(r => r.player.drawn)") >= before + 4)
            assert_shows(page, sim, rod, box)
            low, high = page.run("report.then(r => r.contents.box)")
            assert low[1] < sim.position(rod.end)[1]
            assert high[0] > 1.0
            assert page.run("[slider, play].some(each => !each.hidden)") is False
            view.close()
            sim.step()
            wait_for(lambda: is_refused(view))
            page.run("new Promise(r => setTimeout(r, 300))")
            assert page.messages == []
            assert set(page.requests) == {view.url, f"{view.url}frames"}


def test_without_webgl_a_sentence_is_shown(tmp_path):
    sim, _, _ = start()
    with sim.view() as view:
        options = ("--disable-3d-apis",)
        with open_page(view.url, tmp_path / "profile", options=options) as page:
            assert page.run("report") is None
            text = page.run("message.innerText")
            assert "does not offer WebGL" in text
            assert "Graphs" not in text


def test_only_this_computer_sees_the_page():
    sim, _, _ = start()
    with sim.view() as view:
        status, headers = answer(view)
        assert status == 200
        assert not any(name.lower().startswith("access-control") for name in headers)
        port = urlsplit(view.url).port
        assert answer(view, host=f"localhost:{port}")[0] == 200
        assert answer(view, host=f"example.org:{port}")[0] == 403
        assert answer(view, host="127.0.0.1:1")[0] == 403
        for path in ("/", "/frames", f"{urlsplit(view.url).path}../", "/x/"):
            assert answer(view, path=path)[0] == 404
        assert is_refused(view, "127.0.0.2")  # bound to one address
        assert view.url in repr(view)
        assert f'src="{view.url}"' in view._repr_html_()
        assert sim.view().url != view.url


def test_a_view_ends_with_the_simulation():
    sim, _, _ = start()
    view = sim.view()
    assert not is_refused(view)
    del sim
    gc.collect()
    wait_for(lambda: is_refused(view))
    assert repr(view) == "LiveView: closed"
    view.close()  # again


def test_steps_are_the_same_with_a_view():
    (one, *_), (other, *_) = start(), start()
    view = other.view()
    seen = []
    other.on_step(lambda sim: seen.append(sim.steps), every=7)
    for n in (1, 1, 13, 200):
        one.step(n)
        other.step(n)
    assert np.array_equal(one.q, other.q)
    assert seen == list(range(7, 216, 7))
    before = other.snapshot()
    other.step(5)
    other.restore(before)
    view.close()
    assert not [each for each in other._calls if each is view]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"fps": 0}, "fps must be an integer of at least 1, got 0"),
        ({"fps": 1000}, "fps must be at most 100, got 1000"),
        ({"port": -1}, "port must be a number from 0 to 65535, got -1"),
        ({"port": "80"}, "port must be a number from 0 to 65535, got '80'"),
        ({"browser": "firefox"}, "browser must be True or False"),
    ],
)
def test_invalid_arguments_are_refused(options, message):
    sim, _, _ = start()
    with pytest.raises(InputError, match=message):
        sim.view(**options)


def test_a_port_in_use_is_named():
    sim, _, _ = start()
    with sim.view() as view:
        port = urlsplit(view.url).port
        with pytest.raises(InputError, match=rf"port {port} of 127\.0\.0\.1 cannot be used"):
            sim.view(port=port)
    assert sim._calls == []
