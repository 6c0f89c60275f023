"""Equilibria under prescribed motions: residuals relative to the forces that impose them."""

import math
import warnings

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import knot
from ancfsparse.results import RunStats
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations
from ancfsparse.system import System

TOLERANCE = 1e-4
SECTION, MATERIAL = ancf.Circle(1e-3), ancf.Material(1e9, 1e3)


def bent(kind, move, gravity, diameter):
    """A clamped rod of 1 m whose end is moved.

    If the end moved alone, one element would take up the entire motion.
    """
    scene = ancf.Scene((0.0, -gravity))
    section = ancf.Circle(diameter)
    rod = scene.add_beam(kind, (0, 0), (1, 0), 8, section, MATERIAL)
    scene.clamp(rod.start)
    scene.drive(rod.end, lambda t: np.array([1.0 + move[0], move[1]]))
    return scene, rod


def equilibrium(scene, tolerance):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ancf.UnstableEquilibriumWarning)
        return ancf.solve_static(scene, tolerance=tolerance)


@pytest.mark.parametrize("diameter", [1e-3, 1e-2])
@pytest.mark.parametrize("gravity", [0.0, 9.81])
@pytest.mark.parametrize("move", [(-0.3, 0.05), (-0.5, 0.3), (-0.1, 0.2)])
@pytest.mark.parametrize("kind", ["thin", "thick"])
def test_reactions_are_as_accurate_as_the_tolerance(kind, move, gravity, diameter):
    scene, rod = bent(kind, move, gravity, diameter)
    here = equilibrium(scene, TOLERANCE)
    force, weight = here.reaction(rod.end), MATERIAL.density * math.pi * diameter**2 / 4 * gravity
    balance = force + here.reaction(rod.start)[:2] - (0.0, weight)
    assert np.linalg.norm(balance) < TOLERANCE * np.linalg.norm(force)
    if here.stable:
        exact = ancf.solve_static(scene, start=here, tolerance=1e-13).reaction(rod.end)
        assert np.linalg.norm(force - exact) < TOLERANCE * np.linalg.norm(exact)


@pytest.mark.parametrize("angle", [0.05, 2.5])
def test_moments_of_driven_joints_are_as_accurate_as_the_tolerance(angle):
    """A rod is bent by the rotation of a hinge at one end, the other end is pinned."""

    def moment(tolerance):
        scene = ancf.Scene((0.0, 0.0, -9.81))
        crank = scene.add_body(mass=1.0, inertia=np.eye(3), position=np.zeros(3))
        hinge = scene.revolute(crank.origin, axis=(0.0, 1.0, 0.0))
        rod = scene.add_beam("thin", (0, 0, 0), (1, 0, 0), 8, SECTION, MATERIAL)
        scene.weld(crank.origin, rod.start)
        scene.pin(rod.end)
        scene.drive_joint(hinge, lambda t: angle)
        here = equilibrium(scene, tolerance)
        return here.reaction(rod.end)

    exact = moment(1e-13)
    assert np.linalg.norm(moment(TOLERANCE) - exact) < TOLERANCE * np.linalg.norm(exact)


def knotted(thickness, tightening):
    """A loose knot without friction in an equilibrium at a part of its motion."""
    rest = knot(0.0, 1.0 / 60.0, thickness=thickness, slowness=2.0)
    scale, dt = 0.02 / thickness, 2e-3 * 0.02 / thickness
    t = scale * (2.4 + 2.0 * 13.6 * tightening)
    run = ancf.simulate(rest.scene, dt * round(t / dt), dt, integrator=ancf.GeneralizedAlpha(0.5))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ancf.UnstableEquilibriumWarning)
        return rest.bodies["rod"], ancf.solve_static(rest.scene, start=run.last)


