"""Functions of time that are data."""

import pickle

import numpy as np
import pytest
from scipy.integrate import quad

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.results.hdf5_reader import load

TIMES = np.linspace(-1.0, 6.0, 141)


def by_hand(signal, times):
    """Values at single times, stacked."""
    return np.stack([signal(float(t)) for t in times])


@pytest.mark.parametrize(
    ("signal", "expected"),
    [
        (ancf.Ramp(4.0, 3.0, 1.0), lambda t: 0 if t < 1 else 4 if t > 3 else 2 * (t - 1)),
        (ancf.Sine(2.0, 0.5, 0.3), lambda t: 2.0 * np.sin(np.pi * t + 0.3)),
        (ancf.Pulse(3.0, 1.0, 2.0), lambda t: 3.0 if 1 <= t < 2 else 0.0),
        (
            ancf.Pulse(3.0, 0.0, 4.0, 1.0),
            lambda t: 3.0 * max(0.0, min(1.0, t, 4.0 - t)),
        ),
        (
            ancf.Table([0, 1, 4], [1, 3, -3], "hold"),
            lambda t: 1 if t < 0 else 1 + 2 * t if t < 1 else 3 - 2 * (t - 1) if t < 4 else -3,
        ),
        (
            ancf.Table([0, 2], [1, 5], outside="zero"),
            lambda t: 1 + 2 * t if 0 <= t <= 2 else 0,
        ),
    ],
)
def test_values_are_those_of_the_definition(signal, expected):
    np.testing.assert_allclose(signal(TIMES), [expected(t) for t in TIMES], atol=1e-14)
    np.testing.assert_array_equal(by_hand(signal, TIMES), signal(TIMES))


def test_a_smooth_ramp_starts_and_ends_with_no_speed_and_no_acceleration():
    ramp, h = ancf.Ramp(1.0, 3.0, 1.0, smooth=True), 1e-4
    assert ramp(2.0) == 0.5
    for t, value in ((1.0, 0.0), (3.0, 1.0)):
        near = ramp(np.array([t - h, t, t + h]))
        assert near[1] == value
        # The third derivative is 60 / 2^3 at both ends: what is left is h^3 / 6 of it.
        np.testing.assert_allclose(near, value, atol=60 / 8 * h**3 / 6 * 1.01)
    middle = ramp(np.linspace(1.0, 3.0, 101))
    assert (np.diff(middle) > 0.0).all()
    np.testing.assert_allclose(middle + middle[::-1], 1.0, rtol=1e-14)  # it is odd about (2, 1/2)


def test_a_spin_up_is_the_integral_of_its_acceleration():
    signal = ancf.SpinUp(6.0, 1.5)

    def acceleration(t):
        return 6.0 / 1.5 * (1.0 - np.cos(2.0 * np.pi * t / 1.5)) if 0.0 <= t <= 1.5 else 0.0

    for t in (-1.0, 0.0, 0.4, 1.5, 4.0):
        rate = quad(acceleration, 0.0, max(t, 0.0), points=[1.5])[0]
        angle = quad(lambda s, t=t: (t - s) * acceleration(s), 0.0, max(t, 0.0), points=[1.5])[0]
        values = signal(t), signal.rate(t), signal.rate(t, 2)
        np.testing.assert_allclose(values, (angle, rate, acceleration(t)), rtol=1e-10, atol=1e-12)
    assert signal.rate(2.0) == pytest.approx(6.0)
    np.testing.assert_array_equal(by_hand(signal, TIMES), signal(TIMES))
    with pytest.raises(ancf.InputError, match="rise of a spin-up must be positive"):
        ancf.SpinUp(1.0, 0.0)


@pytest.mark.parametrize(
    "signal",
    [
        ancf.Ramp((1.0, 2.0), 3.0),
        ancf.Sine((1.0, 2.0), 0.5),
        ancf.Pulse((1.0, 2.0), 0.0, 4.0, 0.5),
        ancf.Table([-1.0, 2.0, 6.0], [(0, 1), (2, 3), (4, 4)]),
    ],
)
def test_vectors_have_a_row_for_each_time(signal):
    assert signal(0.7).shape == (2,)
    assert signal(TIMES).shape == (141, 2)
    np.testing.assert_array_equal(by_hand(signal, TIMES), signal(TIMES))


