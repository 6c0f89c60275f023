"""States of a motion: coordinates, velocities, accelerations and multipliers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.errors import InputError
from ancfsparse.scene import Body, Point, Scene

ROUNDING = 1e-9  # difference of equal values, over the largest coordinate or velocity
COORDINATE_DESCRIPTIONS = ("element", "mesh")
"""Entries of `Scene.digest` that determine the coordinates; section and material may change."""


class CoordinateLayout(NamedTuple):
    """Meaning and indices of the coordinates of a system.

    Attributes
    ----------
    bodies : tuple of str
        Element and mesh of each body.
    places : list of (n_rows, n_c) int32 arrays
        Indices of the coordinates of each row, per body.
    q_ref : (n_all,) float
        The stress-free shape [m, 1].
    """

    bodies: tuple[str, ...]
    places: Sequence[Integers]
    q_ref: Vector

    def numbers_like(self, other: CoordinateLayout) -> bool:
        """Return True if all coordinates have the same indices."""
        return self is other or (
            self.bodies == other.bodies and all(map(np.array_equal, self.places, other.places))
        )


def describe_coordinates(description: Mapping[str, str]) -> tuple[str, ...]:
    """Return a description of the coordinates of each body, from `Scene.digest`."""
    n = sum(name.startswith(f"{COORDINATE_DESCRIPTIONS[0]} of ") for name in description)
    return tuple(
        ", ".join(description[f"{name} of body {k}"] for name in COORDINATE_DESCRIPTIONS)
        for k in range(n)
    )


@dataclass(frozen=True, eq=False, repr=False)
class State:
    """The state of a motion at one time.

    It belongs to the bodies of a scene; joints, loads, sections and materials may change between
    two runs.

    Attributes
    ----------
    layout : Layout
        Meaning of the coordinates.
    t : float
        Time [s].
    q, v, a : (n_all,) float
        Coordinates [m for positions, 1 for slopes], velocities and accelerations [1/s, 1/s2].
    lam : (m,) float
        Multipliers of the constraints [N].
    b : (n_all,) float, optional
        Auxiliary acceleration of generalized-alpha [m/s2, 1/s2], see Arnold and Bruels (2007).
    memory : mapping
        Other data to continue the same run, empty if not available.
    """

    layout: CoordinateLayout
    t: float
    q: Vector
    v: Vector
    a: Vector
    lam: Vector
    b: Vector | None = None
    memory: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Summarise time and size in one line."""
        return f"State: t = {self.t:.6g} s, {len(self.q)} coordinates, {len(self.lam)} multipliers"


class StateHistory(NamedTuple):
    """States of a system at k times; the tables may be in a file.

    Attributes
    ----------
    q, v, a : (k, n_all) float
        Coordinates [m, 1], velocities [m/s, 1/s] and accelerations [m/s2, 1/s2].
    lam : (k, m) float
        Multipliers [N].
    t : (k,) float
        Times [s].
    internal : (k, h) or (k, 0) float
        Internal variables, empty where none are known.
    """

    q: Vector
    v: Vector
    a: Vector
    lam: Vector
    t: Vector
    internal: Vector


def check_state(scene: Scene, state: State) -> None:
    """Refuse a state of other bodies, or with values that are not finite.

    Raises
    ------
    InputError
        If so; the message names the first body or coordinate.
    """
    n = len(state.layout.q_ref)
    for name, values in (("q", state.q), ("v", state.v)):
        if np.shape(values) != (n,):
            raise InputError(
                f"{name} of start has shape {np.shape(values)}, and its scene has {n} coordinates"
            )
        invalid = np.flatnonzero(~np.isfinite(values))
        if len(invalid):
            raise InputError(
                f"{name} of start is not finite at {len(invalid)} of {n} coordinates, the first of "
                f"them number {invalid[0]}: take an earlier state, such as that of a run which "
                "ended before"
            )
    here, there = describe_coordinates(scene.digest()), state.layout.bodies
    if len(here) != len(there):
        raise InputError(
            f"start is a state of {len(there)} bodies, and this scene has {len(here)}: take a "
            "state of this scene"
        )
    for body, own, other in zip(scene.bodies, here, there, strict=True):
        if own != other:
            raise InputError(
                f"start is a state of another scene: {body.name} is {other} there, and {own} here"
            )


def transfer_state(
    scene: Scene, state: State, places: Sequence[Integers], q_ref: Vector
) -> tuple[Vector, Vector]:
    """Return coordinates and velocities of a state in another numbering.

    Raises
    ------
    InputError
        If the reference shape differs, or connected nodes do not coincide.
    """
    q, v = np.full(len(q_ref), np.nan), np.zeros(len(q_ref))
    for body, new, old in zip(scene.bodies, places, state.layout.places, strict=True):
        size = ROUNDING * float(np.max(np.abs(q_ref[new])))
        difference = np.abs(q_ref[new] - state.layout.q_ref[old])
        if np.max(difference) > size:
            raise InputError(
                f"start is a state of another scene: the stress-free shape of {body.name} differs "
                f"by up to {np.max(difference):.3g} m"
            )
        values = state.q[old]
        distance = np.abs(q[new] - values)  # NaN where not yet set
        if np.nanmax(distance, initial=0.0) > ROUNDING * np.max(np.abs(values)):
            row, _ = np.unravel_index(int(np.nanargmax(distance)), distance.shape)
            raise InputError(
                f"start has {_point(body, int(row))} {np.nanmax(distance):.3g} m from the point "
                "that it is connected to: leave out the connection, or start from a state in which "
                "they coincide"
            )
        q[new], v[new] = values, state.v[old]
    return q, v


def _point(body: Body, row: int) -> Point:
    return Point(body, int(body.row_nodes[row]))
