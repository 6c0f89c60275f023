"""The study of the cable around a rotating cylinder, on two cases."""

import dataclasses
import functools
import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from benchmarks.contact import wrapped_cylinder as study


@pytest.fixture(scope="module")
def wraps():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "FRICTIONS", (0.3,))
        patch.setattr(study, "ANGLES", (180.0,))
        patch.setattr(study, "HELICES", ((0.1, 720.0),))
        # What sticks is limited by the damped pressure of a step, 1e-4 more or less in waves.
        patch.setattr(study, "capstan", functools.partial(study.capstan, slip_speed=1e-3))
        return study.wrapped_cylinder()


def test_ratios_and_forces_follow_the_formula(wraps):
    assert [each.turning for each in wraps] == [2.0, -2.0, 2.0, -2.0]
    assert wraps[0].ratio == pytest.approx(2.566332, rel=1e-4)  # exp(0.3 pi)
    assert wraps[1].ratio == pytest.approx(1.0 / 2.566332, rel=1e-4)
    for each in wraps[:2]:
        assert each.pressure_error < 1e-3
        assert each.friction_error < 1e-4
        inside = (each.polar_angle > 20.0) & (each.polar_angle < 160.0)
        # Of the last state alone, in which waves still run along the wire.
        assert np.allclose(each.pressure[inside], each.exact_pressure[inside], rtol=1e-2)


def test_a_helix_has_a_constant_axial_tension(wraps):
    """Compare with a solution of the equations of equilibrium of a string on a cylinder.

    With the angle a to the circles dT/ds = mu p cos(a) and T da/ds = -mu p sin(a), in the direction
    of growing tension, where p = T cos(a)^2 / R.
    """
    tightened, loosened = wraps[2:]
    radius = study.REACH
    for each in (tightened, loosened):
        sign = 1.0 if each.turning > 0.0 else -1.0

        def rates(phi, y, sign=sign):
            tension, a = y
            pressure, per_angle = tension * math.cos(a) ** 2 / radius, radius / math.cos(a)
            return [
                sign * 0.1 * pressure * math.cos(a) * per_angle,
                -sign * 0.1 * pressure * math.sin(a) / tension * per_angle,
            ]

        start = [study.TENSION, math.atan(each.pitch / (2.0 * math.pi * radius))]
        angles = np.sort(math.radians(720.0) - np.radians(each.polar_angle[100:-100]))
        end = math.radians(720.0)
        exact = solve_ivp(rates, (0.0, end), start, t_eval=[*angles, end], rtol=1e-9, atol=1e-12)
        tension, a = exact.y
        assert each.exact_ratio == pytest.approx(tension[-1] / study.TENSION, rel=1e-6)
        assert each.ratio == pytest.approx(tension[-1] / study.TENSION, rel=1e-3)
        pressure = (tension * np.cos(a) ** 2 / radius)[-2::-1]
        np.testing.assert_allclose(each.exact_pressure[100:-100], pressure, rtol=1e-6)
        assert each.pressure_error < 3e-3
        assert each.friction_error < 1e-3
    assert tightened.pitch == 0.1
    assert loosened.pitch == pytest.approx(0.1 * math.exp(-0.1 * 4.0 * math.pi))


def test_findings_and_chart_show_an_error(wraps):
    wrong = [dataclasses.replace(wraps[0], ratio=3.0), *wraps[1:]]
    assert "is 1.7e-01, for mu = 0.3 and 180 degrees" in study.findings(wrong)[0]
    assert "1.7e-01" in study.table(wrong).rows[0]


def test_the_chart_is_readable(wraps, readable):
    readable(study.chart(wraps))
