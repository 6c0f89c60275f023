"""Pictures and films show the numbers of a run, and refuse what they cannot show."""

import sys
from itertools import pairwise

import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.problems import elastica, lattice, pendulum
from tests.beams import build_beam

pytestmark = pytest.mark.usefixtures("close_figures")


@pytest.fixture(scope="module")
def swing():
    scene, rod = pendulum(n_elements=4)
    return ancf.simulate(scene, 0.5, 5e-3), rod


@pytest.fixture(scope="module")
def arm():
    """Two beams with a hinge between them, clamped at one end, held by a rod at the other."""
    scene = ancf.Scene()
    material = ancf.Material(1e8, 4e3)
    a = scene.add_beam("thin", (0, 0), (2, 0), 4, ancf.Circle(0.02), material)
    b = scene.add_beam("thin", (3, 1), (2, 0), 4, ancf.Circle(0.02), material)
    scene.connect(a.end, b.end)
    scene.clamp(a.start)
    scene.rod(b.start, (3.5, 2.0))
    return ancf.simulate(scene, 0.2, 5e-3), a, b


@pytest.fixture(scope="module")
def cube():
    scene, mesh = lattice(3)
    return ancf.simulate(scene, 0.05, 5e-3), mesh


def test_shapes_of_all_bodies_and_their_supports(arm):
    run, a, b = arm
    ax = run.plot(times=[0.0, 0.1])
    assert len(ax.collections) == 4  # two bodies at two instants
    last = ax.collections[-1].get_segments()
    assert len(last) == b.n_elements
    k = int(np.argmin(np.abs(run.t - 0.1)))
    np.testing.assert_allclose(last[0][0], run.position(b.start)[k], atol=1e-12)
    np.testing.assert_allclose(last[-1][-1], run.position(b.end)[k], atol=1e-12)
    drawn = np.concatenate([line.get_xydata() for line in ax.lines])
    for place in (a.start.position, (3.5, 2.0), run.position(b.start)[k]):
        assert np.abs(drawn - place).sum(axis=1).min() < 1e-12
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["0 s", "0.1 s"]
    assert ax.get_aspect() == 1.0
    assert len(run.plot(of=a).collections) == 6


def test_a_support_that_moves_is_drawn_where_it_is():
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), 3, ancf.Circle(0.02), ancf.Material(1e8, 4e3))
    scene.drive(rod.start, lambda t: (3.0 * t**2, t**2))
    run = ancf.simulate(scene, 0.1, 1e-3)
    drawn = np.concatenate([line.get_xydata() for line in run.plot().lines])
    np.testing.assert_allclose(drawn, [[0.03, 0.01]], atol=1e-9)


def test_all_that_moves_is_inside_the_picture(cube):
    run, mesh = cube
    ax = run.plot()
    places = np.concatenate([run.position(mesh.node(i)) for i in range(mesh.n_nodes)])
    for k, name in enumerate("xyz"):
        low, high = getattr(ax, f"get_{name}lim")()
        assert low < places[:, k].min()
        assert places[:, k].max() < high
        assert getattr(ax, f"get_{name}label")() == f"{name} [m]"
    ax.figure.canvas.draw()


def test_what_stays_in_a_plane_is_drawn_in_it():
    scene, _ = pendulum("thick", 4)
    run = ancf.simulate(scene, 0.05, 1e-3)
    ax = run.plot()
    assert (ax.get_xlabel(), ax.get_ylabel(), ax.name) == ("x [m]", "y [m]", "rectilinear")
    assert run.plot(view=(30, 40)).name == "3d"
    # Gravity along y points down: x is third in a cyclic order that ends with y.
    assert run.plot(view=(30, 40)).get_zlabel() == "y [m]"
    assert run.plot(view="xz").get_ylabel() == "z [m]"
    assert ancf.solve_static(elastica(0.0, dim=3).scene).plot().name == "rectilinear"


