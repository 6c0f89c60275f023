"""Files for other programs hold the numbers of the run."""

import csv
import io
from contextlib import redirect_stderr
from itertools import pairwise

import h5py
import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image, ImageSequence

import ancfsparse as ancf
from ancfsparse.cli.app import check_writable
from ancfsparse.errors import InputError
from ancfsparse.problems import net, pendulum
from ancfsparse.results.geometry.scene_outline import make_outline
from ancfsparse.results.hdf5_reader import read_outline
from tests.results.conftest import damage_outline


@pytest.fixture(scope="module")
def swing():
    scene, rod = pendulum("thick", 3)
    return ancf.simulate(scene, 0.1, 1e-3, save_every=10), rod


def step_of(file, k):
    """Read one step of a VTKHDF file of polylines as the format says."""
    root = file["VTKHDF"]
    assert root.attrs["Type"] == b"PolyData"
    steps = root["Steps"]
    part = steps["PartOffsets"][k]
    assert steps["NumberOfParts"][k] == 1
    n, begin = root["NumberOfPoints"][part], steps["PointOffsets"][k]
    cells, links = (
        root["Lines"][name][part] for name in ("NumberOfCells", "NumberOfConnectivityIds")
    )
    first, first_link = steps["CellOffsets"][k, 1], steps["ConnectivityIdOffsets"][k, 1]
    ends = root["Lines/Offsets"][first + part : first + part + cells + 1]
    links = root["Lines/Connectivity"][first_link : first_link + links]
    values = {}
    for group, size in (("PointData", n), ("CellData", cells)):
        for name, table in root[group].items():
            at = steps[f"{group}Offsets"][name][k]
            values[name] = table[at : at + size]
    points = root["Points"][begin : begin + n]
    lines = [points[links[a:b]] for a, b in pairwise(ends)]
    return steps["Values"][k], lines, values


@pytest.mark.parametrize("terminal", [False, True])
@pytest.mark.parametrize("progress", [False, True])
def test_bars_are_drawn_on_terminals_only(swing, tmp_path, terminal, progress):
    run, _ = swing
    for make in (
        lambda: run.to_vtk(tmp_path / "run.vtkhdf", progress=progress),
        lambda: run.animate(tmp_path / "run.gif", seconds=0.2, fps=10, dpi=20, progress=progress),
    ):
        screen = io.StringIO()
        screen.isatty = lambda: terminal
        with redirect_stderr(screen):
            make()
        assert bool(screen.getvalue()) == (terminal and progress)


def test_a_state_that_lasts_several_frames_is_drawn_once(swing, tmp_path, monkeypatch):
    run, _ = swing
    drawn, save = [], Figure.savefig

    def count(figure, *arguments, **options):
        drawn.append(figure)
        return save(figure, *arguments, **options)

    monkeypatch.setattr(Figure, "savefig", count)
    path = run.animate(tmp_path / "run.gif", seconds=10.0, fps=10, dpi=20, progress=False)
    with Image.open(path) as film:
        durations = [frame.info["duration"] for frame in ImageSequence.Iterator(film)]
    assert len(drawn) == len(durations) == len(run.t) == 11
    assert sum(durations) == 10_000


def test_vtkhdf_holds_every_state(swing, tmp_path, monkeypatch):
    run, rod = swing
    monkeypatch.setattr("ancfsparse.results.export.vtkhdf.BLOCK_SIZE", 200)  # some states at a time
    path = run.to_vtk(tmp_path / "run.vtkhdf", per_element=2, progress=False)
    with h5py.File(path) as file:
        assert file["VTKHDF/Steps"].attrs["NSteps"] == 11
        for k in (0, 7, 10):
            t, lines, values = step_of(file, k)
            assert t == run.t[k]
            for e, line in enumerate(lines):
                for j, s in enumerate((0.0, 0.5, 1.0)):
                    point = rod.at((e + s) * rod.length / 3)
                    np.testing.assert_allclose(line[j], run.position(point)[k], atol=1e-6)
                    there = values["Velocity"][3 * e + j]
                    np.testing.assert_allclose(there, run.velocity(point)[k], atol=1e-6)
            inside = values["Strain"].reshape(3, 3)[:, 1]
            np.testing.assert_allclose(inside, run.strain(rod)[k], atol=1e-7)
            np.testing.assert_allclose(values["AxialForce"], run.section_force(rod).N[k], rtol=1e-5)
            np.testing.assert_allclose(values["Radius"], 0.01 / np.sqrt(np.pi), rtol=1e-6)
            assert not values["Body"].any()


