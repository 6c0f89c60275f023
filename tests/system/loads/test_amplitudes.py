"""Functions of time give the same amplitudes at once and call by call, and fail where they fail."""

import math
import warnings

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import LoadError
from ancfsparse.system import System

TIMES = np.linspace(0.0, 5.0, 501)


def loads_of(force, dim=2):
    scene = ancf.Scene((0.0, -9.81, 0.0)[:dim])
    start, end = np.zeros(dim), np.eye(dim)[0]
    rod = scene.add_beam("thin", start, end, 3, ancf.Circle(0.01), ancf.Material(1e8, 1e3))
    scene.point_force(rod.end, force)
    return System(scene).loads


class Counted:
    """A function, and the shapes of the times it is called with."""

    def __init__(self, function):
        self.function, self.shapes = function, []

    def __call__(self, t):
        self.shapes.append(np.shape(t))
        return self.function(t)


SPLINE = np.array([[0.0, 1.0], [2.0, -1.0], [5.0, 3.0]])
AT_ONCE = [
    lambda t: (0.0, np.sin(3.0 * t)),
    lambda t: [np.where(t > 2.0, t, 0.0), 1],
    lambda t: np.array([0.0 * t, t**2]),
    lambda t: np.stack([t, np.cos(t)], axis=-1),
    lambda t: (0.0, np.interp(t, SPLINE[:, 0], SPLINE[:, 1])),
    lambda t: ((t > 1.0) * 2.0, t % 1.0),
]


@pytest.mark.parametrize("function", AT_ONCE)
def test_functions_that_take_arrays_are_called_with_them(function):
    counted = Counted(function)
    loads = loads_of(counted)
    counted.shapes.clear()
    table = loads.amplitudes(TIMES)
    np.testing.assert_allclose(table, [function(float(t)) for t in TIMES], rtol=1e-15)
    assert counted.shapes.count((501,)) == 1
    assert len(counted.shapes) == 9  # eight of them check it


def only_in_the_middle(t):
    return (0.0, 1.0) if np.all((t > 2.0) & (t < 2.1)) else (0.0, 0.0)


def stepped(t):
    if t > 2.5:
        return (1.0, 2.0)
    return (0.0, t)


CALL_BY_CALL = [
    stepped,
    only_in_the_middle,
    lambda t: (0.0, math.sin(t)),
    lambda t: (0.0, max(t - 1.0, 0.0)),
    lambda t: (1.0, 2.0),
    lambda t: t * np.array([1.0, 2.0]),
    # Of the right shape with arrays, but of other values: what one time gives depends on others.
    lambda t: (0.0 * t, np.max(t)),
    lambda t: (0.0, t - np.mean(t)),
    lambda t: (0.0, np.cumsum(t)[-1] if np.ndim(t) == 0 else np.cumsum(t)),
    lambda t: (0.0, t if np.ndim(t) == 0 else t[::-1]),
    lambda t: (0.0, t * (1.0 if np.ndim(t) == 0 else 1.0 + 1e-9)),
    lambda t: (t, t) if np.ndim(t) == 0 else np.zeros((2, len(t))),
    lambda t: (t, t) if np.ndim(t) == 0 else np.zeros((len(t), 2)),
    lambda t: (0.0, t) if np.ndim(t) == 0 else (0.0, np.where(t < 3.0, t, np.nan)),
    lambda t: (0.0, t) if np.ndim(t) == 0 else (0.0, t.astype(str)),
    lambda t: (0.0, t) if np.ndim(t) == 0 else None,
]


@pytest.mark.parametrize("function", CALL_BY_CALL)
def test_all_others_are_called_with_one_time_after_another(function):
    counted = Counted(function)
    loads = loads_of(counted)
    for _ in range(2):
        counted.shapes.clear()
        table = loads.amplitudes(TIMES)
        expected = np.array([np.broadcast_to(function(float(t)), 2) for t in TIMES])
        np.testing.assert_array_equal(table, expected)
    assert counted.shapes == [()] * 501  # arrays are not tried again


def test_a_function_that_starts_to_differ_is_noticed_later():
    def late(t):
        return (0.0, np.where(np.any(t > 3.0), 2.0 * t, t))

    loads = loads_of(late)
    np.testing.assert_array_equal(loads.amplitudes(TIMES[:200])[:, 1], TIMES[:200])
    whole = loads.amplitudes(TIMES)[:, 1]
    np.testing.assert_array_equal(whole, np.where(TIMES > 3.0, 2.0 * TIMES, TIMES))


