"""Pictures show what the numbers say, with units on the axes."""

import matplotlib.pyplot as plt
import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.plots import centre_line, differences, snapshots


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
