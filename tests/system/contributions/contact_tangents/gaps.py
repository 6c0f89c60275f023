"""Distances from the cores of obstacles and their gradients, analytic in the position.

A choice, such as the nearest face of a block, follows from real parts.  All formulas are those of
complex numbers, without absolute values or conjugates, so a complex step differentiates them.
"""

import numpy as np

import ancfsparse as ancf
from tests.system.contributions.contact_tangents.vectors import dot, norm


def limited(t, low, high):
    """Numbers between two bounds."""
    return np.where(t.real < low, low, np.where(t.real > high, high, t))


def block_axes(obstacle):
    """Axes of a block as rows."""
    turn = obstacle.orientation
    if obstacle.dim == 2:
        return np.array([[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    w, *v = turn
    skew = np.cross(np.eye(3), v)  # Rodrigues' formula
    return (np.eye(3) + 2.0 * w * skew + 2.0 * skew @ skew).T


def unit(direction):
    """A direction with the length 1."""
    return np.array(direction) / np.linalg.norm(direction)


def from_core(obstacle, w):
    """Distances (...,) of points at vectors (..., dim) from the base, and their gradients."""
    if isinstance(obstacle, ancf.HalfSpace):
        normal = unit(obstacle.normal)
        return w @ normal, np.broadcast_to(normal, w.shape)
    if isinstance(obstacle, ancf.Block):
        return from_block(obstacle, w)
    away = w
    if isinstance(obstacle, ancf.Drum) and obstacle.dim == 3:
        axis = unit(obstacle.axis)
        away = w - (w @ axis)[..., None] * axis
    if isinstance(obstacle, ancf.Capsule):
        line = np.array(obstacle.end) - np.array(obstacle.base)
        away = w - limited(w @ line / (line @ line), 0.0, 1.0)[..., None] * line
    if isinstance(obstacle, ancf.Torus):
        flat = w
        if obstacle.dim == 3:
            axis = unit(obstacle.axis)
            flat = w - (w @ axis)[..., None] * axis
        away = w - obstacle.ring_radius * flat / norm(flat)[..., None]
    return norm(away), away / norm(away)[..., None]


def from_block(obstacle, w):
    """The same of a block; within it minus the depth below the nearest face."""
    axes = block_axes(obstacle)
    y, half = w @ axes.T, 0.5 * np.array(obstacle.size) - obstacle.radius
    away = y - limited(y, -half, half)
    is_outside = np.any(away.real != 0.0, axis=-1)
    depth = half - np.abs(y.real)
    face = np.arange(obstacle.dim) == np.argmin(depth, axis=-1)[..., None]
    outward = np.where(face, np.sign(y.real), 0.0)
    inside = dot(outward, y) - dot(np.abs(outward), half)
    away = np.where(is_outside[..., None], away, outward)
    distance = norm(away)
    normal = (away / distance[..., None]) @ axes
    return np.where(is_outside, distance, inside), normal
