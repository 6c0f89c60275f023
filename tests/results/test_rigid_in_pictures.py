"""Pictures, films and files show rigid bodies where they are."""

import h5py
import numpy as np
import pytest
from PIL import Image

import ancfsparse as ancf
from ancfsparse.cli import main
from ancfsparse.errors import InputError
from ancfsparse.problems import four_bar, heavy_top
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.results.geometry.wireframe import make_wireframe, trace_points
from ancfsparse.results.hdf5_reader import read_outline
from ancfsparse.results.plotting.plot import draw_shapes
from tests.results.conftest import damage_outline

pytestmark = pytest.mark.usefixtures("close_figures")

CORNERS = np.array([(-1, -1), (-1, 1), (1, -1), (1, 1)]) * (0.5, 0.2)


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    """A box that hangs from one corner, and a body given by its inertia on the end of a beam."""
    scene = ancf.Scene((0.0, -9.81))
    box = scene.add_body(
        ancf.Box(length=1.0, width=0.1, height=0.4), mass=2.0, position=(0, 0), orientation=0.3
    )
    scene.pin(box.at((-0.5, 0.2)))
    beam = scene.add_beam("thin", (2, 0), (3, 0), 3, ancf.Circle(0.02), ancf.Material(1e8, 1e3))
    scene.clamp(beam.start)
    weight = scene.add_body(inertia=0.1, mass=1.0, centre=(0.2, 0.1), position=(3.5, 0))
    scene.connect(beam.end, weight.at((-0.5, 0.0)))
    path = tmp_path_factory.mktemp("runs") / "run.h5"
    return ancf.simulate(scene, 0.2, 2e-3, output=path), box, weight, path