def test_vtk_reads_it(tmp_path):
    vtk = pytest.importorskip("vtk")
    scene, along, _ = net(4)
    run = ancf.simulate(scene, 0.1, 1e-2)
    path = run.to_vtk(tmp_path / "net.vtkhdf", progress=False)
    reader = vtk.vtkHDFReader()
    reader.SetFileName(str(path))
    reader.UpdateInformation()
    times = reader.GetOutputInformation(0).Get(vtk.vtkStreamingDemandDrivenPipeline.TIME_STEPS())
    np.testing.assert_allclose(times, run.t)
    reader.UpdateTimeStep(times[6])
    shape = reader.GetOutputDataObject(0)
    assert shape.GetNumberOfLines() == 24
    end = run.position(along[0].node(1))[6]
    np.testing.assert_allclose(shape.GetPoint(4), end, atol=1e-6)
    assert shape.GetCellData().GetArray("Body").GetTuple1(23) == 7.0


def test_a_file_knows_what_pictures_need(tmp_path):
    scene = ancf.Scene()
    material = ancf.Material(1e8, 4e3)
    a = scene.add_beam("thin", (0, 0), (2, 0), 4, ancf.Circle(0.02), material)
    nodes, edges = [(2, 0), (3, 0), (3, 1)], [(0, 1), (2, 1)]
    b = scene.add_mesh(nodes, edges, "thin", ancf.Circle(0.03), material)
    scene.connect(a.end, b.node(0))
    scene.clamp(a.start)
    scene.rod(b.node(2), (3.5, 2.0))
    run = ancf.simulate(scene, 0.02, 1e-3, output=tmp_path / "run.h5")
    outline, t, q, v = read_outline(tmp_path / "run.h5")
    np.testing.assert_array_equal(t, run.t)
    expected = make_outline(run.system)
    for part, other in zip(outline.parts, expected.parts, strict=True):
        assert (part.name, part.radius) == (other.name, other.radius)
        np.testing.assert_array_equal(part.places, other.places)
        np.testing.assert_array_equal(part.lengths, other.lengths)
    for support, other in zip(outline.supports, expected.supports, strict=True):
        assert support.kind == other.kind
        np.testing.assert_array_equal(support.places, other.places)
        np.testing.assert_array_equal(support.other, other.other)
    assert outline.parts[0].radius == pytest.approx(0.01)
    np.testing.assert_array_equal(outline.gravity, scene.gravity)
    tip = outline.parts[0].places[-1, 2]
    np.testing.assert_array_equal(q[..., tip], run.position(a.end))
    np.testing.assert_array_equal(v[..., tip], run.velocity(a.end))


def test_a_file_of_some_points_has_no_outline(tmp_path):
    scene, rod = pendulum(n_elements=3)
    ancf.simulate(scene, 0.01, 1e-3, output=tmp_path / "run.h5", save_nodes=[rod.end])
    with pytest.raises(
        InputError, match="does not contain the outline of its scene: it is of a run"
    ):
        read_outline(tmp_path / "run.h5")


@pytest.mark.parametrize("places", [None, np.full((3, 4, 2), 99)], ids=["lost", "out of range"])
def test_a_damaged_outline_is_refused(tmp_path, places):
    scene, _ = pendulum(n_elements=3)
    ancf.simulate(scene, 0.01, 1e-3, output=tmp_path / "run.h5")
    damage_outline(tmp_path / "run.h5", "body 0/places", lambda table: places)
    with pytest.raises(InputError, match="its outline is lost"):
        read_outline(tmp_path / "run.h5")


