"""Reaction forces and the power of prescribed motions, from residuals and multipliers."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.scene import Point, check_node, check_point
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System


def reaction(system: System, node: Point, states: StateHistory) -> Vector:
    """Return the force of the joints on a node's position, shape (k, dim) [N].

    At fixed coordinates it is the residual without the joint, at free ones ``-phi_q^T lam``.

    Parameters
    ----------
    system : System
        The system.
    node : Point
        A node that joints constrain.
    states : StateHistory
        Its states.

    Raises
    ------
    InputError
        If no joint to the ground constrains the node, or it is not a node.
    """
    node = system.resolve(check_point("a reaction", node))
    if node.xi:
        raise InputError(
            f"a reaction needs a node, but {node!r} lies inside element {node.index}: ask for "
            "joint_force of the joint there"
        )
    places = system.rows(check_node("a reaction", node))[0, system.kind_of(node.beam).columns("r")]
    rows = {i for i, j in zip(system.constraints.i, system.constraints.j, strict=True)}
    if np.all(places < system.n_free) and rows.isdisjoint(places.tolist()):
        connected = any(joint.joins and node in joint.nodes for joint in system.joints)
        raise InputError(
            f"{node!r} is held by connections alone, and forces inside connections are not "
            "given: ask for the reaction at a pin, a clamp or a rod"
            if connected
            else f"no joint holds {node!r}, so it has no reaction"
        )
    out = np.empty((len(states.t), system.dim))
    for k, (q, residual) in enumerate(_residuals(system, states)):
        lam = states.lam[k]
        force = -(system.constraints.jacobian(q).T @ lam)
        # The residual includes the constraint forces, which are part of the reaction.
        out[k] = np.where(places < system.n_free, force[places], (residual + force)[places])
    return out


def drive_power(system: System, states: StateHistory) -> Vector:
    """Return the power of prescribed coordinates and equations, shape (k,) [W]."""
    power = np.zeros(len(states.t))
    motion = system.prescribed.history(states.t)
    first, first_equation = _first_prescribed(system, states)
    for k, (_, residual) in enumerate(_residuals(system, states)):
        power[k] = residual[first:] @ motion.v[k]
        power[k] -= states.lam[k, first_equation:] @ motion.s_rate[k]
    return power


def drive_work(system: System, states: StateHistory) -> Vector:
    """Return the work of prescribed coordinates and equations in each step, (k - 1,) [J].

    As saved by `EnergyMomentum`, accelerations and multipliers are means over the step before, and
    elastic forces are discrete gradients.  Bristles have the mean of their deflections.
    """
    q, v, a, lam = states.q, states.v, states.a, states.lam
    amplitudes = system.loads.amplitudes(states.t)
    prescribed, _ = system.prescribed.tabulate(states.t)
    values = prescribed[:, 3 * system.prescribed.n :]
    first, first_equation = _first_prescribed(system, states)
    work = np.zeros(len(states.t) - 1)
    for k in range(1, len(states.t)):
        system.set_history(0.5 * (states.internal[k - 1] + states.internal[k]))
        residual, _ = system.assembly.residual_between(
            q[k - 1],
            q[k],
            0.5 * (v[k - 1] + v[k]),
            a[k],
            lam[k],
            system.dead_load,
            0.5 * (amplitudes[k - 1] + amplitudes[k]),
        )
        work[k - 1] += residual[first:] @ (q[k, first:] - q[k - 1, first:])
        work[k - 1] -= lam[k, first_equation:] @ (values[k] - values[k - 1])
    return work


def _residuals(system: System, states: StateHistory) -> Iterator[tuple[Vector, Vector]]:
    """Yield the coordinates and the residual [N, N m] of each state, both (n_all,)."""
    amplitudes, load = system.loads.amplitudes(states.t), system.dead_load
    table = zip(states.q, states.v, states.a, states.lam, states.internal, amplitudes, strict=True)
    for q, v, a, lam, history, now in table:
        system.set_history(history)
        yield q, system.assembly.residual(q, v, a, lam, load, now)[0]


def _first_prescribed(system: System, states: StateHistory) -> tuple[int, int]:
    """Return the index of the first prescribed coordinate and of the first such equation."""
    return (
        system.n_all - system.prescribed.n,
        states.lam.shape[1] - system.prescribed.n_equations,
    )
