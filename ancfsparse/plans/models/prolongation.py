"""Prolongation: an equilibrium on one mesh as initial guess on a finer one."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.kernels.hermite import position_weights, slope_weights
from ancfsparse.results import Trajectory
from ancfsparse.scene import Beam, Body, Scene
from ancfsparse.system import State
from ancfsparse.system.coordinates.numbering import reference_coordinates
from ancfsparse.system.coordinates.state import CoordinateLayout, describe_coordinates


def prolongate(run: Trajectory, scene: Scene) -> State | None:
    """Return the last state of a run, interpolated on another mesh, without multipliers.

    It is an initial guess for `solve_static` of the same scene with that mesh; None if elements
    differ.
    """
    system = run.system
    bodies = list(zip(system.bodies, system.places, strict=True))
    if len(bodies) != len(scene.bodies):
        return None
    indices, q, n = [], [], 0
    for (old, where), new in zip(bodies, scene.bodies, strict=True):
        rows = _interpolate(old, new, np.asarray(run.q)[-1][where])
        if rows is None:
            return None
        q.append(rows.ravel())
        indices.append(np.arange(n, n + rows.size, dtype=np.int32).reshape(rows.shape))
        n += rows.size
    q_ref = np.concatenate([reference_coordinates(body).ravel() for body in scene.bodies])
    layout = CoordinateLayout(describe_coordinates(scene.digest()), indices, q_ref)
    rest = np.zeros(n)
    return State(layout, float(run.t[-1]), np.concatenate(q), rest, rest, np.zeros(0))


def _interpolate(old: Body, new: Body, q: Vector) -> Vector | None:
    """Return the coordinates of a body on another mesh, (n_rows, n_c); None if they differ."""
    if old.kind != new.kind:
        return None
    if not (isinstance(old, Beam) and isinstance(new, Beam)):
        return q if len(old.row_nodes) == len(new.row_nodes) else None
    kind, arcs = new.kind, old.arcs
    # A stiffer beam under a given tension has another stress-free length.
    s = new.arcs * (old.length / new.length)
    element = np.clip(np.searchsorted(arcs, s, side="right") - 1, 0, old.n_elements - 1)
    length = old.lengths[element]
    xi = np.clip((s - arcs[element]) / length, 0.0, 1.0)
    ends = q[element], q[element + 1]
    out = (1.0 - xi)[:, None] * ends[0] + xi[:, None] * ends[1]
    if kind.is_string:
        return out
    r, slopes = kind.columns("r"), kind.columns("r_x")
    nodal = np.stack([ends[0][:, r], ends[0][:, slopes], ends[1][:, r], ends[1][:, slopes]], axis=1)
    out[:, r] = np.einsum("nk,nkd->nd", position_weights(xi, length), nodal)
    out[:, slopes] = np.einsum("nk,nkd->nd", slope_weights(xi, length), nodal)
    return out
