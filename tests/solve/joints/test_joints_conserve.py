"""Two bodies in space that a joint holds together keep energy and momenta, at second order."""

from itertools import pairwise

import numpy as np
import pytest

import ancfsparse as ancf

POINT = np.array([0.6, -0.2, 0.3])  # of the joint
SPIN, SPEED = np.array([0.7, -1.1, 0.4]), np.array([0.3, 0.2, -0.5])  # of both together
X, Y, Z = np.eye(3)

# How they are joined, and the velocities that the joint leaves: of rotation and along its axis.
JOINTS = {
    "connect": (lambda scene, a, b: scene.connect(a, b), np.array([0.5, 0.9, -0.8]), 0.0 * X),
    "revolute": (lambda scene, a, b: scene.revolute(a, b, axis=Z), 1.3 * Z, 0.0 * X),
    "universal": (
        lambda scene, a, b: scene.universal(a, b, axis_a=X, axis_b=Y),
        0.8 * X - 1.1 * Y,
        0.0 * X,
    ),
    "cylindrical": (lambda scene, a, b: scene.cylindrical(a, b, axis=Z), 1.3 * Z, 0.4 * Z),
    "prismatic": (lambda scene, a, b: scene.prismatic(a, b, axis=Z), 0.0 * X, 0.4 * Z),
    "weld": (lambda scene, a, b: scene.weld(a, b), 0.0 * X, 0.0 * X),
    "distance": (
        lambda scene, a, b: scene.distance(a.beam.at((0.1, 0.2, 0.0)), b.beam.origin),
        None,
        0.0 * X,
    ),
}


def pair(name, inertia):
    """Return a scene of two bodies, which a joint holds, one not at its origin."""
    make, turning, sliding = JOINTS[name]
    scene = ancf.Scene((0.0, 0.0, 0.0))
    if turning is None:  # about the other end of the distance
        turning, about = np.array([0.5, 0.9, -0.8]), np.array([0.1, 0.2, 0.0])
    else:
        about = POINT

    def add(place, spin, speed):
        velocity = SPEED + np.cross(SPIN, place) + np.cross(spin, place - about) + speed
        return scene.add_body(
            inertia=inertia,
            mass=2.0,
            centre=(0.1, -0.05, 0.2),
            position=place,
            velocity=velocity,
            angular_velocity=SPIN + spin,
        )

    a = add(np.zeros(3), 0.0 * X, 0.0 * X)
    b = add(POINT + 0.25 * X, turning, sliding)
    make(scene, a.at(POINT), b.at((-0.25, 0.0, 0.0)))
    return scene, a, b


def run_of(name, dt, inertia=(0.2, 0.3, 0.4), t_end=0.5):
    scene, a, b = pair(name, inertia)
    run = ancf.simulate(scene, t_end, dt, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    return run, run.body(a), run.body(b)


@pytest.mark.parametrize("name", JOINTS)
@pytest.mark.parametrize("inertia", [(0.2, 0.3, 0.4), (0.2, 0.2, 0.4)], ids=["solid", "flat"])
def test_energy_and_momenta_stay(name, inertia):
    """To 1e-9 at steps of a twentieth of a second, in which the bodies turn by 7 degrees.

    The scheme goes on from velocities that differ from those of the start across constraints, so
    the first state counts apart.
    """
    run, one, other = run_of(name, 0.05, inertia, t_end=5.0)
    energy = run.energy.total
    assert np.ptp(energy[1:]) < 1e-9 * energy[0]
    assert np.ptp(energy) < 1e-6 * energy[0]
    for quantity in ("momentum", "angular_momentum"):
        total = (getattr(one, quantity) + getattr(other, quantity))[1:]
        assert np.ptp(total, axis=0).max() < 1e-9 * np.linalg.norm(total[0])


@pytest.mark.parametrize("name", JOINTS)
def test_positions_are_of_second_order(name):
    ends = [run_of(name, dt)[2].centre[-1] for dt in (0.02, 0.01, 0.005)]
    coarse, fine = (np.linalg.norm(b - a) for a, b in pairwise(ends))
    assert 3.8 < coarse / fine < 4.2
