"""Obstacles in pictures and files of runs."""

import numpy as np
import pytest
from PIL import Image

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.results.geometry.obstacle_outlines import trace_obstacle
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.results.geometry.wireframe import trace_edges
from ancfsparse.results.hdf5_reader import read_outline
from ancfsparse.results.plotting.canvas import OBSTACLE_WIDTH
from tests.results.conftest import damage_outline
from tests.system.contributions.shapes import ORIENTED, lowered

pytestmark = pytest.mark.usefixtures("close_figures")
SECTION, MATERIAL = ancf.Circle(0.02), ancf.Material(1e7, 1000.0)


def touching(*obstacles, path=None, n=8):
    """A cable of 1 m at a height of 0.3 m, and its run next to some obstacles."""
    dim = obstacles[0].dim if obstacles else 2
    scene = ancf.Scene((0.0, 0.0, -9.81)[3 - dim :])
    up, across = np.eye(dim)[-1], np.eye(dim)[1] * (dim - 2)
    for k in range(dim - 1):
        start = 0.3 * up + 0.4 * k * across
        cable = scene.add_beam("thin", start, start + np.eye(dim)[0], n, SECTION, MATERIAL)
        for obstacle in obstacles:
            scene.contact(cable, obstacle, stiffness=1e3)
    return ancf.simulate(scene, 0.02, 1e-2, output=path)


def segments(ax):
    """Return the lines of the obstacles in axes, (n, 2, 2)."""
    (artist,) = (c for c in ax.collections if c.get_linewidths()[0] == OBSTACLE_WIDTH)
    return np.array(artist.get_segments())


@pytest.mark.parametrize("kind", [ancf.Drum, ancf.Ball])
def test_a_round_obstacle_is_a_circle_in_full(kind):
    ax = touching(kind((0.4, 0.0), 0.25)).plot()
    points = segments(ax).reshape(-1, 2)
    np.testing.assert_allclose(np.linalg.norm(points - (0.4, 0.0), axis=1), 0.25)
    np.testing.assert_allclose(np.ptp(points, axis=0), 0.5)
    assert ax.get_ylim()[0] < -0.25


def test_a_large_one_is_cut_at_the_picture():
    free, ax = touching().plot(), touching(ancf.Ball((0.5, -50.0), 50.2)).plot()
    assert (ax.get_xlim(), ax.get_ylim()) == (free.get_xlim(), free.get_ylim())
    np.testing.assert_allclose(segments(ax)[..., 0].min(), ax.get_xlim()[0])
    np.testing.assert_allclose(segments(ax)[..., 0].max(), ax.get_xlim()[1])


@pytest.mark.parametrize("normal", [(0, 1), (-0.05, 1), (-1, 0)])
def test_a_half_space_is_a_line_and_strokes_behind_it_and_does_not_enlarge_the_view(normal):
    base = (1.02, 0.2)
    free, ax = touching().plot(), touching(ancf.HalfSpace(base, normal)).plot()
    limits = np.array([ax.get_xlim(), ax.get_ylim()]).T
    np.testing.assert_array_equal(limits, np.array([free.get_xlim(), free.get_ylim()]).T)
    drawn = segments(ax)
    distances = (drawn - base) @ normal
    np.testing.assert_allclose(distances[0], 0.0, atol=1e-12)
    assert (distances[1:, 1] < 0.0).sum() > 5
    assert distances.max() < 1e-12
    assert ((drawn > limits[0] - 1e-12) & (drawn < limits[1] + 1e-12)).all()
    # The line ends at the picture.
    ends = np.isclose(drawn[0], limits[0]) | np.isclose(drawn[0], limits[1])
    assert ends.any(axis=1).all()


def test_one_outside_the_picture_is_left_out():
    ax = touching(ancf.HalfSpace((0.0, -5.0), (0, 1))).plot()
    assert len(ax.collections) == len(touching().plot().collections)


