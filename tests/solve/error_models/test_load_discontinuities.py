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
    return LoadDiscontinuities(System(scene).loads, 0.0, T_END)


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
