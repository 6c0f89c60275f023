"""Commands that show and convert the files of runs."""

import h5py
import matplotlib.pyplot as plt
import numpy as np
import pytest
from PIL import Image

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from tests.cli.command import run


@pytest.fixture(scope="module")
def file(tmp_path_factory):
    path = tmp_path_factory.mktemp("runs") / "run.h5"
    scene, _ = pendulum(n_elements=4)
    ancf.simulate(scene, 0.1, 1e-3, save_every=5, output=path)
    return path


def test_info_tells_run_and_scene(file, capsys):
    code, out, err = run(capsys, "info", file)
    assert (code, err) == (0, "")
    assert "21 states from t = 0 s to 0.1 s" in out
    assert "20 coordinates, 0 multipliers" in out
    assert "  dt: 0.001\n" in out
    assert "  joints: pin (body 0, 0)\n" in out
    assert "cost: 100 steps, " in out
    assert "unfinished" not in out
    assert "solver: quasi-Newton (bfgs, full memory)\n" in out


def test_plot_draws_the_shapes(file, capsys, tmp_path):
    picture = tmp_path / "run.png"
    code, out, err = run(capsys, "plot", file, picture, "--time", "0", "--time", "0.1")
    assert (code, err, out) == (0, "", f"written: {picture}\n")
    with Image.open(picture) as image:
        assert image.width > 600
        assert len(np.unique(np.asarray(image.convert("RGB")).reshape(-1, 3), axis=0)) > 50
    assert not plt.get_fignums()


def test_animate_writes_a_film(file, capsys, tmp_path):
    film = tmp_path / "run.gif"
    words = "--seconds", "0.5", "--fps", "10", "--dpi", "40", "--view", "yx"
    code, out, _ = run(capsys, "animate", file, film, *words)
    assert (code, out) == (0, f"written: {film}\n")
    with Image.open(film) as image:
        assert image.n_frames == 5


def test_animate_draws_solids(file, capsys, tmp_path):
    pytest.importorskip("pyvista")
    film = tmp_path / "run.gif"
    words = "--seconds", "0.5", "--fps", "4", "--dpi", "40", "--style", "solid"
    assert run(capsys, "animate", file, film, *words)[:2] == (0, f"written: {film}\n")
    with Image.open(film) as image:
        assert (image.n_frames, image.size) == (2, (256, 192))


def test_convert_writes_gltf(file, capsys, tmp_path):
    pytest.importorskip("pygltflib")
    target = tmp_path / "run.glb"
    assert run(capsys, "convert", file, target)[:2] == (0, f"written: {target}\n")
    assert target.read_bytes() == ancf.load(file).to_gltf(tmp_path / "again.glb").read_bytes()


def test_convert_writes_vtkhdf(file, capsys, tmp_path):
    target = tmp_path / "run.vtkhdf"
    code, out, _ = run(capsys, "convert", file, target, "--per-element", "2")
    assert (code, out) == (0, f"written: {target}\n")
    with h5py.File(target) as there:
        assert there["VTKHDF/Points"].shape == (21 * 4 * 3, 3)
        assert list(there["VTKHDF/CellData"]) == ["Body"]


def test_the_pendulum_command_writes_such_a_file(capsys, tmp_path):
    target = tmp_path / "run.h5"
    code, *_ = run(capsys, "pendulum", "--time", "0.01", "--elements", "3", "--output", target)
    assert code == 0
    assert "21 states" in run(capsys, "info", target)[1]


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["info", "no.h5"], "no.h5"),
        (["plot", None, "a.txt"], "a plot must end in .pdf, .png or .svg, got 'a.txt'"),
        (["plot", None, "no/a.png"], "there is no folder no"),
        (["plot", None, "a.png", "--time", "3"], "no state was saved at t = 3 s"),
        (["plot", None, "a.png", "--view", "20,x"], "--view takes two angles in degrees"),
        (["animate", None, "a.avi"], "an animation must end in .gif or .mp4, got 'a.avi'"),
        (["convert", None, "a.vtk"], "a VTKHDF file must end in .vtkhdf or .hdf, got 'a.vtk'"),
    ],
)
def test_what_cannot_be_done_is_one_line(file, capsys, words, message):
    code, out, err = run(capsys, *(file if word is None else word for word in words))
    assert (code, out) == (2, "")
    assert err.startswith("ancfsparse: ")
    assert message in err
    assert err.count("\n") == 1


def test_report_writes_a_page(file, capsys, tmp_path):
    page = tmp_path / "a.html"
    assert run(capsys, "report", file, page) == (0, f"written: {page}\n", "")
    text = page.read_text(encoding="utf-8")
    assert "21 states from t = 0 s to 0.1 s" in text
    code, _, err = run(capsys, "report", file, tmp_path / "a.txt")
    assert code == 2
    assert "a report must end in .html" in err