def test_quantities_over_time_and_along_a_beam(swing):
    run, rod = swing
    x, y = run.plot("velocity", rod.end).lines
    np.testing.assert_array_equal(x.get_ydata(), run.velocity(rod.end)[:, 0])
    np.testing.assert_array_equal(y.get_ydata(), run.velocity(rod.end)[:, 1])
    ax = run.plot("N", rod.at(0.3))
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), run.section_force(rod, 0.3).N[:, 0])
    assert ax.get_ylabel() == "axial force [N]"
    ax = run.plot("M", rod, times=[0.25])
    np.testing.assert_allclose(ax.lines[0].get_xdata(), [0, 0.25, 0.75, 1.25, 1.75, 2])
    arcs = [0.0, 0.25, 0.75, 1.25, 1.75, 2.0]
    np.testing.assert_array_equal(ax.lines[0].get_ydata(), run.section_force(rod, arcs).M[50])
    assert len(run.plot("strain", rod, times=[0.25]).lines[0].get_xdata()) == 4
    energy = {line.get_label(): line.get_ydata() for line in run.plot("energy").lines}
    np.testing.assert_array_equal(energy["total"], run.energy.total)
    assert "dissipated" not in energy


def test_components_in_space_are_named():
    scene, rod = pendulum("thick", 2)
    run = ancf.simulate(scene, 0.01, 1e-3)
    names = [line.get_label() for line in run.plot("curvature", rod.at(0.1)).lines]
    assert names == ["twist", "about y", "about z"]
    assert [line.get_label() for line in run.plot("Q", rod, times=0.01).lines] == [
        "0.01 s, y",
        "0.01 s, z",
    ]


def test_equilibrium_beside_its_reference():
    scene, rod = elastica(2.0, n_elements=4)
    rest = ancf.solve_static(scene)
    before, after, _ = rest.plot().collections  # and the force
    np.testing.assert_allclose(before.get_segments()[-1][-1], rod.end.position, atol=1e-12)
    np.testing.assert_allclose(after.get_segments()[-1][-1], rest.position(rod.end), atol=1e-12)
    moments = rest.plot("M", rod).lines[0].get_ydata()
    np.testing.assert_array_equal(moments[1:-1], rest.section_force(rod).M)


@pytest.mark.parametrize("element", ["thin", "thick", "l2t2"])
def test_forces_along_a_beam_are_drawn_from_end_to_end(element):
    """The weight of a cantilever and its load bend it most at the wall, by 31.54 N m."""
    made = ancf.Rectangle(0.03, 0.03), ancf.Material(7e10, 2700)
    scene, rod = build_beam(element, (0, 0), (1, 0), 4, *made, "clamp")
    scene.add_mass(rod.end, 2.0)
    rest = ancf.solve_static(scene)
    line = rest.plot("M", rod).lines[0]
    assert line.get_xdata()[[0, -1]].tolist() == [0.0, 1.0]
    exact = 2.0 * 9.81 + 2700 * 9e-4 * 9.81 / 2
    assert line.get_ydata()[0] == pytest.approx(-exact, rel=5e-3)
    assert rest.plot("Q", rod).lines[0].get_xdata()[-1] == 1.0


def test_a_film_has_a_picture_for_each_instant(arm, tmp_path):
    run, _, b = arm
    options = {"seconds": 0.4, "fps": 10, "dpi": 40, "trace": [b.end], "progress": False}
    path = run.animate(tmp_path / "arm.gif", **options)
    with Image.open(path) as film:
        assert film.n_frames == 4
        assert film.info["duration"] == 100
        pictures = []
        for k in range(film.n_frames):
            film.seek(k)
            pictures.append(np.asarray(film.convert("RGB")))
    assert all((one != other).any() for one, other in pairwise(pictures))
    again = run.animate(tmp_path / "again.gif", **options)
    assert path.read_bytes() == again.read_bytes()
    assert not plt.get_fignums()


