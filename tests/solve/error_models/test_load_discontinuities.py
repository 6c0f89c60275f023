"""Times at which loads jump or kink are found to rounding; smooth and rough loads have none."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.error_models.load_discontinuities import LoadDiscontinuities
from ancfsparse.system import System
from tests.beams import build_beam

T_END = 1.0


def discontinuities(*loads):
    section, material = ancf.Circle(0.01), ancf.Material(1e7, 1000.0)
    scene, rod = build_beam("thin", (0, 0), (1, 0), 2, section, material, "pin")
    for load in loads:
        scene.point_force(rod.end, lambda t, load=load: (load(t), 0.0))
    return LoadDiscontinuities(System(scene), 0.0, T_END)


@pytest.mark.parametrize(
    ("load", "times"),
    [
        (lambda t: 5.0 * (t > 0.111), [0.111]),
        (lambda t: 3.0 * (0.2 < t < 0.5), [0.2, 0.5]),
        (lambda t: 1.0 * (0.3 < t < 0.3013), [0.3, 0.3013]),
        (lambda t: 1e8 + (t > 0.5), [0.5]),
        (lambda t: math.sin(9 * t) + 1e-3 * (t >= 0.25), [0.25]),
        (lambda t: min(1.0, t / 0.123), [0.123]),
        (lambda t: abs(math.sin(9 * t)), [math.pi / 9, 2 * math.pi / 9]),
        (lambda t: math.sin(math.pi * min(t, 0.6)) ** 2, [0.6]),
    ],
)
def test_jumps_and_kinks_are_found(load, times):
    found = discontinuities(load)
    assert len(found.before) == len(times)
    for before, after, exact in zip(found.before, found.after, times, strict=True):
        assert before <= after <= before + 4e-16
        assert after == pytest.approx(exact, abs=1e-9)


@pytest.mark.parametrize("at", [0.111, 0.25, 1 / 3])
def test_a_load_is_evaluated_on_both_sides_of_a_jump(at):
    found = discontinuities(lambda t: float(t >= at))
    assert found.before[0] < at <= found.after[0]


def test_breaks_of_several_loads_at_one_time_are_one():
    found = discontinuities(
        lambda t: float(t >= 0.25), lambda t: min(t, 0.25), lambda t: 2.0 * (t > 0.25)
    )
    assert len(found.before) == 1
    assert found.before[0] <= 0.25 <= found.after[0]
    assert found.spans == [(0.0, found.before[0]), (found.after[0], T_END)]


@pytest.mark.parametrize(
    "load",
    [
        lambda t: 1.0,
        lambda t: math.sin(300 * t),
        lambda t: math.exp(-20 * t),
        lambda t: math.exp(-(((t - 0.5) / 0.02) ** 2)),
        lambda t: t**3 - t,
        lambda t: np.random.default_rng(int(1e6 * t)).random(),
    ],
)
def test_smooth_loads_and_noise_have_none(load):
    assert discontinuities(load).spans == [(0.0, T_END)]


def limits(signal, t_start=0.0):
    section, material = ancf.Circle(0.01), ancf.Material(1e7, 1000.0)
    scene, rod = build_beam("thin", (0, 0), (1, 0), 2, section, material, "pin")
    scene.point_moment(rod.end, signal)
    return LoadDiscontinuities(System(scene), t_start, T_END)


SPIKE = ([0.3, 0.300001, 0.300002], [0.0, 1.0, 0.0], "hold")


@pytest.mark.parametrize(
    ("signal", "times"),
    [
        (ancf.Pulse(1.0, 0.3, 0.300001), [0.3, 0.300001]),
        (ancf.Pulse(1.0, 0.3, 0.300004, 1e-6), [0.3, 0.300001, 0.300003, 0.300004]),
        (ancf.Table(*SPIKE), [0.3, 0.300001, 0.300002]),
        (ancf.Table(*SPIKE, smooth=True), [0.3, 0.300001, 0.300002]),
        (ancf.Ramp(1.0, 0.3), [0.3]),
        (ancf.Ramp(1.0, 0.3, 0.1, smooth=True), []),
        (ancf.Pulse(1.0, -0.3, -0.2), []),
        (ancf.Ramp(1.0, 0.1 + 0.2) + ancf.Pulse(2.0, 0.3, 0.4), [0.3, 0.4]),
    ],
)
def test_signals_state_their_times(signal, times):
    found = limits(signal)
    np.testing.assert_allclose(found.after, times, rtol=1e-15)
    assert (found.before < found.after).all()
    values = [signal(found.before), signal(found.after)]
    jumps = np.abs(np.diff(values, axis=0)[0])
    assert ((jumps < 1e-8) | np.isclose(jumps, getattr(signal, "value", 2.0))).all()


@pytest.mark.parametrize(
    ("signal", "longest"),
    [
        (ancf.Sine(1.0, 1024.0), 1 / 4096),
        (ancf.Sine(1.0, 0.1), T_END),
        (ancf.Ramp(1.0, 0.3, 0.1, smooth=True), 0.2),
        (ancf.Ramp(1.0, 0.3, 0.1), T_END),
        (ancf.Pulse(1.0, -0.3, -0.299), T_END),
        (ancf.Table(np.linspace(0, 1, 1001), np.linspace(0, 1, 1001) ** 2), 1 / 64),
    ],
)
def test_steps_are_as_long_as_signals_allow(signal, longest):
    assert limits(signal).longest_step == pytest.approx(longest)


def test_a_dense_table_limits_steps_by_its_changes():
    times = np.linspace(0.0, 1.0, 10001)
    longest = limits(ancf.Table(times, np.sin(2 * np.pi * 50.0 * times))).longest_step
    assert 1 / 50 / 64 < longest <= 1 / 50 / 4