def test_equal_signals_have_equal_hashes_and_readable_texts():
    table = ancf.Table([0, 1, 2], [(0, 1), (1, 1), (2, 1)])
    assert repr(table) == "Table(3 times from 0 s to 2 s, 2 in each row, outside='error')"
    assert table == ancf.Table((0.0, 1.0, 2.0), table.values) == pickle.loads(pickle.dumps(table))
    assert table != ancf.Table([0, 1, 2], [(0, 1), (1, 1), (2, 1.5)])
    assert table != 3
    assert hash(table) == hash(ancf.Table([0.0, 1, 2], table.values))
    with pytest.raises(ValueError, match="read-only"):
        table.values[0, 0] = 3.0
    assert repr(ancf.Ramp((1, 0), 2)) == "Ramp(value=(1.0, 0.0), end=2.0, start=0.0, smooth=False)"
    assert {ancf.Sine(1, 2), ancf.Sine(1.0, np.float32(2.0))} == {ancf.Sine(1.0, 2.0)}


@pytest.mark.parametrize("dt", [0.21325511868794054 / 50, 0.006666666667])
def test_a_table_to_the_end_of_a_run_lasts_for_its_last_step(dt):
    end = round(1.0 / dt) * dt
    for last in (end, end * (1.0 - 4e-10)):
        table = ancf.Table([0.0, last], [1.0, 3.0])
        assert table(np.nextafter(end, np.inf)) == pytest.approx(3.0)
    with pytest.raises(InputError, match="extend it"):
        table(end + 1e-6)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: ancf.Table([0, 1], [1]), r"one for each of its 2 times, got shape \(1,\)"),
        (lambda: ancf.Table([], []), "times of a table must be a list of numbers"),
        (lambda: ancf.Table([[0]], [0]), "times of a table must be a list of numbers"),
        (lambda: ancf.Table([0, 1, 1], [0, 1, 2]), "1 s follows 1 s in row 2: write a jump as"),
        (lambda: ancf.Table([0, 1], [0, np.nan]), "values of a table must be finite, but in row 1"),
        (lambda: ancf.Table([0, np.inf], [0, 1]), "times of a table must be finite, but in row 1"),
        (lambda: ancf.Table([0, 1], [0, "x"]), "values of a table must be a list of numbers or"),
        (lambda: ancf.Table([0], [0], "holds"), "outside of a table 'holds': did you mean 'hold'"),
        (lambda: ancf.Table([0, 4.9], [0, 1])(5.0), "to 4.9 s, and none at 5 s: extend it, or cho"),
        (lambda: ancf.Ramp(1.0, 0.0), "a ramp must end after it starts, got start = 0 s and end ="),
        (lambda: ancf.Ramp(np.nan, 1.0), "value of a ramp must be finite, got nan"),
        (lambda: ancf.Ramp((1.0,), 1.0), "value of a ramp must be a number, or two or three of"),
        (lambda: ancf.Ramp(1.0, 1.0, smooth=1), "smooth of a ramp must be True or False, got 1"),
        (lambda: ancf.Sine(1.0, -2.0), "frequency of a sine must be positive, got -2 Hz"),
        (lambda: ancf.Sine(1.0, 2.0, np.inf), "phase of a sine must be finite, got inf rad"),
        (lambda: ancf.Pulse(1.0, 0.0, 1.0, 1e-310), "rise of a pulse must lie between"),
        (lambda: ancf.Pulse(1.0, 0.0, 1.0, 0.6), "rise of a pulse must be between 0 and half of i"),
    ],
)
def test_impossible_signals(make, message):
    with pytest.raises(InputError, match=message):
        make()


def pendulum(force):
    scene = ancf.Scene()
    rod = scene.add_beam("thin", (0, 0), (2, 0), 3, ancf.Circle(0.01), ancf.Material(1e8, 4000.0))
    scene.pin(rod.start)
    scene.point_force(rod.end, force)
    return scene, rod