def test_a_radius_turns_with_a_drum(tmp_path):
    run = touching(ancf.Drum((0.4, 0.0), 0.2, angular_velocity=100.0))
    spoke = segments(run.plot(times=[0.01]))[-1]
    np.testing.assert_allclose(spoke, [(0.4, 0.0), (0.4 + 0.2 * np.cos(1), 0.2 * np.sin(1))])
    assert run.animate(tmp_path / "run.gif", seconds=0.2, fps=10, dpi=30).exists()


def test_in_space_a_drum_is_as_long_as_the_bodies_and_turns_by_the_right_hand_rule():
    drum = ancf.Drum((0.4, 7.0, 0.0), 0.2, axis=(0, -2, 0), angular_velocity=100.0)
    run = touching(drum)
    scene = run.plot(times=[0.01], view="xz")
    lines = segments(scene)
    points = lines.reshape(-1, 2) - (0.4, 0.0)
    assert np.linalg.norm(points, axis=1).max() < 0.2 * (1 + 1e-9)
    # About -y: from z to -x, or from x to z.
    start, end = (make_outline(run.system).obstacles[0].spin @ np.eye(3)[0])[[0, 2]], points[-1]
    np.testing.assert_allclose(start, (0.0, 100.0), atol=1e-12)
    turned = np.eye(2)[0] * np.cos(1) + np.eye(2)[1] * np.sin(1)
    np.testing.assert_allclose(end, 0.2 * turned)
    ends = segments(run.plot(view="yz"))[..., 0]
    np.testing.assert_allclose([ends.min(), ends.max()], [0.0, 0.4], atol=1e-12)
    assert run.plot().name == "3d"


def test_in_space_a_ball_is_great_circles_and_a_half_space_a_grid():
    lines = segments(touching(ancf.Ball((0.4, 0.2, 0.0), 0.2)).plot(view="xz"))
    distances = np.linalg.norm(lines.reshape(-1, 2) - (0.4, 0.0), axis=1)
    assert distances.max() == pytest.approx(0.2)
    run = touching(ancf.HalfSpace((0.0, 0.0, 0.25), (0, 0, 1)))
    grid = segments(run.plot(view="xy"))
    # Cables from x = 0 to 1 at y = 0 and 0.4, with a margin of 0.06.
    np.testing.assert_allclose(grid.min(axis=(0, 1)), (-0.06, -0.06), atol=1e-12)
    np.testing.assert_allclose(grid.max(axis=(0, 1)), (1.06, 0.46), atol=1e-12)
    np.testing.assert_allclose(segments(run.plot(view="xz"))[..., 1], 0.25)


def test_a_body_has_its_obstacles_in_files_too(tmp_path):
    obstacles = [
        ancf.Drum((0.4, 0.0), 0.2),
        ancf.HalfSpace((0, -1), (0, 2)),
        ancf.Ball((1, 0), 0.1),
        ancf.Capsule((0.2, 0.0), (0.6, 0.1), 0.1),
        ancf.Block((0.4, 0.0), (0.5, 0.3), 0.05, 0.2),
        ancf.Torus((0.4, -0.2), 0.15, 0.05),
    ]
    run = touching(*obstacles, path=tmp_path / "run.h5")
    assert make_outline(run.system).obstacles == obstacles
    assert make_outline(run.system, run.system.bodies[0]).obstacles == obstacles
    assert read_outline(tmp_path / "run.h5")[0].obstacles == obstacles
    damage_outline(tmp_path / "run.h5", "obstacles", lambda table: table[:-1])
    with pytest.raises(InputError, match="its outline is lost"):
        read_outline(tmp_path / "run.h5")


@pytest.mark.parametrize(
    "obstacle",
    [
        ancf.Ball((0.5, 0.0), 0.2),
        ancf.HalfSpace((0.0, 0.0, 0.25), (0, 0, 1)),
        ancf.Torus((0.5, 0.0, 0.0), 0.15, 0.05, (1, 0, 1)),
    ],
)
def test_obstacles_are_rendered(tmp_path, obstacle):
    pytest.importorskip("pyvista")
    with Image.open(touching(obstacle, n=16).render(tmp_path / "a.png")) as image:
        grey = np.abs(np.asarray(image.convert("RGB")).astype(int) - 0x99).max(axis=2) < 16
    assert grey.sum() > 200