def test_trying_is_silent_and_changes_nothing():
    def greedy(t):
        t -= 1.0
        return (0.0, 1.0 / t if t else 0.0)

    def warner(t):
        if np.ndim(t):
            warnings.warn("arrays are slow", stacklevel=1)
        return (0.0, 2.0 * t)

    times = TIMES.copy()
    for function in (greedy, warner):
        loads_of(function).amplitudes(times)
        np.testing.assert_array_equal(times, TIMES)


def test_interruptions_are_not_taken_for_failures():
    def interrupted(t):
        if np.ndim(t):
            raise KeyboardInterrupt
        return (0.0, 0.0)

    with pytest.raises(KeyboardInterrupt):
        loads_of(interrupted).amplitudes(TIMES)


def raises(t):
    if t > 4.9:
        raise OSError("sensor table ends at 4.9 s")
    return (0.0, t)


FAILING = [
    (raises, "function of time, failed at t = 4.91 s: OSError: sensor table ends at 4.9 s"),
    (lambda t: (0.0, np.where(t > 4.9, np.nan, t)), "4.91 s, must be finite, but its y component "),
    (lambda t: (0.0, t, 1.0) if t > 4.9 else (0.0, t), "at t = 4.91 s, has 3 components"),
    (lambda t: None if t > 4.9 else (0.0, t), "at t = 4.91 s, must be 2 numbers, got None"),
    (lambda t: ("0", "1") if t > 4.9 else (0.0, t), "at t = 4.91 s, must be 2 numbers"),
    (ancf.Table([0.0, 4.9], [(0.0, 0.0), (0.0, 4.9)]), "from t = 0 s to 4.9 s, and none at 4.91 s"),
]


@pytest.mark.parametrize(("function", "told"), FAILING)
@pytest.mark.parametrize("n", [501, 493])
def test_what_comes_before_a_failure_is_kept(function, told, n):
    loads = loads_of(function)
    table, failure = loads.tabulate(TIMES[:n])
    np.testing.assert_allclose(table[:, 1], TIMES[:491], rtol=1e-13)
    assert failure.time == TIMES[491]
    with pytest.raises(LoadError, match=told):
        loads.amplitudes(TIMES[:n])
    assert loads.tabulate(TIMES[:491])[1] is None
    assert (str(failure.__cause__) == "sensor table ends at 4.9 s") == (function is raises)


def test_the_first_failure_of_several_loads_counts():
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), 3, ancf.Circle(0.01), ancf.Material(1e8, 1e3))
    scene.point_moment(rod.end, lambda t: np.nan if t > 4.0 else t)
    scene.distributed_force(rod, lambda t: (np.inf, 0.0) if t > 2.0 else (t, 1.0))
    scene.point_moment(rod.start, lambda t: 2.0 * t)
    table, failure = System(scene).loads.tabulate(TIMES)
    assert failure.time == pytest.approx(2.01)
    t = TIMES[:201]
    np.testing.assert_array_equal(table, np.column_stack([t, t, np.ones(201), 2.0 * t]))
    scene.point_moment(rod.start, lambda t: (t,) if t > 1.0 else t)
    assert System(scene).loads.tabulate(TIMES)[1].time == pytest.approx(1.01)


def test_planar_moments_may_be_arrays_of_times():
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (1, 0), 3, ancf.Circle(0.01), ancf.Material(1e8, 1e3))
    counted = Counted(lambda t: 2.0 * t)
    scene.point_moment(rod.end, counted)
    scene.point_moment(rod.end, ancf.Ramp(1.0, 5.0))
    table = System(scene).loads.amplitudes(TIMES)
    np.testing.assert_allclose(table, np.column_stack([2.0 * TIMES, TIMES / 5.0]), rtol=1e-15)
    assert (501,) in counted.shapes


def test_names_are_composed_for_messages_alone(monkeypatch):
    def refuse(_):
        raise AssertionError("a name was composed")

    loads = [loads_of(function) for function in (AT_ONCE[0], stepped, ancf.Ramp((0.0, 1.0), 5.0))]
    monkeypatch.setattr(ancf.scene.bodies.body.Point, "__repr__", refuse)
    for each in loads:
        each.amplitudes(TIMES)
        each.amplitudes(TIMES[:1])