def test_a_film_in_space_shows_its_progress(cube, tmp_path, capsys, monkeypatch):
    run, _ = cube
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    path = run.animate(tmp_path / "cube.gif", seconds=0.2, fps=10, dpi=40)
    assert path.stat().st_size > 1000
    assert "/2 [" in capsys.readouterr().err


def test_a_film_needs_ffmpeg_for_mp4(swing, tmp_path, monkeypatch):
    run, _ = swing
    monkeypatch.setattr(
        "ancfsparse.results.plotting.animation.FFMpegWriter.isAvailable",
        classmethod(lambda _: False),
    )
    with pytest.raises(InputError, match=r"needs the program ffmpeg.*or write a GIF, '.*a\.gif'"):
        run.animate(tmp_path / "a.mp4")


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda run, rod: run.plot("speed"), "what to plot"),
        (
            lambda run, rod: run.plot("position"),
            "position is a quantity of a point, such as rod.end",
        ),
        (lambda run, rod: run.plot("N"), "N is evaluated along a beam of the run or, over time"),
        (lambda run, rod: run.plot("T", rod), "beam 0 has no torsion: it is planar"),
        (lambda run, rod: run.plot("energy", rod), "energies are of the entire scene"),
        (lambda run, rod: run.plot("N", rod, view="xy"), "view is for shapes"),
        (lambda run, rod: run.plot("N", rod.end, times=[0]), "is plotted over all times"),
        (lambda run, rod: run.plot("shape", rod.end), "a point has no shape"),
        (
            lambda run, rod: run.plot("shape", 3),
            "a beam, a mesh or a rigid body of the run is needed, got 3",
        ),
        (lambda run, rod: run.plot("shape", pendulum().rod), "is not part of this scene"),
        (lambda run, rod: run.plot(times=[9.0]), "no state was saved at t = 9 s"),
        (lambda run, rod: run.plot(times=[]), "times must be a list such as"),
        (lambda run, rod: run.plot(view="xz"), "view must name two of 'xy', got 'xz'"),
        (lambda run, rod: run.plot(view=(20, 30)), "the scene is planar"),
        (lambda run, rod: run.plot(view=20), "view must be a plane such as 'xz', or elevation"),
        (lambda run, rod: run.plot(ax=3), "ax must be axes of matplotlib, got 3"),
        (lambda run, rod: run.plot("energy", ax=3), "ax must be axes of matplotlib, got 3"),
        (
            lambda run, rod: run.animate("a.avi"),
            "an animation must end in .gif or .mp4, got 'a.avi'",
        ),
        (lambda run, rod: run.animate("nowhere/a.gif"), "there is no folder nowhere"),
        (lambda run, rod: run.animate("a.gif", seconds=-1), "seconds of an animation must be"),
        (lambda run, rod: run.animate("a.gif", trace=[3]), "a trace needs a point on a beam"),
    ],
)
def test_what_cannot_be_drawn_is_refused(swing, call, message):
    with pytest.raises(InputError, match=message):
        call(*swing)


def test_a_run_of_chosen_points_cannot_be_drawn():
    scene, rod = pendulum(n_elements=4)
    run = ancf.simulate(scene, 0.01, 1e-3, save_nodes=[rod.end])
    with pytest.raises(InputError, match="the run did not keep this"):
        run.plot()
    assert len(run.plot("position", rod.end).lines) == 2


def test_what_is_added_to_the_scene_after_a_run_is_not_in_its_pictures(tmp_path):
    scene = ancf.Scene((0.0, -9.81))
    section, material = ancf.Circle(0.01), ancf.Material(1e8, 1e3)
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, section, material)
    scene.clamp(rod.start)
    run, rest = ancf.simulate(scene, 2e-3, 1e-3), ancf.solve_static(scene)
    scene.add_beam("thin", (2, 0), (3, 0), 2, section, material)
    scene.pin(scene.add_body(ancf.Sphere(0.1), mass=1.0, position=(2, 0)).origin)
    assert len(run.plot().lines) == len(rest.plot().lines) > 0
    assert run.to_vtk(tmp_path / "run.vtkhdf", progress=False).exists()