@pytest.mark.parametrize(
    "obstacle",
    [
        ancf.Capsule((0.2, 0.0), (0.6, 0.1), 0.1),
        ancf.Block((0.4, 0.0), (0.5, 0.3), 0.05, 0.2),
        ancf.Block((0.4, 0.0), (0.5, 0.3)),
        ancf.Torus((0.4, 0.0), 0.15, 0.05),
        ancf.Capsule((0.2, 0.1, 0.0), (0.6, 0.3, 0.1), 0.1),
        ancf.Block((0.4, 0.2, 0.0), (0.5, 0.3, 0.4), 0.05, (0.8, 0, 0.6, 0)),
        ancf.Block((0.4, 0.2, -0.3), (0.5, 0.3, 0.4), orientation=(0.8, 0, 0.6, 0)),
        ancf.Torus((0.4, 0.2, 0.0), 0.15, 0.05, (1, 0, 1)),
    ],
)
def test_lines_of_shapes_are_on_their_surface_and_follow_a_body(obstacle):
    lines = trace_obstacle(obstacle, np.zeros((2, obstacle.dim)), np.zeros((2, obstacle.dim)))
    assert np.abs(obstacle.distances(lines[:, 0])).max() < 1e-12
    assert np.abs(obstacle.distances(lines[:, 1])).max() < 1e-12
    # In the middle of a piece of a circle by its sagitta off.
    middles = obstacle.distances(lines.mean(axis=1))
    assert np.abs(middles).max() < 0.2001 * (1.0 - np.cos(np.pi / 64))
    # On a body that turns it turns, too.
    dim = obstacle.dim
    scene = ancf.Scene((0.0,) * dim)
    cable = scene.add_beam("thin", 9 * np.eye(dim)[1], np.ones(dim), 100, SECTION, MATERIAL)
    turn = 0.3 if dim == 2 else (0.8, 0.6, 0, 0)
    spin = 2.0 if dim == 2 else (0, 0, 2.0)
    inertia = 1.0 if dim == 2 else (1.0, 1.0, 1.0)
    body = scene.add_body(
        mass=1.0,
        inertia=inertia,
        position=0.1 * np.ones(dim),
        orientation=turn,
        angular_velocity=spin,
    )
    scene.contact(cable, obstacle, on=body, stiffness=1e3)
    run = ancf.simulate(scene, 0.1, 1e-2, integrator=ancf.EnergyMomentum())
    (outline,) = [s for s in make_outline(run.system).solids if s.form == "lines"]
    drawn = trace_edges(run.q[[0, -1]], outline)
    np.testing.assert_allclose(drawn[0], lines, atol=1e-12)
    c, s = np.cos(0.2), np.sin(0.2)
    matrix = np.eye(dim)
    matrix[:2, :2] = [[c, -s], [s, c]]
    np.testing.assert_allclose(drawn[1], (lines - 0.1) @ matrix.T + 0.1, atol=1e-4)


@pytest.mark.parametrize("name", ["mesh", "profile"])
def test_the_edges_of_a_mesh_and_the_heights_of_a_field_are_drawn(name, tmp_path):
    obstacle = lowered(ORIENTED[name], 0.05)
    lines = trace_obstacle(obstacle, np.zeros((2, obstacle.dim)), np.zeros((2, obstacle.dim)))
    # Euler: 6^2 facets on each of eight sides have 3/2 as many edges.
    assert len(lines) == {"mesh": 8 * 36 * 3 // 2, "profile": 40}[name]
    assert np.abs(obstacle.distances(lines[:, 0])).max() < 0.1 * obstacle.cell
    run = touching(obstacle, path=tmp_path / "run.h5")
    assert len(segments(run.plot(view="xy" if obstacle.dim == 3 else None))) == len(lines)
    assert read_outline(tmp_path / "run.h5")[0].obstacles == [obstacle]
