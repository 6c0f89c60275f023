"""Ropes, springs, distances, masses and loads in pictures and files of runs, and their labels."""

from itertools import combinations

import numpy as np
import pytest
from matplotlib.quiver import Quiver
from PIL import Image

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.results.hdf5_reader import read_outline
from ancfsparse.results.plotting.traced_scene import clip_lines
from tests.beams import build_beam
from tests.results.conftest import damage_outline

pytestmark = pytest.mark.usefixtures("close_figures")
SECTION, MATERIAL = ancf.Circle(0.02), ancf.Material(1e9, 1000.0)


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


def test_masses_and_loads_are_drawn_where_they_act(tmp_path):
    scene, rod = build_beam("thin", (0, 0), (1, 0), 4, SECTION, MATERIAL, "clamp")
    scene.add_mass(rod.end, 0.2)
    scene.point_force(rod.at(0.3), (0.0, -2.0))
    scene.point_force(rod.node(1), (0.0, 1.0), follow=True)
    scene.point_moment(rod.node(3), -0.1)
    scene.distributed_force(rod, (0.5, 0.0), shape=lambda s: s - 0.5)
    scene.force(rod.node(2), lambda q, v, t: -0.1 * v)
    run = ancf.simulate(scene, 0.01, 1e-3, output=tmp_path / "run.h5")
    scene.point_force(rod.end, (0.0, -9.0))  # after the run
    _, *marks = make_outline(run.system).supports
    kinds = ["mass", "force", "force", "force", "moment", *["force"] * 5]
    assert [each.kind for each in marks] == kinds
    directions = [each.other.tolist() for each in marks[1:]]
    line = [[-1.0, 0.0], [-1.0, 0.0], [0.0, 0.0], [1.0, 0.0], [1.0, 0.0]]
    assert directions == [[0, 0], [0, -1], [0, 0], [-1, 0], *line]
    again, *_ = read_outline(tmp_path / "run.h5")
    assert [each.kind for each in again.supports] == ["clamp", *kinds]
    ax = run.plot(times=[0.01])
    (arrows,) = (each for each in ax.collections if isinstance(each, Quiver))
    np.testing.assert_allclose(arrows.XY[0], run.position(rod.at(0.3))[-1], atol=1e-12)
    drawn = [tuple(np.column_stack(each.get_data())[0]) for each in ax.lines]
    for point in (rod.end, rod.node(3), rod.node(2)):
        assert tuple(run.position(point)[-1]) in drawn
    assert run.animate(tmp_path / "run.gif", seconds=0.2, fps=10, dpi=30).exists()


@pytest.mark.parametrize("hold", ["rod", "spring"])
@pytest.mark.parametrize(("distance", "is_cut"), [(5.0, False), (300.0, True)])
def test_a_far_anchor_does_not_shrink_the_picture(hold, distance, is_cut):
    scene, rod = build_beam("thin", (0, 0), (1, 0), 4, SECTION, MATERIAL, "clamp")
    anchor = (1.0, distance)
    if hold == "rod":
        scene.rod(rod.end, anchor)
    else:
        scene.spring(rod.end, anchor, stiffness=1.0)
    ax = ancf.simulate(scene, 0.01, 1e-3).plot()
    assert (ax.get_ylim()[1] > distance) == (not is_cut)
    assert ax.get_ylim()[1] < 12.0


def test_lines_are_cut_at_a_box():
    low, high = np.zeros(2), np.ones(2)
    lines = np.array(
        [
            [(0.1, 0.3), (0.7, 0.2)],  # inside
            [(0.5, 0.5), (0.5, 3.0)],  # along an axis
            [(-1.0, -1.0), (2.0, 2.0)],  # through
            [(2.0, 0.0), (2.0, 1.0)],  # outside
            [(0.5, 0.5), (0.5, 0.5)],  # a point
        ]
    )
    cut = clip_lines(lines, low, high)
    np.testing.assert_array_equal(cut[0], lines[0])
    np.testing.assert_allclose(cut[1], [(0.5, 0.5), (0.5, 1.0)])
    np.testing.assert_allclose(cut[2], [(0.0, 0.0), (1.0, 1.0)])
    assert np.isnan(cut[3]).all()
    np.testing.assert_array_equal(cut[4], lines[4])


@pytest.mark.parametrize(
    ("start", "end", "diameter"),
    [
        ((0, 0, 0), (2, 0, 0), 0.02),
        ((1234.5, 0, 0), (1236.5, 0.1, 0), 0.02),
        ((0, 0, 0), (0.02, 0, 2e-5), 2e-3),
        ((0, 0, 0), (1, 1, 1), 0.02),
        ((0, 0, 0), (300, 200, 3), 1.0),
        ((0, 0, 0), (1e-5, 4, 3), 0.02),
        ((0, 0, 0), (0.1, 0.1, 3), 0.02),
        ((0, 0, 0), (0.5, 0, -120), 0.5),
        ((0, 0, 0), (0.1, 5, 0.2), 0.02),
    ],
)
def test_labels_in_perspective_do_not_overlap(start, end, diameter):
    made = ancf.Circle(diameter), ancf.Material(1e8, 1000.0)
    scene, _ = build_beam("thick", start, end, 6, *made, "pin", gravity=(0, 0, -9.81))
    ax = ancf.simulate(scene, 0.02, 1e-4).plot(view=(22.0, -60.0))
    figure = ax.figure
    figure.canvas.draw()
    axes = (ax.xaxis, ax.yaxis, ax.zaxis)
    boxes = [axis.label.get_window_extent() for axis in axes]
    for axis in axes:
        low, high = axis.get_view_interval()
        ticks = [each.label1 for each in axis.get_major_ticks() if low <= each.get_loc() <= high]
        boxes += [each.get_window_extent() for each in ticks if each.get_text()]
    legend = ax.get_legend().get_window_extent()
    width, height = figure.canvas.get_width_height()
    for box in boxes:
        assert 0 <= box.x0 <= box.x1 <= width
        assert 0 <= box.y0 <= box.y1 <= height
        assert not legend.overlaps(box)
    for one, other in combinations(boxes, 2):
        assert not one.padded(-2).overlaps(other)
