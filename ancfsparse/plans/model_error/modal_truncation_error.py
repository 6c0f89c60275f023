"""Error of a sum of modes for a small motion: nonlinear forces, and the modes left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.plans.model_error.effects import LINEAR_FRACTION
from ancfsparse.plans.model_error.quasi_static_error import N_SAMPLES
from ancfsparse.plans.quantities.quantity import Quantity
from ancfsparse.results import RunStats, Trajectory
from ancfsparse.results.solutions.modes import Modes
from ancfsparse.results.solutions.selected_states import select_states
from ancfsparse.solve.statics.equilibrium_equations import EquilibriumEquations, StaticState
from ancfsparse.system import State, System


def factor_equations(system: System, about: State) -> EquilibriumEquations | None:
    """Return the equilibrium equations at a state, factored; None if not positive definite."""
    equations = EquilibriumEquations(system, RunStats(), t=about.t)
    here = equations.state(about.q, about.lam, 1.0)
    is_definite = equations.factor(here, equations.stiffness(here, 1.0), 1.0) == 0
    return equations if is_definite else None


def linear_response(
    system: System, about: State, equations: EquilibriumEquations, times: Vector
) -> Vector:
    """Return the linear static displacements by the loads at some times, (k, n_all) [m, 1]."""
    rest = np.zeros(system.n_all)
    out = np.zeros((len(times), system.n_all))
    for row, amplitudes in zip(out, system.loads.amplitudes(times), strict=True):
        r, phi = system.assembly.residual(
            about.q, rest, rest, about.lam, system.dead_load, np.asarray(amplitudes)
        )
        loaded = StaticState(about.q, about.lam, np.asarray(r)[: system.n_free], np.asarray(phi))
        dx, _ = equations.correction(loaded)
        row[: len(dx)] = dx
    return out


def largest_displacement(system: System, displacements: Vector) -> Vector:
    """Return the displacement, of (k, n_all), with the largest nodal coordinate, (n_all,)."""
    largest = np.abs(displacements[:, system.positions]).max(axis=1).argmax()
    return np.asarray(displacements[largest])


def vibration_amplitude(modes: Modes, system: System, static: Vector) -> Vector:
    """Return twice the static displacement plus the modal amplitudes of velocities, (n_all,)."""
    rates = modes.shapes @ np.asarray(system.assembly.inertia(modes.about.v))
    return np.asarray(2.0 * static + (rates / np.sqrt(modes.eigenvalues)) @ modes.shapes)


def rayleigh_frequency(
    system: System, about: State, equations: EquilibriumEquations, x: Vector
) -> float:
    """Return the angular frequency of a displacement (n_all,) by Rayleigh's quotient [1/s]."""
    there = equations.state(about.q + LINEAR_FRACTION * x, about.lam, 1.0)
    back = equations.state(about.q - LINEAR_FRACTION * x, about.lam, 1.0)
    force = (there.r - back.r) / (2.0 * LINEAR_FRACTION)
    mass = float(np.asarray(system.assembly.inertia(x)) @ x)
    work = float(force @ x[: len(force)])
    return (max(work, 0.0) / mass) ** 0.5 if mass > 0.0 else 0.0


def nonlinear_drift(
    equations: EquilibriumEquations, system: System, about: State, x: Vector, phase: float
) -> float:
    """Return the largest nodal displacement by nonlinear forces at a displacement x [m]."""
    even, odd = _nonlinear_displacements(equations, system, about, x)
    return max_node_displacement(system, even + max(1.0, phase) * odd)


def truncation_bound(modes: Modes, system: System, displacements: Vector) -> float:
    """Return a bound of the nodal displacement in modes that are left out [m]."""
    rates = part_outside_modes(modes, system, modes.about.v[None]) / np.sqrt(modes.eigenvalues[-1])
    static = part_outside_modes(modes, system, displacements)
    return 2.0 * max_node_displacement(system, static) + max_node_displacement(system, rates)


def part_outside_modes(modes: Modes, system: System, displacements: Vector) -> Vector:
    """Return the part of displacements (k, n_all) that is mass-orthogonal to the modes."""
    momenta = np.stack([np.asarray(system.assembly.inertia(x)) for x in displacements])
    return np.asarray(displacements - (momenta @ modes.shapes.T) @ modes.shapes)


def max_node_displacement(system: System, displacements: Vector) -> float:
    """Return the largest displacement of a node in (n_all,) or (k, n_all) coordinates [m]."""
    rows = np.atleast_2d(displacements)
    positions = rows[:, system.positions].reshape(len(rows), -1, system.dim)
    return float(np.linalg.norm(positions, axis=2).max(initial=0.0))


