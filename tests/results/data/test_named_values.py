"""Histories, ranges, data frames and datasets of runs."""

import sys

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.problems import heavy_top, pendulum

WITHOUT_EXTRA = r"is not installed: pip install 'ancfsparse\[data\]'"


@pytest.fixture(scope="module")
def fall():
    scene, rod = pendulum(n_elements=4)
    return ancf.simulate(scene, 0.2, 1e-3), rod


def test_histories_are_those_of_the_methods(fall):
    run, rod = fall
    assert np.array_equal(run.history(rod.end, "velocity"), run.velocity(rod.end))
    assert np.array_equal(run.history(rod.start, "reaction"), run.reaction(rod.start))
    assert np.array_equal(run.history(rod.at(0.3), "N"), run.section_force(rod, 0.3).N[:, 0])
    assert np.array_equal(run.history(rod.at(0.3), "strain"), run.strain(rod, [0.3])[:, 0])


def test_ranges_are_extremes_over_all_states(fall):
    run, rod = fall
    arcs = [0.0, 0.25, 0.75, 1.25, 1.75, 2.0]
    values = run.section_force(rod, arcs).M
    found = run.range("M", rod)
    assert found.s == pytest.approx(arcs)
    assert np.array_equal(found.min, values.min(axis=0))
    assert np.array_equal(found.mean, values.mean(axis=0))
    assert np.array_equal(found.max, values.max(axis=0))
    # The mean strain of an element is that at its midpoint, so the ends are left out.
    assert run.range("strain", rod).s == pytest.approx(arcs[1:-1])


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (lambda run, rod: run.history(rod, "N"), "the history of N needs a point on a beam"),
        (lambda run, rod: run.history(rod.end, "tension"), "unknown quantity 'tension'"),
        (lambda run, rod: run.history(rod.end, "T"), "has no torsion: it is planar"),
        (lambda run, rod: run.range("N", rod.end), "N is evaluated along a beam of the run"),
        (lambda run, rod: run.range("velocity", rod), "unknown quantity 'velocity'"),
        (lambda run, rod: run.to_pandas(rod.end), "points must be a list such as"),
        (lambda run, rod: run.to_xarray(["slope"]), "unknown quantity 'slope'"),
        (lambda run, rod: run.to_xarray("N"), "quantities must be a list such as"),
    ],
)
def test_invalid_arguments_are_refused(fall, ask, message):
    if "xarray" in message or "to_xarray" in ask.__code__.co_names:
        pytest.importorskip("xarray")
    with pytest.raises(InputError, match=message):
        ask(*fall)


def test_a_data_frame_has_quantities_points_and_components(fall):
    pytest.importorskip("pandas")
    run, rod = fall
    frame = run.to_pandas([rod.end, rod.at(0.3)], ["velocity", "N"])
    assert np.array_equal(frame.index, run.t)
    assert np.array_equal(frame["velocity"][repr(rod.end)], run.velocity(rod.end))
    assert np.array_equal(frame["N", repr(rod.at(0.3)), ""], run.section_force(rod, 0.3).N[:, 0])
    assert frame.attrs["units"] == {"velocity": "m/s", "N": "N"}
    assert np.array_equal(run.to_pandas().to_numpy(), run.position(rod.end))


def test_a_dataset_has_names_and_units(fall, tmp_path):
    pytest.importorskip("xarray")
    run, rod = fall
    data = run.to_xarray(["position", "acceleration", "N", "M", "T"])
    name = rod.name
    there = data[f"{name} position"].sel(axis="y").isel({f"{name} node": 3})
    assert np.array_equal(there, run.position(rod.node(3))[:, 1])
    assert there.attrs["units"] == "m"
    assert np.array_equal(data[f"{name} N"], run.section_force(rod).N)
    assert np.array_equal(data[f"{name} M"], run.section_force(rod).M)
    assert f"{name} T" not in data  # planar
    assert np.array_equal(data["energy"].sel(form="kinetic"), run.energy.kinetic)
    assert data.attrs["dt"] == 1e-3
    assert data[f"{name} s"].values == pytest.approx([0.0, 0.5, 1.0, 1.5, 2.0])


def test_datasets_of_bodies_and_meshes_in_space():
    pytest.importorskip("xarray")
    top = heavy_top().scene
    run = ancf.simulate(top, 0.01, 1e-3)
    (body,) = top.bodies
    assert np.array_equal(run.to_xarray()[f"{body.name} position"], run.position(body.origin))
    scene = ancf.Scene((0, 0, -9.81))
    points = [(0, 0, 0), (1, 0, 0), (1, 1, 0)]
    net = scene.add_mesh(
        points, [(0, 1), (1, 2)], "thin", ancf.Circle(0.01), ancf.Material(1e8, 1e3)
    )
    scene.pin(net.node(0))
    run = ancf.simulate(scene, 0.01, 1e-3)
    data = run.to_xarray(["position", "curvature", "N"])
    assert data[f"{net.name} position"].shape == (11, net.n_nodes, 3)
    assert np.array_equal(data[f"{net.name} curvature"], run.curvature(net))
    assert np.array_equal(data[f"{net.name} N"], run.section_force(net).N)


@pytest.mark.parametrize("extra", ["pandas", "xarray"])
def test_a_missing_extra_is_named(fall, monkeypatch, extra):
    monkeypatch.setitem(sys.modules, extra, None)
    with pytest.raises(InputError, match=WITHOUT_EXTRA):
        getattr(fall[0], f"to_{extra}")()