@pytest.fixture(scope="module")
def solids():
    """One body of every shape, falling freely."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    shapes = [ancf.Box(length=1.0, width=0.2, height=0.3), ancf.Sphere(0.4), ancf.Rod(1.5)]
    shapes += [ancf.Cylinder(0.3, 0.8, axis=axis) for axis in "xyz"]
    for k, shape in enumerate(shapes):
        scene.add_body(shape, mass=1.0, position=(0, 2 * k, 0), angular_velocity=(1, 2, 3))
    return ancf.simulate(scene, 0.1, 1e-2)


def every(points, expected):
    """Whether every expected point is among some."""
    points = np.reshape(points, (-1, np.shape(points)[-1]))
    return max(np.linalg.norm(points - one, axis=1).min() for one in expected) < 1e-12


def test_a_box_is_drawn_where_it_is(plate):
    run, box, _, _ = plate
    ax = run.plot(times=[0.0, 0.14], of=box)
    assert len(ax.collections) == 2
    motion = run.body(box)
    for k, drawn in zip((0, 70), ax.collections, strict=True):
        corners = motion.centre[k] + CORNERS @ motion.rotation[k].T
        segments = np.array(drawn.get_segments())
        assert segments.shape == (4, 2, 2)
        assert every(segments, corners)
        sides = np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1)
        np.testing.assert_allclose(np.sort(sides), (0.4, 0.4, 1.0, 1.0), rtol=1e-6)


def test_a_pin_is_drawn_at_the_point_it_holds(plate):
    run, box, _, _ = plate
    held = run.position(box.at((-0.5, 0.2)))[-1]
    marks = np.concatenate([line.get_xydata() for line in run.plot(of=box).lines])
    np.testing.assert_allclose(marks, [held], atol=1e-12)


def test_welds_to_the_ground_are_drawn_as_clamps():
    """At the point they hold, with the wall on the side that the body is not on."""
    scene = ancf.Scene((0.0, -9.81))
    box = scene.add_body(ancf.Box(length=1.0, width=0.1, height=0.4), mass=2.0, position=(1, 2))
    scene.weld(box.at((0.5, 0.0)))
    rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0), orientation=0.5 * np.pi)
    scene.clamp(rod.origin)
    run = ancf.simulate(scene, 0.01, 1e-3)
    weld, clamp = make_outline(run.system).supports
    assert (weld.kind, clamp.kind) == ("clamp", "clamp")
    np.testing.assert_allclose(run.q[-1][weld.places] @ weld.weights, (1.5, 2.0), atol=1e-9)
    np.testing.assert_allclose(weld.other, (-0.5, 0.0), atol=1e-12)
    np.testing.assert_allclose(clamp.other, (0.0, 0.5), atol=1e-12)


def test_a_body_given_by_its_inertia_is_lines_from_its_centre(plate):
    run, _, weight, _ = plate
    drawn = np.array(run.plot(of=weight, times=[0.1]).collections[0].get_segments())
    motion, k = run.body(weight), 50
    np.testing.assert_allclose(drawn[:, 0], np.tile(motion.centre[k], (5, 1)), atol=1e-12)
    joint = run.position(weight.at((-0.5, 0.0)))[k]
    np.testing.assert_allclose(drawn[0, 1], joint, atol=1e-12)
    # A square of 1 kg and the moment m a^2 / 6 has half of the side a; the joint is nearer.
    half = 0.25 * np.hypot(0.7, 0.1)
    assert half < 0.5 * np.sqrt(6.0 * 0.1)
    ends = motion.centre[k] + half * np.concatenate([motion.axes[k], -motion.axes[k]])
    assert every(drawn[1:, 1], ends)


def test_bars_of_a_mechanism_meet_in_its_joints():
    mechanism = four_bar()
    run = ancf.simulate(mechanism.scene, 0.1, 5e-3)
    crank, coupler, rocker = (each.get_segments()[0] for each in run.plot(times=[0.1]).collections)
    places = mechanism.quantities(run)
    np.testing.assert_allclose(crank[1], places["A"][-1], atol=1e-8)
    np.testing.assert_allclose(coupler[0], places["A"][-1], atol=1e-12)
    np.testing.assert_allclose(coupler[1], places["B"][-1], atol=1e-12)
    np.testing.assert_allclose(rocker[1], places["B"][-1], atol=1e-8)
    marks = np.concatenate([line.get_xydata() for line in run.plot(times=[0.1]).lines])
    assert len(marks) == 4
    for place in ((0, 0), (3, 0), places["A"][-1], places["B"][-1]):
        assert np.linalg.norm(marks - place, axis=1).min() < 1e-8


def test_a_top_shows_its_axes_and_its_fixed_point():
    mechanism = heavy_top()
    run = ancf.simulate(mechanism.scene, 0.01, 1e-4)
    ax = run.plot(view=(20, -60), times=[0.01])
    disc = mechanism.bodies["disc"]
    motion, solid = run.body(disc), make_outline(run.system).solids[0]
    drawn = trace_points(run.q, solid, make_wireframe(solid))[-1]
    assert every(drawn, [run.position(disc.origin)[-1], motion.centre[-1]])
    # Its box has no height along y: 15 kg (h^2 + 0) / 3 = 0.234375 kg m2 for half edges h.
    half = np.sqrt(0.234375 / 5.0)
    ends = motion.centre[-1] + half * motion.axes[-1][[0, 2]]
    assert every(drawn, ends)
    low, high = np.array([getattr(ax, f"get_{name}lim")() for name in "xyz"]).T
    assert (low < drawn).all()
    assert (drawn < high).all()
    ax.figure.canvas.draw()


def test_facets_enclose_the_volume_of_a_shape(solids):
    """By the divergence theorem, with normals that point outwards, in every turned state."""
    scene, outline = solids.system.scene, make_outline(solids.system)
    for body, solid in zip(scene.bodies, outline.solids, strict=True):
        drawn = make_wireframe(solid)
        corners = trace_points(solids.q, solid, drawn)
        centre = solids.body(body).centre[:, None]
        reach = np.linalg.norm(corners - centre, axis=2).max()
        if isinstance(body.shape, ancf.Rod):
            assert not len(drawn.facets)
            np.testing.assert_allclose(corners[:, 1], solids.position(body.end), atol=1e-12)
            continue
        a, b, c = np.moveaxis((corners - centre)[:, drawn.facets], 2, 0)
        cones = np.einsum("jfd,jfd->jf", a, np.cross(b, c)) / 6.0
        assert cones.min() > 0.0
        # Polygons of 32 corners have 0.994 of the area of their circles; spheres lose another
        # hundredth between 16 parallels.
        share = {ancf.Box: 1.0, ancf.Cylinder: 0.9935, ancf.Sphere: 0.984}[type(body.shape)]
        assert share - 1e-6 < cones.sum(axis=1).min() / body.shape.volume < 1.0 + 1e-6
        across = body.shape.half_extent if not isinstance(body.shape, ancf.Sphere) else (0.4,)
        if isinstance(body.shape, ancf.Cylinder):
            across = (0.3, 0.4)
        assert reach == pytest.approx(np.linalg.norm(across), rel=1e-6)
        edges = drawn.edges
        assert edges.min() >= 0
        assert edges.max() < len(corners[0])


def test_a_file_keeps_the_outlines(plate, tmp_path, capsys):
    run, *_, path = plate
    outline, _, q, _ = read_outline(path)
    expected = make_outline(run.system)
    for solid, other in zip(outline.solids, expected.solids, strict=True):
        assert (solid.name, solid.form) == (other.name, other.form)
        for name in ("places", "reach", "points"):
            np.testing.assert_array_equal(getattr(solid, name), getattr(other, name))
    for support, other in zip(outline.supports, expected.supports, strict=True):
        there, here = (np.asarray(q[..., each.places]) @ each.weights for each in (support, other))
        np.testing.assert_array_equal(there, here)
    with pytest.raises(SystemExit) as left:
        main(["plot", str(path), str(tmp_path / "run.png"), "--time", "0.1"])
    assert left.value.code == 0, capsys.readouterr()
    with Image.open(tmp_path / "run.png") as image:
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 20


def test_a_file_of_an_earlier_version_is_read(plate, tmp_path):
    """Which had supports at nodes alone, and no rigid bodies."""
    scene, rod = ancf.problems.pendulum(n_elements=2)
    run = ancf.simulate(scene, 0.01, 1e-3, output=tmp_path / "run.h5")
    with h5py.File(tmp_path / "run.h5", "a", libver=("v108", "v108")) as file:
        group = file["outline"]
        del group.attrs["rigid bodies"], group["support weights"]
        places = np.asarray(group["support places"])[..., 0]
        del group["support places"]
        group["support places"] = places
    outline, _, q, _ = read_outline(tmp_path / "run.h5")
    assert outline.solids == []
    support = outline.supports[0]
    held = np.asarray(q[..., support.places]) @ support.weights
    np.testing.assert_array_equal(held, run.position(rod.start))


def test_a_file_of_rigid_bodies_alone(tmp_path):
    """Is drawn and read back; without their outlines it says that it has none."""
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    scene.pin(rod.origin)
    path = tmp_path / "run.h5"
    run = ancf.simulate(scene, 0.1, 1e-2, output=path)
    again = ancf.load(path, scene)
    np.testing.assert_array_equal(again.body(rod).centre, run.body(rod).centre)
    outline, t, q, _ = read_outline(path)
    drawn = draw_shapes(outline, t, q, [0.1]).collections[0].get_segments()
    np.testing.assert_allclose(drawn[0][1], run.position(rod.end)[-1], atol=1e-12)
    with h5py.File(path, "a", libver=("v108", "v108")) as file:
        file["outline"].attrs["rigid bodies"] = 0
    with pytest.raises(InputError, match="does not contain the outline of its scene"):
        read_outline(path)


@pytest.mark.parametrize("lost", ["rigid names", "rigid points", "rigid sizes", "rigid places"])
def test_a_damaged_outline_is_refused(plate, tmp_path, lost):
    copy = tmp_path / "run.h5"
    copy.write_bytes(plate[-1].read_bytes())
    damage_outline(copy, lost, lambda table: None if lost == "rigid names" else table[:-1])
    with pytest.raises(InputError, match="its outline is lost"):
        read_outline(copy)


def test_vtkhdf_has_the_edges(plate, tmp_path):
    run, box, _, _ = plate
    path = run.to_vtk(tmp_path / "run.vtkhdf", per_element=2, progress=False)
    motion, k = run.body(box), 70
    with h5py.File(path) as file:
        root = file["VTKHDF"]
        lengths = np.diff(root["Lines/Offsets"])
        np.testing.assert_array_equal(lengths, [3] * 3 + [2] * (4 + 5))
        np.testing.assert_array_equal(root["CellData/Body"], [0] * 3 + [1] * 4 + [2] * 5)
        n = int(root["NumberOfPoints"][0])
        assert root["Points"].shape == (n * len(run.t), 3)
        there = slice(k * n + 9, k * n + 17)
        points, rates = root["Points"][there], root["PointData/Velocity"][there]
        corners = motion.centre[k] + CORNERS @ motion.rotation[k].T
        for corner in corners:
            assert np.abs(points[:, :2] - corner).sum(axis=1).min() < 1e-6
        arms = points[:, :2] - motion.centre[k]
        turning = motion.angular_velocity[k] * np.stack([-arms[:, 1], arms[:, 0]], axis=1)
        np.testing.assert_allclose(rates[:, :2], motion.velocity[k] + turning, atol=1e-4)
        force = np.asarray(root["CellData/AxialForce"]).reshape(len(run.t), 12)
        assert np.isfinite(force[:, :3]).all()
        assert np.isnan(force[:, 3:]).all()


def test_vtk_reads_rigid_bodies_alone(solids, tmp_path):
    vtk = pytest.importorskip("vtk")
    path = solids.to_vtk(tmp_path / "run.vtkhdf", progress=False)
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateTimeStep(solids.t[-1])
    shape = reader.GetOutputDataObject(0)
    edges = [len(make_wireframe(solid).edges) for solid in make_outline(solids.system).solids]
    assert shape.GetNumberOfLines() == sum(edges)
    box = solids.system.scene.bodies[0]
    corner = solids.position(box.at((-0.5, -0.15, -0.1)))[-1]
    np.testing.assert_allclose(shape.GetPoint(0), corner, atol=1e-6)


def test_surfaces_are_rendered_in_true_size(tmp_path):
    pytest.importorskip("pyvista")
    scene = ancf.Scene((0.0, 0.0))
    body = scene.add_body(ancf.Box(length=2.0, width=0.1, height=0.5), mass=1.0, position=(1, 2))
    star = scene.add_body(inertia=1.0, mass=1.0, position=(0, 0))
    run = ancf.simulate(scene, 0.01, 1e-2)
    with Image.open(run.render(tmp_path / "a.png", of=body)) as image:
        rows, columns = (np.asarray(image.convert("L")) < 250).nonzero()
    assert np.ptp(columns) / np.ptp(rows) == pytest.approx(4.0, rel=0.02)
    assert len(rows) == pytest.approx(np.ptp(columns) * np.ptp(rows), rel=0.02)
    with Image.open(run.render(tmp_path / "b.png", of=star)) as image:
        assert 0 < (np.asarray(image.convert("L")) < 250).mean() < 0.05