def modal_sum_errors(modes: Modes, run: Trajectory, quantity: Quantity) -> dict[str, float]:
    """Estimate the difference of a quantity between a sum of modes and the complete motion.

    The run is that of `modal_response` for the modes.

    Returns
    -------
    dict of str to float
        Largest difference over time [unit of the quantity].

        - ``"nonlinearity"``: by forces that are nonlinear in the displacements x.  Their even part
          changes x statically by x2; their odd part, about that, by x3 times half the phase of the
          motion, since a changed frequency lets it drift.  So does the change of stiffness by the
          mean displacement: that part of x2 which is linear in the vibration about the static
          displacements, and along it.
        - ``"modes"``: twice the static displacements by loads in the modes left out, and the part
          of initial velocities in them.
    """
    system, about = run.system, modes.about
    assert isinstance(system, System)
    equations = factor_equations(system, about)
    if equations is None:
        return {"nonlinearity": np.inf}
    x = np.asarray(run.q) - about.q
    farthest = int(np.argmax(np.abs(x[:, system.positions]).max(axis=1)))
    samples = np.unique([*np.linspace(0, len(x) - 1, N_SAMPLES).astype(int), farthest])
    omega = mean_frequency(run)
    phase = max(1.0, 0.5 * omega * float(run.t[-1] - run.t[0]))

    def nonlinear(displacements: Vector) -> tuple[Vector, ...]:
        pairs = (_nonlinear_displacements(equations, system, about, each) for each in displacements)
        return tuple(map(np.stack, zip(*pairs, strict=True)))

    response = linear_response(system, about, equations, np.asarray(run.t)[samples])
    mean, vibration = x.mean(axis=0), x[samples] - response
    even, odd = nonlinear(x[samples])
    (ahead, _), (behind, _) = nonlinear(mean + vibration), nonlinear(mean - vibration)
    momenta = np.stack([np.asarray(system.assembly.inertia(each)) for each in vibration])
    softer = 0.5 * np.einsum("sn,sn->s", momenta, ahead - behind)
    softer /= np.maximum(np.einsum("sn,sn->s", momenta, vibration), np.finfo(float).tiny)
    q, v = np.asarray(run.q)[samples], np.asarray(run.v)[samples]
    drift = phase * (odd + softer[:, None] * vibration)
    change = even + drift
    rate = omega * (2.0 * even + drift)
    nonlinearity = _change(run, quantity, samples, q + change, v + rate)
    outside = 2.0 * part_outside_modes(modes, system, response)
    velocity = part_outside_modes(modes, system, about.v[None])[0]
    next_omega = float(np.sqrt(abs(modes.eigenvalues[-1])))
    if velocity.any():
        outside = outside + velocity / next_omega
    missing = _change(run, quantity, samples, q + outside, v + next_omega * outside)
    return {"nonlinearity": nonlinearity, "modes": missing}


def mean_frequency(run: Trajectory) -> float:
    """Return the mass-weighted mean angular frequency of a motion [1/s]."""
    system = run.system
    assert isinstance(system, System)
    from_mean = np.asarray(run.q) - np.mean(run.q, axis=0)
    x, v = (
        float(sum(np.asarray(system.assembly.inertia(row)) @ row for row in rows))
        for rows in (from_mean, np.asarray(run.v))
    )
    return (v / x) ** 0.5 if x > 0.0 else 0.0


def _nonlinear_displacements(
    equations: EquilibriumEquations, system: System, start: State, x: Vector
) -> tuple[Vector, Vector]:
    """Return the static displacements by the even and the odd part of the nonlinear forces at x."""
    about, lam = start.q, start.lam
    rest = equations.state(about, lam, 1.0)

    def solve(r: Vector, phi: Vector) -> Vector:
        dx, _ = equations.correction(StaticState(about, lam, r, phi))
        return np.append(dx, np.zeros(system.n_all - len(dx)))

    even, before = np.zeros_like(x), np.inf
    while True:
        there, back = (equations.state(about + sign * x + even, lam, 1.0) for sign in (1.0, -1.0))
        correction = solve(
            0.5 * (there.r + back.r) - rest.r, 0.5 * (there.phi + back.phi) - rest.phi
        )
        size = max_node_displacement(system, correction)
        if not size < 0.5 * before:  # converged, or too far for the stiffness of the start
            break
        even, before = even + correction, size
    there, back = (equations.state(about + sign * x + even, lam, 1.0) for sign in (1.0, -1.0))
    odd = solve(0.5 * (there.r - back.r), 0.5 * (there.phi - back.phi))
    return even, -odd - x


def _change(run: Trajectory, quantity: Quantity, samples: Vector, q: Vector, v: Vector) -> float:
    """Return the largest change of a quantity with other coordinates and velocities."""
    states = select_states(run, samples)
    changed = replace(states, q=q, v=v)
    return quantity.largest_difference(quantity.history(changed), quantity.history(states))