def test_columns_of_points(swing, tmp_path):
    run, rod = swing
    points = [rod.node(1), rod.end]
    path = run.to_csv(tmp_path / "run.csv", points, ["position", "velocity"])
    with path.open(newline="", encoding="utf-8") as file:
        names, *rows = csv.reader(file)
    assert names[0] == "t [s]"
    assert names[-1] == "velocity z of beam 0 at s = 2 m [m/s]"
    table = np.array(rows, dtype=float)
    assert table.shape == (11, 1 + 2 * 2 * 3)
    np.testing.assert_array_equal(table[:, 0], run.t)
    np.testing.assert_array_equal(table[:, 1:4], run.position(points[0]))
    np.testing.assert_array_equal(table[:, -3:], run.velocity(rod.end))


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (
            lambda run, rod: run.to_vtk("a.vtk"),
            "a VTKHDF file must end in .vtkhdf or .hdf, got 'a.vtk'",
        ),
        (lambda run, rod: run.to_vtk("no/a.vtkhdf"), "there is no folder no"),
        (lambda run, rod: run.to_vtk("a.vtkhdf", per_element=0), "per_element must be an integer"),
        (lambda run, rod: run.to_vtk("a.vtkhdf", per_element=2**62), "per_element must be at most"),
        (
            lambda run, rod: run.to_csv("a.csv", rod.end),
            r"points must be a list such as \[rod.end\]",
        ),
        (lambda run, rod: run.to_csv(".", [rod.end]), "a table must end in .csv"),
        (lambda run, rod: run.to_csv("a.tex", [rod.end]), "a table must end in .csv, got 'a.tex'"),
        (
            lambda run, rod: run.to_csv("no/a.csv", [rod.end]),
            "no/a.csv cannot be written: there is",
        ),
        (lambda run, rod: run.to_csv("a.csv", [3]), "a table needs a point on a beam"),
        (lambda run, rod: run.to_csv("a.csv", [rod.end], ["speed"]), "quantity"),
    ],
)
def test_what_cannot_be_written_is_refused(swing, call, message):
    with pytest.raises(InputError, match=message):
        call(*swing)


@pytest.mark.parametrize(
    ("ending", "write"),
    [
        (".json", lambda run, path: run.system.scene.save(path)),
        (".csv", lambda run, path: run.to_csv(path, [run.system.scene.bodies[0].end])),
        (".hdf", lambda run, path: run.to_vtk(path)),
        (".gif", lambda run, path: run.animate(path)),
        (".json", lambda run, path: check_writable(str(path))),
    ],
)
def test_nothing_replaces_results(tmp_path, ending, write):
    scene, _ = pendulum(n_elements=3)
    path = tmp_path / f"run{ending}"
    run = ancf.simulate(scene, 0.01, 1e-3, output=path)
    before = path.read_bytes()
    with pytest.raises(InputError, match="is not replaced, since it holds the results of a run"):
        write(run, path)
    assert path.read_bytes() == before
    path.unlink()
    heights = {"y": lambda run, rod: run.position(rod.end)[-1, 1]}
    ancf.sweep(pendulum, [{"n_elements": 3}], heights, 0.01, file=path, workers=1, dt=1e-3)
    with pytest.raises(InputError, match="is not replaced, since it holds the results of a sweep"):
        write(run, path)


def test_a_run_of_some_points_leaves_no_file(tmp_path):
    scene, rod = pendulum(n_elements=3)
    run = ancf.simulate(scene, 0.01, 1e-3, save_nodes=[rod.end])
    with pytest.raises(InputError, match="the run kept only those of save_nodes"):
        run.to_vtk(tmp_path / "run.vtkhdf")
    assert not list(tmp_path.iterdir())
