"""Pictures show what the numbers say, with units on the axes."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.plotting.line_plots import centre_line, differences, edge_lines, snapshots
from ancfsparse.scene import Circle, Material, Scene
from ancfsparse.solve import simulate


@pytest.fixture(autouse=True)
def close_figures():
    yield
    plt.close("all")


@pytest.fixture
def swing(system):
    """Swing the beam from level to upside down while it bends: 0.1 s between states."""
    t = np.linspace(0.0, 1.0, 11)
    q = np.array([system.state(-np.pi * each, 0.8 * each) for each in t])
    rest = np.zeros_like(q)
    return Trajectory(system, t, q, rest, rest, np.zeros((11, 0)), RunStats())


def test_centre_line_is_the_cubic_of_the_elements(swing):
    rod = swing.system.rod
    lines = centre_line(swing, rod, [0, 7], per_element=4)
    assert lines.shape == (2, 17, 2)
    for j in range(17):
        np.testing.assert_allclose(lines[1, j], swing.position(rod.at(j / 8))[7], atol=1e-12)


def test_snapshots_draw_the_nearest_saved_states(swing):
    rod = swing.system.rod
    ax = snapshots(swing, rod, [0.0, 0.52, 1.0])
    assert [line.get_label() for line in ax.lines] == ["0 s", "0.5 s", "1 s"]
    tip = ax.lines[1].get_xydata()[-1]
    np.testing.assert_allclose(tip, swing.position(rod.end)[5], atol=1e-12)
    assert len(ax.lines[0].get_markevery()) == rod.n_nodes
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x [m]", "y [m]")
    assert snapshots(swing, rod, [0.3], ax) is ax


@pytest.mark.parametrize("time", [-0.1, 1.2])
def test_snapshots_outside_the_run(swing, time):
    with pytest.raises(InputError, match=f"no state was saved at t = {time} s: the run goes from"):
        snapshots(swing, swing.system.rod, [time])


def test_differences_over_time():
    t = np.linspace(0.0, 1.0, 5)
    reference = np.zeros((5, 2))
    curve = np.column_stack([3.0 * t, 4.0 * t])
    ax = differences(t, {"davidon": curve, "same": reference}, reference, against="Radau")
    drawn = ax.lines[0].get_ydata()
    assert np.isnan(drawn[0])
    np.testing.assert_allclose(drawn[1:], 5.0 * t[1:])
    assert np.isnan(ax.lines[1].get_ydata()).all()
    assert ax.get_yscale() == "log"
    assert ax.get_xlabel() == "time [s]"
    assert ax.get_ylabel() == "distance from Radau [m]"
    ax.figure.canvas.draw()


def test_differences_need_the_same_times():
    t = np.linspace(0.0, 1.0, 5)
    with pytest.raises(InputError, match=r"curve 'bfgs' has shape \(4, 2\).* there are 5 times"):
        differences(t, {"bfgs": np.zeros((4, 2))}, np.zeros((5, 2)))


@pytest.fixture(scope="module")
def net():
    """Let a small net fall whose nodes are not in order along its lines."""
    scene = Scene()
    nodes = [(0, 0), (2, 0), (1, 0), (1, 1), (1.5, 2.0)]
    edges = [(0, 2), (1, 2), (2, 3), (4, 3)]
    mesh = scene.add_mesh(nodes, edges, "thin", Circle(0.02), Material(1e6, 1e3), smooth=30.0)
    scene.pin(mesh.node(0))
    return mesh, simulate(scene, 0.2, 1e-2)


def test_edges_of_a_mesh_are_traced_from_their_first_node_to_their_second(net):
    mesh, run = net
    assert mesh.flipped.any()
    lines = edge_lines(run, mesh, [0, -1], per_element=5)
    assert lines.shape == (2, 4, 6, 2)
    for e in range(4):
        for k in range(6):
            place = run.position(mesh.at(e, mesh.lengths[e] * k / 5))[[0, -1]]
            np.testing.assert_allclose(lines[:, e, k], place, atol=1e-12)


def test_a_mesh_is_drawn_edge_by_edge(net):
    mesh, run = net
    drawn = snapshots(run, mesh, [0.2]).lines[0]
    x, y = drawn.get_xydata().T
    # Between two edges nothing is drawn, and their ends are marked.
    assert np.isnan(x).sum() == mesh.n_elements
    ends = drawn.get_markevery()
    given = [(0, 2), (1, 2), (2, 3), (4, 3)]
    places = [run.position(mesh.node(i))[-1] for pair in given for i in pair]
    np.testing.assert_allclose(np.column_stack([x, y])[ends], places, atol=1e-12)
    with pytest.raises(InputError, match="mesh 0 is a mesh, which has no single centre line"):
        centre_line(run, mesh, [0])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"trajectory": "run"}, "a Trajectory of simulate is needed, got 'run'"),
        ({"body": 3}, "a beam or a mesh of the run is needed, got 3"),
        ({"times": 0.05}, r"times of snapshots must be a list such as \[0.0, 0.5\], got 0.05"),
        ({"times": []}, "must be a list such as"),
        ({"times": ["now"]}, "times of snapshots must be a list of times in s, got"),
        ({"times": [np.nan]}, "time of a snapshot must be finite"),
        ({"times": [[0.0], [0.1, 0.2]]}, "must be a list of times in s"),
        ({"ax": 3}, "ax must be axes of matplotlib, got 3"),
        ({"plane": (0, 2)}, r"plane must be two different components of xy, \(0, 1\), in either"),
        ({"plane": (0, 0)}, "plane must be two different components"),
        ({"plane": "xy"}, "plane must be two different components"),
        ({"plane": 1}, "plane must be two different components"),
        ({"plane": np.zeros((2, 2))}, "plane must be two different components"),
    ],
)
def test_snapshots_check_what_they_are_given(net, change, message):
    mesh, run = net
    given = {"trajectory": run, "body": mesh, "times": [0.1]} | change
    with pytest.raises(InputError, match=message):
        snapshots(**given)


@pytest.mark.parametrize(
    ("states", "per_element", "message"),
    [
        (3, 4, r"states must be a list of integers such as \[0, 10\], got 3"),
        ([0.5], 4, "states must be a list of integers"),
        ([], 4, r"states must be a list of integers such as \[0, 10\], got \[\]"),
        ([99], 4, "the run has saved states 0 to 20, there is no state 99"),
        ([-22], 4, "there is no state -22"),
        (["a"], 4, "states must be a list of numbers of saved states"),
        ([np.inf], 4, "there is no state inf"),
        ([0], 0, "per_element must be an integer of at least 1"),
        ([0], 10**15, "a picture of so many points would need about .* GB"),
    ],
)
def test_lines_check_what_they_are_given(net, states, per_element, message):
    mesh, run = net
    with pytest.raises(InputError, match=message):
        edge_lines(run, mesh, states, per_element)


@pytest.mark.parametrize(
    ("t", "curves", "reference", "message"),
    [
        ("now", {"a": [[0, 0]]}, [[0, 0]], "times of curves must be a list of times in s"),
        ([0], [[0, 0]], [[0, 0]], "curves must be given by name, such as"),
        ([0], {}, [[0, 0]], "curves must be given by name, such as"),
        ([0], {"a": "b"}, [[0, 0]], "curve 'a' must be a table of positions"),
        ([0], {"a": [[0, 0]]}, None, "reference of curves must be a table of positions"),
        ([0], {"a": [[0, 0]]}, [0, 0], r"got shapes \(1,\) and \(2,\)"),
        ([0, 1], {"a": [[0, 0]]}, [[0, 0]], r"got shapes \(2,\) and \(1, 2\)"),
    ],
)
def test_differences_check_what_they_are_given(t, curves, reference, message):
    with pytest.raises(InputError, match=message):
        differences(t, curves, reference)


def test_the_name_of_a_reference_is_a_text():
    with pytest.raises(InputError, match="against must be a string, the label of the axis, got 3"):
        differences([0.0], {"a": [[0, 0]]}, [[0, 0]], against=3)