def test_reactions_near_a_start_far_from_the_reference_shape():
    rod, here = knotted(0.005, 0.3)
    force, other = here.reaction(rod.end), here.reaction(rod.start)
    assert np.linalg.norm(force + other) < 1e-8 * force[0]
    assert np.linalg.norm(force[1:]) < 1e-6 * force[0]  # nothing presses from the side


def test_unstable_equilibrium_with_a_free_rotation_warns():
    """Without friction a knot on a mesh rests in places that differ little in energy."""
    rest = knot(0.0, 1.0 / 60.0, n_elements=220, thickness=0.005, slowness=2.0)
    run = ancf.simulate(rest.scene, 9.6, 8e-3, integrator=ancf.GeneralizedAlpha(0.5))
    with pytest.warns(ancf.UnstableEquilibriumWarning, match="unstable in 1 direction"):
        here = ancf.solve_static(rest.scene, start=run.last)
    force = here.reaction(rest.bodies["rod"].end) + here.reaction(rest.bodies["rod"].start)
    assert np.linalg.norm(force) < 1e-5 * here.reaction(rest.bodies["rod"].end)[0]


def test_load_steps_in_between_do_not_have_to_be_accurate():
    """They are as long as with a support that moves alone; otherwise there would be 300 of them."""
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 24, ancf.Circle(5e-4), MATERIAL)
    scene.clamp(rod.start)
    scene.drive(rod.end, lambda t: np.array([0.6, 0.15]))
    assert ancf.solve_static(scene).stats.steps < 100


def test_a_free_scene_has_time_to_come_to_rest():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    section, material = ancf.Circle(2.5e-3), ancf.Material(3e9, 1e3)
    rod = scene.add_beam("thick", (0, 0, 0), (1, 0, 0), 18, section, material)
    scene.pin(rod.start)
    scene.drive(rod.end, lambda t: np.array([0.7, 0.1, 0.1]))
    rest = ancf.solve_static(scene)
    assert rest.stable
    force = rest.reaction(rod.end)
    assert np.linalg.norm(force + rest.reaction(rod.start)) < 1e-7 * np.linalg.norm(force)


def test_weights_at_a_driven_point_are_not_driving_forces():
    """A mass of 1e7 kg on the driven end does not make the reaction at the other end inexact."""
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (1, 0), 16, SECTION, MATERIAL)
    scene.pin(rod.start)
    scene.add_mass(rod.end, 1e7)
    scene.drive(rod.end, lambda t: np.array([0.99, 0.0]))
    exact = ancf.solve_static(scene, tolerance=1e-13).reaction(rod.start)
    found = ancf.solve_static(scene, tolerance=1e-3).reaction(rod.start)
    assert np.linalg.norm(found - exact) < 1e-2 * np.linalg.norm(exact)


@pytest.mark.parametrize("as_constraint", [False, True])
def test_moments_at_driven_angles_are_compared_at_each_scale_of_length(as_constraint):
    def ratio(length):
        """Norm of the driving force over the force at the other end and the root of a mass."""
        scene = ancf.Scene((0.0, 0.0))
        mass = 1e3 * math.pi / 4.0 * (length / 100.0) ** 2 * length
        crank = scene.add_body(mass=mass, inertia=mass * length**2, position=(0.0, 0.0))
        hinge = scene.pin(crank.origin)
        section = ancf.Circle(length / 100.0)
        rod = scene.add_beam("thin", (0.0, 0.0), (length, 0.0), 8, section, MATERIAL)
        scene.weld(crank.origin, rod.start)
        scene.pin(rod.end)
        scene.drive_joint(hinge, lambda t: 0.5, as_constraint=as_constraint)
        found = ancf.solve_static(scene)
        equations = EquilibriumEquations(System(scene), RunStats())
        state = equations.state(found.q, found.multipliers, 1.0)
        scale = equations.force_scale(state) * math.sqrt(mass)
        return scale / np.linalg.norm(found.reaction(rod.end))

    assert ratio(1e-4) == pytest.approx(ratio(1e4), rel=1e-3)
