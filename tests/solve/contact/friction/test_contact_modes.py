"""Modes about states with friction, and equilibria that only a contact supports."""

import numpy as np
import pytest
from scipy.optimize import brentq

import ancfsparse as ancf
from ancfsparse.scene.force_elements.contacts import LAYER_RATIO

STIFFNESS = 1e6  # N/m2
RADIUS = 0.0025  # m
MASS_PER_LENGTH = 2e3 * np.pi * RADIUS**2  # kg/m
WEIGHT = 9.81 * MASS_PER_LENGTH  # N/m
GRIP = 0.1 * STIFFNESS  # of bristles, N/m2
FRICTION = 0.5


def scene_on_floor(height=RADIUS, friction=FRICTION, dim=2):
    """Return a scene with a cable of 1 m along x over a floor, and the cable."""
    up = np.eye(dim)[-1]
    scene = ancf.Scene(-9.81 * up)
    ends = height * up, height * up + np.eye(dim)[0]
    cable = scene.add_beam("thin", *ends, 10, ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 2e3))
    scene.contact(cable, ancf.HalfSpace(0.0 * up, up), friction=friction, stiffness=STIFFNESS)
    return scene, cable


def state_after_push(ratio):
    """Return a scene, and its state after a push along the floor by a ratio of full friction."""
    scene, cable = scene_on_floor()
    at_rest = ancf.solve_static(scene)
    push = ratio * FRICTION * WEIGHT
    scene.distributed_force(cable, ancf.Ramp((push, 0), 0.05, smooth=True))
    return scene, ancf.simulate(scene, 0.1, 2e-4, start=at_rest).last


class TestModes:
    def test_a_cable_at_rest_vibrates_on_its_bristles(self):
        """Mass and bristles per length are uniform, so the lowest mode is a rigid translation."""
        scene, _ = scene_on_floor()
        lowest = ancf.modes(ancf.solve_static(scene), 1).frequencies[0]
        expected = np.sqrt(GRIP / MASS_PER_LENGTH) / (2.0 * np.pi)
        assert lowest == pytest.approx(expected, rel=1e-9)

    def test_the_frequency_is_that_of_the_motion(self):
        scene, cable = scene_on_floor()
        start = ancf.solve_static(scene)
        lowest = ancf.modes(start, 1).frequencies[0]
        # A push far below full friction, let go.
        push = 0.02 * FRICTION * WEIGHT
        scene.distributed_force(cable, ancf.Ramp((push, 0), 1e-9, smooth=True))
        run = ancf.simulate(scene, 0.04, 5e-5, integrator=ancf.Newmark(0.0), start=start)
        x = run.position(cable.at(0.5))[:, 0]
        x = x - x.mean()
        up = np.flatnonzero((x[:-1] < 0.0) & (x[1:] >= 0.0))
        crossings = run.t[up] - x[up] * np.diff(run.t)[up] / np.diff(x)[up]
        assert len(crossings) > 8
        assert 1.0 / np.diff(crossings).mean() == pytest.approx(lowest, rel=2e-3)

    def test_without_friction_it_is_free_along_the_floor(self):
        scene, _ = scene_on_floor(friction=0.0)
        assert ancf.modes(ancf.solve_static(scene), 1).frequencies[0] == 0.0

    @pytest.mark.parametrize(("ratio", "sticks"), [(0.5, True), (0.95, True), (1.5, False)])
    def test_points_that_slide_have_no_stiffness(self, ratio, sticks):
        scene, state = state_after_push(ratio)
        lowest = ancf.modes(scene, 1, at=state).frequencies[0]
        expected = np.sqrt(GRIP / MASS_PER_LENGTH) / (2.0 * np.pi) if sticks else 0.0
        assert lowest == pytest.approx(expected, rel=1e-6, abs=1e-6)

    def test_a_state_without_deflections_sticks(self):
        _, state = state_after_push(1.5)
        other, _ = scene_on_floor()  # without the push, so the deflections do not belong to it
        assert ancf.modes(other, 1, at=state).frequencies[0] > 200.0

    def test_bristles_hold_all_motions_along_a_floor(self):
        """Two translations and the rotation about the normal have the same frequency."""
        scene, _ = scene_on_floor(dim=3)
        frequencies = ancf.modes(ancf.solve_static(scene), 8).frequencies
        expected = np.sqrt(GRIP / MASS_PER_LENGTH) / (2.0 * np.pi)
        along = np.isclose(frequencies, expected, rtol=1e-9)
        assert along.sum() == 3

    def test_forces_after_modes_are_those_before(self):
        """Bristles stick in the call alone."""
        scene, _ = scene_on_floor()
        equilibrium = ancf.solve_static(scene)
        before = equilibrium.system.assembly.matrix(
            0.0, 1.0, equilibrium.q, np.zeros(0), np.zeros(0)
        )
        ancf.modes(equilibrium, 1)
        after = equilibrium.system.assembly.matrix(
            0.0, 1.0, equilibrium.q, np.zeros(0), np.zeros(0)
        )
        np.testing.assert_array_equal(before, after)


class TestEquilibria:
    @pytest.mark.parametrize("height", [RADIUS, 2.0 * RADIUS, 0.3])
    def test_a_cable_over_a_floor_comes_to_rest_on_it(self, height):
        """Within the layer D, the weight per length is the pressure k (e^3/D^2 - e^4/(2 D^3))."""
        scene, cable = scene_on_floor(height)
        equilibrium = ancf.solve_static(scene)
        layer = LAYER_RATIO * RADIUS
        depth = brentq(
            lambda e: STIFFNESS * (e**3 / layer**2 - 0.5 * e**4 / layer**3) - WEIGHT, 0.0, layer
        )
        for s in (0.0, 0.37, 1.0):
            y = equilibrium.position(cable.at(s))[1]
            assert RADIUS - y == pytest.approx(depth, rel=1e-6)