def test_a_signal_moves_a_scene_as_the_same_function_does():
    tips = [
        ancf.simulate(scene, 0.1, 1e-3).position(rod.end)
        for scene, rod in map(
            pendulum, (ancf.Sine((0.0, 2.0), 3.0), lambda t: (0.0, 2.0 * np.sin(6 * np.pi * t)))
        )
    ]
    np.testing.assert_allclose(*tips, rtol=0.0, atol=1e-12)


def test_files_know_signals_by_their_values(tmp_path):
    times, values = [0.0, 1.0], [(0.0, 0.0), (0.0, 1.0)]
    scene, _ = pendulum(ancf.Table(times, values))
    ancf.simulate(scene, 0.01, 1e-3, output=tmp_path / "run.h5")
    assert load(tmp_path / "run.h5", pendulum(ancf.Table(times, values))[0]).finished
    for other in (ancf.Table(times, [(0.0, 0.0), (0.0, 2.0)]), ancf.Ramp((0.0, 1.0), 1.0)):
        with pytest.raises(InputError, match="What differs is loads there: PointForce"):
            load(tmp_path / "run.h5", pendulum(other)[0])


@pytest.mark.parametrize(
    "make",
    [
        lambda: ancf.Ramp(1.0, 5e-324),
        lambda: ancf.Ramp(1.0, 1e308, -1e308),
        lambda: ancf.Pulse(1.0, 0.0, 1e-200),
        lambda: ancf.Sine(1.0, 1e308),
    ],
)
def test_rates_of_signals_stay_in_the_range_of_numbers(make):
    with pytest.raises(InputError, match=r"lie between 1e-100 and 1e\+100|positive|finite"):
        make()


def test_a_signal_must_fit_the_load():
    with pytest.raises(InputError, match="a function of time, at t = 0 s, has 3 components"):
        pendulum(ancf.Sine((1.0, 0.0, 0.0), 1.0))
    with pytest.raises(InputError, match="failed at t = 0 s: the table has values from t = 1 s to"):
        pendulum(ancf.Table([1.0, 2.0], [(0, 0), (1, 1)]))


@pytest.mark.parametrize(
    ("signal", "shortest", "times"),
    [
        (ancf.Ramp(4.0, 3.0, 1.0), 2.0, (1.0, 3.0)),
        (ancf.Ramp(4.0, 3.0, smooth=True), 3.0, (0.0, 3.0)),
        (ancf.Sine(2.0, 0.5, 0.3), 1.0, ()),
        (ancf.Pulse(3.0, 1.0, 2.0), 1.0, (1.0, 2.0)),
        (ancf.Pulse(3.0, 0.0, 4.0, 1.0), 3.0, (0.0, 1.0, 3.0, 4.0)),
        (ancf.Pulse(3.0, 0.0, 4.0, 2.0), 2.0, (0.0, 2.0, 4.0)),
        (ancf.Table([0.0, 1.0, 4.0], [1, 3, -3]), 1.0, (0.0, 1.0, 4.0)),
        (ancf.Table([0.0], [1.0]), np.inf, (0.0,)),
        (ancf.Ramp(1.0, 3.0) + ancf.Sine(1.0, 0.25) + 5.0, 2.0, (0.0, 3.0)),
        (ancf.Ramp(1.0, 3.0) - ancf.Ramp(1.0, 3.5), 0.5, (0.0, 3.0, 3.5)),
    ],
)
def test_signals_state_their_time_scale(signal, shortest, times):
    assert signal.time_scale.shortest == shortest
    assert signal.time_scale.times == times


