"""Ropes, springs and distances are drawn between their points, and kept in files of runs."""

import numpy as np
import pytest
from PIL import Image

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.results.hdf5_reader import read_outline
from tests.results.conftest import damage_outline

pytestmark = pytest.mark.usefixtures("close_figures")


def tied(dim, path=None):
    """A box on a spring, with a rope over a fixed point to a beam, a distance and a winch."""
    scene = ancf.Scene((0.0, 0.0, -9.81)[3 - dim :])
    up = np.eye(dim)[-1]
    box = scene.add_body(
        ancf.Box(length=0.4, width=0.2, height=0.2), mass=1.0, position=np.zeros(dim)
    )
    bob = scene.add_body(ancf.Sphere(0.1), mass=0.1, position=-0.5 * up)
    load = scene.add_body(ancf.Sphere(0.1), mass=0.1, position=1.5 * np.eye(dim)[0])
    start = 2.0 * np.eye(dim)[0]
    material = ancf.Material(1e8, 1e3)
    beam = scene.add_beam("thin", start, start + np.eye(dim)[0], 2, ancf.Circle(0.02), material)
    scene.clamp(beam.start)
    corner = box.at(np.r_[0.2, np.zeros(dim - 2), 0.1])
    scene.spring(box.origin, 2.0 * up, stiffness=50.0)
    scene.rope([corner, start + up, beam.end], stiffness=1e3)
    scene.distance(box.origin, bob.origin)
    scene.winch([load.origin, start + 2.0 * up])
    run = ancf.simulate(scene, 0.2, 2e-3, output=path)
    at = 100
    places = [run.position(node)[at] for node in (box.origin, corner, beam.end, bob.origin)]
    origin, edge, end, hung = places
    top, pulled = start + 2.0 * up, run.position(load.origin)[at]
    expected = [(origin, hung), (pulled, top), (origin, 2.0 * up), (edge, start + up),
                (start + up, end)]  # fmt: skip
    return scene, run, np.array(expected)


@pytest.mark.parametrize("dim", [2, 3])
def test_lines_are_where_their_points_are(dim, tmp_path):
    _, run, expected = tied(dim, tmp_path / "run.h5")
    drawn = make_outline(run.system).links
    np.testing.assert_allclose(drawn.ends(run.q[100:101])[0], expected, atol=1e-12)
    np.testing.assert_array_equal(drawn.springs, [False, False, True, False, False])
    outline, _, q, _ = read_outline(tmp_path / "run.h5")
    np.testing.assert_array_equal(outline.links.springs, drawn.springs)
    np.testing.assert_array_equal(outline.links.ends(q), drawn.ends(run.q))


def test_a_picture_has_ropes_in_full_lines_and_springs_in_dashes(tmp_path):
    _, run, expected = tied(2)
    *_, ropes, springs = run.plot(times=[0.2]).collections
    np.testing.assert_allclose(ropes.get_segments(), expected[[0, 1, 3, 4]], atol=1e-12)
    np.testing.assert_allclose(springs.get_segments(), expected[[2]], atol=1e-12)
    assert ropes.get_linestyle()[0][1] is None
    assert springs.get_linestyle()[0][1] is not None
    # The fixed ends of ropes are inside the picture too.
    assert springs.axes.get_ylim()[1] > 2.0


def test_ropes_are_rendered(tmp_path):
    pytest.importorskip("pyvista")
    shares = []
    for stiff in (False, True):
        scene = ancf.Scene((0.0, -9.81))
        for x in (0.0, 1.0):
            scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(x, 0.0))
        if stiff:
            scene.distance(*(body.origin for body in scene.bodies))
        run = ancf.simulate(scene, 0.01, 1e-2)
        with Image.open(run.render(tmp_path / "a.png")) as image:
            shares.append((np.asarray(image.convert("L")) < 250).mean())
    assert shares[1] > 1.02 * shares[0]


def test_what_is_added_after_a_run_is_not_in_its_pictures():
    scene, run, _ = tied(2)
    scene.spring(scene.bodies[0].origin, (1.0, 1.0), stiffness=1.0)
    assert len(make_outline(run.system).links) == 5


def test_lines_are_those_of_whole_scenes():
    _, run, _ = tied(2)
    assert len(make_outline(run.system, run.system.bodies[0]).links) == 0


@pytest.mark.parametrize("lost", ["link weights", "link fixed", "link springs"])
def test_damaged_lines_are_refused(tmp_path, lost):
    path = tmp_path / "run.h5"
    tied(2, path)
    damage_outline(path, lost, lambda table: None if lost == "link springs" else table[:-1])
    with pytest.raises(InputError, match="its outline is lost"):
        read_outline(path)


@pytest.mark.parametrize(
    "size", [(1, 1, 1), (1, 0.3, 0.2), (0.3, 0.3, 1), (0.3, 1, 0.3), (4, 4, 1)]
)
def test_all_labels_of_pictures_in_perspective_are_inside(size):
    scene = ancf.Scene((0.0, 0.0, -9.81))
    scene.add_body(
        ancf.Box(length=size[0], width=size[2], height=size[1]), mass=1.0, position=(0, 0, 0)
    )
    ax = ancf.simulate(scene, 1e-3, 1e-3).plot(times=[0.0])
    for part in (ax.set_title("title"), ax.xaxis, ax.yaxis, ax.zaxis):
        ax.figure.canvas.draw()
        box = part.get_tightbbox(ax.figure.canvas.get_renderer())
        assert (box.min >= 0.0).all(), part
        assert (box.max <= ax.figure.bbox.max).all(), part
