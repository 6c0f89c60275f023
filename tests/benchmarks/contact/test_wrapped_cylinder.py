"""The study of the cable around a rotating cylinder, on two cases."""

import dataclasses
import functools

import numpy as np
import pytest

from benchmarks.contact import wrapped_cylinder as study


@pytest.fixture(scope="module")
def wraps():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "FRICTIONS", (0.3,))
        patch.setattr(study, "ANGLES", (180.0,))
        # What sticks is limited by the damped pressure of a step, 1e-4 more or less in waves.
        patch.setattr(study, "capstan", functools.partial(study.capstan, slip_speed=1e-3))
        return study.wrapped_cylinder()


def test_ratios_and_forces_follow_the_formula(wraps):
    assert [each.turning for each in wraps] == [2.0, -2.0]
    assert wraps[0].ratio == pytest.approx(2.566332, rel=1e-4)  # exp(0.3 pi)
    assert wraps[1].ratio == pytest.approx(1.0 / 2.566332, rel=1e-4)
    for each in wraps:
        assert each.pressure_error < 1e-3
        assert each.friction_error < 1e-4
        inside = (each.polar_angle > 20.0) & (each.polar_angle < 160.0)
        # Of the last state alone, in which waves still run along the wire.
        assert np.allclose(each.pressure[inside], each.exact_pressure[inside], rtol=1e-2)


def test_findings_and_chart_show_an_error(wraps):
    wrong = [dataclasses.replace(wraps[0], ratio=3.0), wraps[1]]
    assert "is 1.7e-01, for mu = 0.3 and 180 degrees" in study.findings(wrong)[0]
    assert "1.7e-01" in study.table(wrong).rows[0]


def test_the_chart_is_readable(wraps, readable):
    longest = [dataclasses.replace(each, angle=540.0) for each in wraps]
    readable(study.chart(longest))
