"""Pictures with sections in their true size."""

import sys

import numpy as np
import pytest
from PIL import Image

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.problems import cantilever, pendulum
from ancfsparse.results import plotting


def box_of(path):
    """Return the ends of what is not white: left, right, top and bottom pixels."""
    with Image.open(path) as image:
        there = (np.asarray(image.convert("L")) < 250).nonzero()
    return there[1].min(), there[1].max(), there[0].min(), there[0].max(), there


def test_sections_have_their_size_and_axes_their_directions(tmp_path):
    pytest.importorskip("pyvista")
    scene, rod = cantilever(n_elements=4)
    run = ancf.simulate(scene, 0.03, 1e-3)
    left, right, top, bottom, _ = box_of(run.render(tmp_path / "a.png", time=0.0))
    diameter = 2.0 * 0.1 / np.sqrt(np.pi)
    assert (right - left) / (bottom - top) == pytest.approx(rod.length / diameter, rel=0.1)
    *_, (rows, columns) = box_of(run.render(tmp_path / "b.png", size=(500, 400)))
    assert run.position(rod.end)[-1, 1] < -0.5
    # x to the right and y upwards: where it is clamped it is highest.
    assert rows[columns == columns.min()].mean() < rows[columns == columns.max()].mean()
    with Image.open(run.render(tmp_path / "c.png", colour="strain")) as image:
        assert len(np.unique(np.asarray(image).reshape(-1, 3), axis=0)) > 500


def test_a_missing_pyvista_is_named(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyvista", None)
    # Another test may have loaded both.
    monkeypatch.delitem(sys.modules, "ancfsparse.results.plotting.rendering", raising=False)
    monkeypatch.delitem(vars(plotting), "render", raising=False)
    run = ancf.simulate(pendulum(n_elements=2).scene, 0.002, 1e-3)
    with pytest.raises(InputError, match=r"pip install 'ancfsparse\[view\]', or take run.plot"):
        run.render(tmp_path / "a.png")


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"path": "a.txt"}, "an image must end in .png or .jpg, got 'a.txt'"),
        ({"path": "no/a.png"}, "there is no folder no"),
        ({"view": "xz"}, "view must be elevation and azimuth in degrees"),
        ({"size": (3, 4)}, r"size must be two numbers of pixels such as \(1000, 750\)"),
        ({"time": 3.0}, "no state was saved at t = 3 s"),
    ],
)
def test_what_cannot_be_rendered_is_refused(options, message):
    pytest.importorskip("pyvista")
    run = ancf.simulate(pendulum(n_elements=2).scene, 0.002, 1e-3)
    with pytest.raises(InputError, match=message):
        run.render(**{"path": "a.png"} | options)
