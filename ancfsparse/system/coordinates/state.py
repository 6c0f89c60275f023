"""Where a motion is at one time, apart from the stress-free shape it is counted from."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.scene import Body, Point, Scene

Vector = NDArray[np.float64]
Places = NDArray[np.int32]

# Share of the largest coordinate by which places that must agree may differ: rounding.
ROUNDING = 1e-9
# Parts of a body that give its coordinates their meaning; its section and its material may change.
COORDINATE_DESCRIPTIONS = ("element", "mesh")


class Layout(NamedTuple):
    """What the coordinates of a system are.

    Attributes
    ----------
    bodies : tuple of str
        Element and mesh of each body.
    places : list of (n_rows, n_c) int32 arrays
        Per body the place of each coordinate of each row.
    q_ref : (n_all,) float
        The stress-free shape [m, 1].
    """

    bodies: tuple[str, ...]
    places: Sequence[Places]
    q_ref: Vector

    def numbers_like(self, other: Layout) -> bool:
        """Whether all coordinates have the same places."""
        return self is other or (
            self.bodies == other.bodies and all(map(np.array_equal, self.places, other.places))
        )


def describe_coordinates(description: Mapping[str, str]) -> tuple[str, ...]:
    """Return what the coordinates of each body are, from `Scene.digest`."""
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
        What the coordinates are.
    t : float
        Time [s].
    q, v, a : (n_all,) float
        Coordinates [m for positions, 1 for slopes], their rates and second rates [1/s, 1/s2].
    lam : (m,) float
        Multipliers of the constraints [N].
    b : (n_all,) float, optional
        The integrator's own acceleration [m/s2, 1/s2], if it has one.
    memory : mapping
        What else the next steps of the same run depend on, empty if nothing is known.
    """

    layout: Layout
    t: float
    q: Vector
    v: Vector
    a: Vector
    lam: Vector
    b: Vector | None = None
    memory: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Give time and size in one line."""
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
    """

    q: Vector
    v: Vector
    a: Vector
    lam: Vector
    t: Vector


def check_state(scene: Scene, state: State) -> None:
    """Refuse a state of other bodies, or one that holds what is not a number.

    Raises
    ------
    InputError
        With the first body that differs, or the first coordinate.
    """
    n = len(state.layout.q_ref)
    for name, values in (("q", state.q), ("v", state.v)):
        if np.shape(values) != (n,):
            raise InputError(
                f"{name} of start has shape {np.shape(values)}, and its scene has {n} coordinates"
            )
        wrong = np.flatnonzero(~np.isfinite(values))
        if len(wrong):
            raise InputError(
                f"{name} of start is not finite at {len(wrong)} of {n} coordinates, the first of "
                f"them number {wrong[0]}: take an earlier state, such as that of a run which ended "
                "before"
            )
    here, there = describe_coordinates(scene.digest()), state.layout.bodies
    if len(here) != len(there):
        raise InputError(
            f"start is a state of {len(there)} bodies, and this scene has {len(here)}: take a "
            "state of this scene"
        )
    for body, mine, its in zip(scene.bodies, here, there, strict=True):
        if mine != its:
            raise InputError(
                f"start is a state of another scene: {body.name} is {its} there, and {mine} here"
            )


def transfer_state(
    scene: Scene, state: State, places: Sequence[Places], q_ref: Vector
) -> tuple[Vector, Vector]:
    """Return coordinates and velocities of a state by the places of another numbering.

    Raises
    ------
    InputError
        If the reference shape differs, or nodes that a connection joins are apart.
    """
    q, v = np.full(len(q_ref), np.nan), np.zeros(len(q_ref))
    for body, new, old in zip(scene.bodies, places, state.layout.places, strict=True):
        size = ROUNDING * float(np.max(np.abs(q_ref[new])))
        apart = np.abs(q_ref[new] - state.layout.q_ref[old])
        if np.max(apart) > size:
            raise InputError(
                f"start is a state of another scene: the stress-free shape of {body.name} differs "
                f"by up to {np.max(apart):.3g} m"
            )
        known, given = q[new], state.q[old]
        apart = np.abs(known - given)  # NaN: not known yet
        if np.nanmax(apart, initial=0.0) > ROUNDING * np.max(np.abs(given)):
            row, _ = np.unravel_index(int(np.nanargmax(apart)), apart.shape)
            raise InputError(
                f"start has {_point(body, int(row))} {np.nanmax(apart):.3g} m from the point that "
                "it is connected to: leave out the connection, or start where they meet"
            )
        q[new], v[new] = given, state.v[old]
    return q, v


def _point(body: Body, row: int) -> Point:
    return Point(body, int(body.row_nodes[row]))