@pytest.mark.parametrize(
    "signal",
    [
        ancf.Ramp((4.0, 1.0), 3.0, 1.0, smooth=True),
        ancf.Sine((2.0, 1.0), 0.5, 0.3),
        ancf.Pulse((3.0, 1.0), 0.0, 4.0, 1.0),
        ancf.Table([0, 1, 4], [(1, 2), (3, 4), (-3, 1)], "hold", smooth=True),
        ancf.Sine((2.0, 1.0), 0.5) + ancf.Ramp((4.0, 1.0), 3.0) + (1.0, 2.0),
    ],
)
def test_signals_scale(signal):
    values = signal(TIMES)
    for made, factor in ((signal * 2, 2.0), (-0.5 * signal, -0.5), (np.float64(3) * signal, 3.0),
                         (-signal, -1.0), (signal - 3 * signal, -2.0), (signal / 4, 0.25),
                         (signal / np.float64(-0.1), -10.0), (+signal, 1.0)):  # fmt: skip
        np.testing.assert_allclose(made(TIMES), factor * values, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(((1.0, 2.0) - signal)(TIMES), (1.0, 2.0) - values, atol=1e-14)
    assert type(signal * 2) is type(signal)
    assert pickle.loads(pickle.dumps(2 * signal)) == 2 * signal


def test_quotients_of_signals_are_those_of_their_values():
    assert ancf.Ramp(0.3, 1.0) / 3 == ancf.Ramp(0.3 / 3, 1.0)
    assert (ancf.Sine((0.3, 0.7), 2.0) + 1.1) / 7.0 == ancf.Sine((0.3 / 7, 0.7 / 7), 2.0) + 1.1 / 7


@pytest.mark.parametrize("factor", [(1.0, 2.0), "2", None, np.inf, ancf.Ramp(1.0, 1.0)])
def test_factors_of_signals_are_finite_numbers(factor):
    with pytest.raises(InputError, match="factor of a signal must be"):
        ancf.Ramp(1.0, 1.0) * factor
    with pytest.raises(InputError, match="divisor of a signal must be"):
        ancf.Ramp(1.0, 1.0) / factor


@pytest.mark.parametrize(
    ("nonsense", "message"),
    [
        (lambda signal: signal / 0, "the divisor of a signal must not be zero"),
        (lambda signal: signal / 1e-300 / 1e-300, "the multiple of a signal must be finite"),
        (lambda signal: 1e300 * signal * 1e300, "the multiple of a signal must be finite"),
        (lambda signal: signal + "1", "the summand of a signal must be a number"),
        (lambda signal: None + signal, "the summand of a signal must be a number"),
        (lambda signal: signal - "1", "the subtrahend of a signal must be a number"),
        (lambda signal: "1" - signal, "the summand of a signal must be a number"),
        (lambda signal: 2.0 / signal, "can be added to signals and numbers"),
        (lambda signal: np.ones(2) / signal, "can be added to signals and numbers"),
        (lambda signal: signal // 2, "can be added to signals and numbers"),
        (lambda signal: signal % 2, "can be added to signals and numbers"),
        (lambda signal: signal**2, "can be added to signals and numbers"),
        (lambda signal: 2**signal, "can be added to signals and numbers"),
        (lambda signal: signal @ signal, "can be added to signals and numbers"),
        (abs, "can be added to signals and numbers"),
    ],
)
@pytest.mark.parametrize("signal", [ancf.Ramp(1.0, 1.0), ancf.Sine(1.0, 1.0) + 2.0])
def test_operations_without_a_signal_as_result_are_refused(signal, nonsense, message):
    with pytest.raises(InputError, match=message):
        nonsense(signal)


def test_flags_of_numpy_are_those_of_python():
    numpy_table, table = (
        ancf.Table([0.0, 1.0], [0.0, 1.0], smooth=flag) for flag in (np.True_, True)
    )
    assert repr(numpy_table) == repr(table)
    assert repr(ancf.Ramp(1.0, 1.0, smooth=np.True_)) == repr(ancf.Ramp(1.0, 1.0, smooth=True))


@pytest.mark.parametrize("flag", [np.True_, np.False_])
def test_flags_of_numpy_in_scenes_are_stored_as_those_of_python(flag):
    def scene(flag):
        made = ancf.Scene((0.0, -9.81))
        rods = [
            made.add_beam("thin", (x, 0), (x + 1, 0), 2, ancf.Circle(0.01), ancf.Material(1e9, 1e3))
            for x in (0.0, 1.0)
        ]
        made.pin(rods[0].start, as_constraint=flag)
        made.connect(rods[0].end, rods[1].start, apart=flag)
        made.point_force(rods[1].end, (0.0, 1.0), follow=flag)
        return made

    assert str(scene(flag)) == str(scene(bool(flag)))
    assert "np." not in str(scene(flag))
