"""What a sum of modes leaves out of a small motion: forces that are not linear, and other modes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.solutions.modes import Modes
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.system import State, System

Array = NDArray[np.float64]

# States of the motion at which forces are evaluated, beside the farthest.
LOOKS = 5
# Corrections of a displacement by even forces: what it stretches is taken back in a few.
RELAXED = 4
# Share of a displacement in which forces are linear.
SMALL = 1e-3


def stiff(system: System, about: State) -> EquilibriumEquations | None:
    """Return the forces about a state, their stiffness factored; None if it is not definite."""
    equations = EquilibriumEquations(system, RunStats(), t=about.t)
    here = equations.state(about.q, about.lam, 1.0)
    return equations if equations.factor(here, equations.stiffness(here, 1.0), 1.0) == 0 else None


def pulled(system: System, about: State, equations: EquilibriumEquations, times: Array) -> Array:
    """Return how far the loads at some times move the coordinates, if linear, (k, n_all) [m, 1]."""
    rest = np.zeros(system.n_all)
    out = np.zeros((len(times), system.n_all))
    for row, amplitudes in zip(out, system.loads.amplitudes(times), strict=True):
        r, phi = system.assembly.residual(
            about.q, rest, rest, about.lam, system.dead_load, np.asarray(amplitudes)
        )
        own = StaticState(about.q, about.lam, np.asarray(r)[: system.n_free], np.asarray(phi))
        dx, _ = equations.correction(own)
        row[: len(dx)] = dx
    return out


def farthest(system: System, moved: Array) -> Array:
    """Return that one of displacements (k, n_all) that moves a node most, (n_all,)."""
    return np.asarray(moved[np.abs(moved[:, system.positions]).max(axis=1).argmax()])


def swing(modes: Modes, system: System, whole: Array) -> Array:
    """Return twice what loads move, and what velocities add by every mode, (n_all,)."""
    fast = modes.shapes @ np.asarray(system.assembly.inertia(modes.about.v))
    return np.asarray(2.0 * whole + (fast / np.sqrt(modes.eigenvalues)) @ modes.shapes)


def frequency_of(system: System, about: State, equations: EquilibriumEquations, x: Array) -> float:
    """Return the angular frequency of a displacement (n_all,), by Rayleigh's quotient [1/s]."""
    there = equations.state(about.q + SMALL * x, about.lam, 1.0)
    back = equations.state(about.q - SMALL * x, about.lam, 1.0)
    force = (there.r - back.r) / (2.0 * SMALL)
    mass = float(np.asarray(system.assembly.inertia(x)) @ x)
    work = float(force @ x[: len(force)])
    return (max(work, 0.0) / mass) ** 0.5 if mass > 0.0 else 0.0


def bent_off(
    equations: EquilibriumEquations, system: System, about: State, x: Array, turns: float
) -> float:
    """Return how far forces that are not linear move a node where x is how far it is moved [m]."""
    bent, slowed = _beside(equations, system, about, x)
    return size(system, bent + max(1.0, turns) * slowed)


def missing(modes: Modes, system: System, moved: Array) -> float:
    """Return how far modes that are left out would move a node at most [m]."""
    thrown = left_by(modes, system, modes.about.v[None]) / np.sqrt(modes.eigenvalues[-1])
    return 2.0 * size(system, left_by(modes, system, moved)) + size(system, thrown)


def left_by(modes: Modes, system: System, moved: Array) -> Array:
    """Return the part of displacements (k, n_all) that modes leave out, by their masses."""
    momenta = np.stack([np.asarray(system.assembly.inertia(x)) for x in moved])
    return np.asarray(moved - (momenta @ modes.shapes.T) @ modes.shapes)


def size(system: System, moved: Array) -> float:
    """Return how far displacements (n_all,) or (k, n_all) move a node at most [m]."""
    moved = np.atleast_2d(moved)
    places = moved[:, system.positions].reshape(len(moved), -1, system.dim)
    return float(np.linalg.norm(places, axis=2).max(initial=0.0))


