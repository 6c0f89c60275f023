"""Violations of constraints as they are reported: of distances as lengths."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.scene.joints.distance import DistanceConstraint
from ancfsparse.system import System


def violated_lengths(system: System, phi: Vector, prescribed: Vector) -> Vector:
    """Return the violations of all equations, of distances by their lengths, (m,) [m].

    Parameters
    ----------
    system : System
        With the constraints.
    phi : (m,) float
        Values of the equations; those of distances are ``(d^2 - l^2) / (2 l_0)`` [m].
    prescribed : (m,) float
        Their prescribed values; those of distances are ``l^2 / (2 l_0)`` [m].
    """
    out = np.array(phi)
    for row, initial, half_square in _distances(system, prescribed):
        length = np.sqrt(2.0 * initial * half_square)
        out[row] = np.sqrt(max(0.0, 2.0 * initial * (phi[row] + half_square))) - length
    return out


def violated_rates(system: System, rates: Vector, prescribed: Vector) -> Vector:
    """Return the violations of the rates, of distances by their rates, (m,) [m/s].

    Values `prescribed` as in `violated_lengths`, with which the distances agree.
    """
    out = np.array(rates)
    for row, initial, half_square in _distances(system, prescribed):
        out[row] *= np.sqrt(0.5 * initial / half_square)
    return out


def _distances(system: System, prescribed: Vector) -> list[tuple[int, float, float]]:
    """Return row, initial length l_0 and l^2 / (2 l_0) of every distance [m]."""
    joints = {id(each): each for each in system.scene.joints}
    out = []
    for row, (owner, _) in enumerate(system.constraints.source):
        joint = joints.get(owner)
        if isinstance(joint, DistanceConstraint):
            half_square = float(prescribed[row]) - system.constraints.offset[row]
            out.append((row, joint.length, half_square))
    return out
