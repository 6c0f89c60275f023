"""Forces of joints and drives, from what is missing for equilibrium and from multipliers."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.errors import InputError
from ancfsparse.scene import Point, check_node, check_point

if TYPE_CHECKING:
    from ancfsparse.system.system import System

Vector = NDArray[np.float64]


def reaction(
    system: System, node: Point, q: Vector, v: Vector, a: Vector, lam: Vector, t: Vector
) -> Vector:
    """Return the force of the joints on a node's position, shape (k, dim) [N].

    Parameters
    ----------
    system : System
        What moves.
    node : Point
        A node that joints hold.
    q, v, a : (k, n_all) float
        States.
    lam : (k, m) float
        Multipliers [N].
    t : (k,) float
        Times [s].

    Raises
    ------
    InputError
        If no joint to the ground holds the node, or it is not a node.
    """
    node = system.own(check_point("a reaction", node))
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
    amplitudes = system.loads.amplitudes(t)
    out = np.empty((len(t), system.dim))
    for k in range(len(t)):
        r, _ = system.assembly.residual(q[k], v[k], a[k], lam[k], system.dead_load, amplitudes[k])
        held = -(system.constraints.jacobian(q[k]).T @ lam[k])
        # The residual counts the force of the multipliers as part of the balance.
        out[k] = np.where(places < system.n_free, held[places], (r + held)[places])
    return out


def drive_power(system: System, q: Vector, v: Vector, a: Vector, lam: Vector, t: Vector) -> Vector:
    """Return the power of what drives coordinates and equations, shape (k,) [W].

    The arguments are those of `reaction`.
    """
    power, amplitudes = np.zeros(len(t)), system.loads.amplitudes(t)
    velocities, rates = system.prescribed.rates(t)
    driven, led = system.n_all - system.prescribed.n, lam.shape[1] - system.prescribed.n_equations
    for k in range(len(t)):
        r, _ = system.assembly.residual(q[k], v[k], a[k], lam[k], system.dead_load, amplitudes[k])
        power[k] += r[driven:] @ velocities[k] - lam[k, led:] @ rates[k]
    return power


def drive_work(system: System, q: Vector, v: Vector, a: Vector, lam: Vector, t: Vector) -> Vector:
    """Return the work of what drives coordinates and equations in each step, (k - 1,) [J].

    Accelerations and multipliers are means over the step before, as those of `EnergyMomentum`, and
    elastic forces discrete gradients.  The other arguments are those of `reaction`.
    """
    amplitudes = system.loads.amplitudes(t)
    prescribed, _ = system.prescribed.tabulate(t)
    leads = prescribed[:, 3 * system.prescribed.n :]
    driven, led = system.n_all - system.prescribed.n, lam.shape[1] - system.prescribed.n_equations
    work = np.zeros(len(t) - 1)
    for k in range(1, len(t)):
        r, _ = system.assembly.residual_between(
            q[k - 1],
            q[k],
            0.5 * (v[k - 1] + v[k]),
            a[k],
            lam[k],
            system.dead_load,
            0.5 * (amplitudes[k - 1] + amplitudes[k]),
        )
        work[k - 1] += r[driven:] @ (q[k, driven:] - q[k - 1, driven:])
        work[k - 1] -= lam[k, led:] @ (leads[k] - leads[k - 1])
    return work