def neglected(modes: Modes, run: Trajectory, quantity: Quantity) -> dict[str, float]:
    """Estimate by how much a quantity of a sum of modes differs from that of the whole motion.

    Parameters
    ----------
    modes : Modes
        Those that were summed.
    run : Trajectory
        What `modal_response` has returned for them.
    quantity : Quantity
        Of its scene.

    Returns
    -------
    dict of str to float
        Largest difference over time [unit of the quantity].

        - ``"nonlinearity"``: of forces that are not linear in the displacements x.  Their even
          part bends x by x2, the odd one, about that, by x3: statically, times half the angle
          through which the motion vibrates, since a changed frequency lets it drift.
        - ``"modes"``: twice what loads move of other modes if they are slow, and what these take
          of velocities at the start.
    """
    system, about = run.system, modes.about
    assert isinstance(system, System)
    equations = stiff(system, about)
    if equations is None:
        return {"nonlinearity": np.inf}
    moved = np.asarray(run.q) - about.q
    farthest = int(np.argmax(np.abs(moved[:, system.positions]).max(axis=1)))
    looks = np.unique([*np.linspace(0, len(moved) - 1, LOOKS).astype(int), farthest])
    omega = frequency(run)
    turns = max(1.0, 0.5 * omega * float(run.t[-1] - run.t[0]))
    bent, slowed = zip(*(_beside(equations, system, about, x) for x in moved[looks]), strict=True)
    q, v = np.asarray(run.q)[looks], np.asarray(run.v)[looks]
    more = np.stack(bent) + turns * np.stack(slowed)
    rates = omega * (2.0 * np.stack(bent) + turns * np.stack(slowed))
    off = _change(run, quantity, looks, q + more, v + rates)
    left = 2.0 * left_by(modes, system, pulled(system, about, equations, np.asarray(run.t)[looks]))
    thrown = left_by(modes, system, about.v[None])[0]
    beyond = float(np.sqrt(abs(modes.eigenvalues[-1])))
    if thrown.any():
        left = left + thrown / beyond
    missing = _change(run, quantity, looks, q + left, v + beyond * left)
    return {"nonlinearity": off, "modes": missing}


def frequency(run: Trajectory) -> float:
    """Return the angular frequency of most of a motion, by masses [1/s]."""
    system = run.system
    assert isinstance(system, System)
    apart = np.asarray(run.q) - np.mean(run.q, axis=0)
    x, v = (
        float(sum(np.asarray(system.assembly.inertia(row)) @ row for row in rows))
        for rows in (apart, np.asarray(run.v))
    )
    return (v / x) ** 0.5 if x > 0.0 else 0.0


def _beside(
    equations: EquilibriumEquations, system: System, start: State, x: Array
) -> tuple[Array, Array]:
    """Return what even and what odd forces beside the linear ones bend a displacement by."""
    about, lam = start.q, start.lam
    none = equations.state(about, lam, 1.0)

    def solved(r: Array, phi: Array) -> Array:
        dx, _ = equations.correction(StaticState(about, lam, r, phi))
        return np.append(dx, np.zeros(system.n_all - len(dx)))

    bent, before = np.zeros_like(x), np.inf
    for _ in range(RELAXED):
        there, back = (equations.state(about + sign * x + bent, lam, 1.0) for sign in (1.0, -1.0))
        even = 0.5 * (there.r + back.r) - none.r, 0.5 * (there.phi + back.phi) - none.phi
        correction = solved(*even)
        now = size(system, correction)
        if now > before:  # the stiffness of the start is no longer near
            break
        bent, before = bent + correction, now
    there, back = (equations.state(about + sign * x + bent, lam, 1.0) for sign in (1.0, -1.0))
    odd = solved(0.5 * (there.r - back.r), 0.5 * (there.phi - back.phi))
    return bent, -odd - x


def _change(run: Trajectory, quantity: Quantity, looks: Array, q: Array, v: Array) -> float:
    """Return by how much a quantity changes with other coordinates and velocities."""
    own = replace(
        run, t=run.t[looks], q=run.q[looks], v=run.v[looks], a=run.a[looks], lam=run.lam[looks]
    )
    apart = quantity.difference(quantity.history(replace(own, q=q, v=v)), quantity.history(own))
    return float(np.linalg.norm(apart, axis=1).max())
