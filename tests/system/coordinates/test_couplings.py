"""Angles, lengths and displacements in equations: derivatives, and discrete gradients."""

from __future__ import annotations

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import stiffness


def mechanism():
    """Bodies and beams with a driven angle, a driven displacement, in space."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    one, other, third = (
        scene.add_body(
            ancf.Box(length=0.3, width=0.1, height=0.2), mass=1.0 + x, position=(x, 0, 0)
        )
        for x in range(3)
    )
    hinge = scene.revolute(one.at((0.5, 0, 0)), other.at((-0.5, 0, 0)), axis=(0, 0.6, 0.8))
    scene.drive_joint(hinge, 0.0)
    slide = scene.cylindrical(third.origin, other.origin, axis=(1, 0, 0))
    scene.drive_joint(slide, 0.0, of="angle")
    scene.drive_joint(slide, 1.0, of="displacement")
    return System(scene)


def plane():
    """A cable whose slope is driven against a body."""
    scene = ancf.Scene((0.0, -9.81))
    body = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    section, material = ancf.Circle(0.02), ancf.Material(1e7, 1e3)
    rod = scene.add_beam("thin", (1, 0), (2, 1), 2, section, material)
    scene.drive_joint(scene.connect(body.end, rod.start), 0.0)
    return System(scene)


def rope():
    """A rope from a point fixed in space over a body to another one, which is pulled in."""
    scene = ancf.Scene((0.0, 0.0, -9.81))
    one, other = (
        scene.add_body(
            ancf.Box(length=0.3, width=0.1, height=0.2), mass=1.0 + x, position=(x, 0, 0)
        )
        for x in range(2)
    )
    points = [(0.0, 1.0, 2.0), one.at((0.5, 0, 0)), other.at((0, 0.2, 0))]
    scene.winch(points, length=lambda t: 3.0 - t)
    return System(scene)


@pytest.fixture(params=[mechanism, plane, rope])
def system(request):
    return request.param()


@pytest.fixture
def near(system):
    """A state beside the reference shape."""
    rng = np.random.default_rng(5)
    q = system.q_ref + 0.1 * rng.standard_normal(system.n_all)
    lam = 10.0 * rng.standard_normal(system.n_multipliers)
    return q, rng.standard_normal(system.n_all), lam


def residual(system, q, lam):
    rest = np.zeros(system.n_all)
    amplitudes = np.zeros(max(1, system.loads.n_amplitudes))
    return system.assembly.residual(q, rest, rest, lam, rest, amplitudes)


def test_gradients_are_those_of_the_equations(system, near):
    q, v, lam = near
    found = system.constraints.jacobian(q) @ v
    step = 1e-6
    ahead, behind = (residual(system, q + sign * step * v, lam)[1] for sign in (1, -1))
    np.testing.assert_allclose(found, (ahead - behind) / (2.0 * step), rtol=1e-7, atol=1e-8)


def test_multipliers_push_along_the_gradients(system, near):
    q, _, lam = near
    push = residual(system, q, lam)[0] - residual(system, q, 0.0 * lam)[0]
    np.testing.assert_allclose(push, system.constraints.jacobian(q).T @ lam, atol=1e-10)


def test_curvature_is_the_change_of_the_gradients(system, near):
    q, v, _ = near
    step = 1e-5
    ahead, behind = (system.constraints.jacobian(q + s * step * v) @ v for s in (1, -1))
    expected = (ahead - behind) / (2.0 * step)
    np.testing.assert_allclose(system.constraints.curvature(q, v), expected, rtol=1e-6, atol=1e-7)


def test_the_matrix_is_the_derivative_of_the_residual(system, near):
    q, v, lam = near
    n, whole = system.n_free, stiffness(system, q, lam, np.zeros(1)).toarray()
    step = 1e-6
    moved = np.zeros(system.n_all)
    moved[:n] = v[:n]
    (r1, phi1), (r0, phi0) = (residual(system, q + s * step * moved, lam) for s in (1, -1))
    size = np.max(np.abs(whole[:n, :n]))
    expected = (r1 - r0)[:n] / (2.0 * step)
    np.testing.assert_allclose(whole[:n, :n] @ v[:n], expected, rtol=1e-6, atol=1e-8 * size)
    expected = (phi1 - phi0) / (2.0 * step)
    np.testing.assert_allclose(whole[n:, :n] @ v[:n], expected, rtol=1e-6, atol=1e-7)


def test_between_two_states_multipliers_do_no_work_along_the_equations(system, near):
    q, v, lam = near
    rest = np.zeros(system.n_all)
    other = q + 0.3 * v
    only = np.zeros_like(lam)
    led = slice(system.n_multipliers - system.prescribed.n_equations, None)
    only[led] = lam[led]
    between = system.assembly.residual_between
    push = (
        between(q, other, rest, rest, only, rest, np.zeros(1))[0]
        - between(q, other, rest, rest, 0.0 * only, rest, np.zeros(1))[0]
    )
    change = residual(system, other, lam)[1] - residual(system, q, lam)[1]
    assert push @ (other - q) == pytest.approx(only @ change, rel=1e-12)
