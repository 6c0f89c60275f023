"""Assembly: satisfy joints, prescribed motions and contacts by the least motion of a scene."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_finite
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import AssemblyError, InputError
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.results.solutions.assembly import Assembly
from ancfsparse.scene import Scene, check_scene
from ancfsparse.seeds import SparseSeed
from ancfsparse.solve.initial_conditions.consistent_state import violated_lengths
from ancfsparse.solve.initial_conditions.restart import check_start
from ancfsparse.solve.linearization.linearized_system import RELATIVE_FLEXIBILITY
from ancfsparse.solve.linearization.matrices import coupled_seed
from ancfsparse.solve.preparation.memory_estimate import (
    check_factor_fits,
    estimate_memory,
    within_memory,
)
from ancfsparse.solve.statics.separation import Separation
from ancfsparse.system import State, System

if TYPE_CHECKING:
    from ancfsparse.system.assembly.assembly_protocol import CompiledAssembly


N_MATRICES = 8  # arrays on the pattern
# Bodies then deform only where rigid motions do not suffice; it is well above rounding.
MASS_RATIO = 1e-8  # mass over stiffness in the norm of a motion
MAX_ROTATION = 0.1  # change of a slope in a correction [rad]
MAX_CORRECTIONS = 300  # corrections
MIN_CORRECTIONS = 60  # corrections after which they must have decreased
DIFFERENCE_RATIO = 1e-6  # prescribed displacement over which forces are differentiated, relative
ROUNDING_UNITS = 256.0  # of a constraint, in units of eps


def assemble(scene: Scene, *, t: float = 0.0) -> Assembly:
    """Move a scene to satisfy joints, prescribed motions and contacts, regardless of loads.

    The motion is minimal in the norm of the masses, and bodies deform only where they must.
    ``simulate(scene, ..., start=assemble(scene))`` starts there, and ``solve_static(scene,
    start=assemble(scene))`` finds the equilibrium near it.  Bodies of a contact with
    ``push_out=True`` that begin inside each other are moved apart.

    Parameters
    ----------
    scene : Scene
        Bodies and joints; the reference shape may violate the joints, as by prescribed motions that
        begin elsewhere or by ``connect(..., apart=True)``.
    t : float, optional
        Time of the prescribed motions [s].

    Returns
    -------
    Assembly
        The state, the violation before, and the displacements of the nodes.

    Raises
    ------
    InputError
        If an argument is invalid, bodies cannot be moved apart, or the factor cannot fit in memory.
    AssemblyError
        If the joints cannot be satisfied together from here; the most violated is named.

    Notes
    -----
    Gauss-Newton corrections, each the minimal motion that satisfies the linearized equations, in
    the norm of the strain energy and, where that is zero, of the mass.  Deformed bodies are not in
    equilibrium.
    """
    check_scene(scene)
    t = check_finite("t", t, "s")
    with within_memory(estimate_memory(scene, matrices=N_MATRICES)):
        system = System(scene)
        return _AssemblyEquations(system, t).run()


def separate_bodies(scene: Scene) -> tuple[State | None, str]:
    """Return the initial state to which contacts with ``push_out=True`` move a scene, if they do.

    It has the initial velocities of the scene; a description of the motion is returned with it.

    Raises
    ------
    InputError
        If bodies cannot be moved apart.
    AssemblyError
        If the joints cannot be satisfied as well.
    """
    assembly = assemble(scene)
    if not assembly.moved:
        return None, ""
    return replace(assembly.state, v=assembly.system.v0), assembly.description


def find_initial_state(scene: Scene, start: object) -> tuple[State | None, str]:
    """Return the state of an argument `start`, None for the reference shape.

    Without a `start`, contacts with ``push_out=True`` can move the scene; a description of the
    motion is returned too.
    """
    state = check_start(start)
    if state is None and any(each.separates for each in scene.attachments):
        return separate_bodies(scene)
    return state, ""


class _AssemblyEquations:
    """The equations of an assembly.

    Parameters
    ----------
    system : System
        The assembled system.
    t : float
        The time [s].
    """

    def __init__(self, system: System, t: float) -> None:
        self.system, self.t = system, t
        n, m = system.n_free, system.n_multipliers
        self.seed = SparseSeed(system.pattern.indptr, system.pattern.indices, n)
        check_factor_fits(estimate_memory(system.scene), self.seed)
        self.mass = system.mass_diagonal
        self.positions = system.positions
        slopes = np.ones(system.n_all, dtype=bool)
        slopes[self.positions] = False
        self.slopes = np.flatnonzero(slopes[:n])
        # Springs, loads and functions of the motion have no effect here.
        self.idle = np.zeros(system.loads.n_amplitudes)
        self.none, self.lam = np.zeros(system.n_all), np.zeros(m)
        self.now = system.prescribed.at(t) if system.prescribed else None
        pairs = zip(system.contributions, system.parts, strict=True)
        self.assembly: CompiledAssembly = compiled_module("assembly").Assembly(
            n,
            system.n_all,
            system.loads.n_amplitudes,
            system.pattern.indptr,
            [part for term, part in pairs if not term.is_load],
        )
        diagonal = self.assembly.material(0.0, 1.0, system.q_ref)[system.pattern.indptr[:n]]
        size = float(np.max(np.abs(diagonal) / self.mass))
        self.shift = MASS_RATIO * size or 1.0
        self.contacts = Separation(system)

    def violations(self, q: Vector) -> Vector:
        """Return the violations of the constraints, (m,) [m]."""
        args = self.none, self.none, self.lam, self.none, self.idle
        phi = np.array(self.assembly.residual(q, *args)[1])
        if self.now is not None and len(self.now.s):
            phi[len(phi) - len(self.now.s) :] -= self.now.s
        return phi[: len(self.lam)]

    def allowed(self, q: Vector) -> Vector:
        """Return the rounding of the constraints (m,) [m]."""
        span = np.max(np.abs(q[self.positions]), initial=0.0)
        return np.asarray(ROUNDING_UNITS * EPSILON * (span + self.system.constraints.sizes(q)))

    def run(self) -> Assembly:
        """Correct until constraints and prescribed coordinates are satisfied."""
        system, n = self.system, self.system.n_free
        q = system.q_ref.copy()
        gap, phi = self.prescribed_gap(q), self.violations(q)
        before = float(max(np.max(np.abs(gap)), np.max(self.reported(phi), initial=0.0)))
        depth, _, contact, _ = self.contacts.deepest(q)
        sizes: list[float] = []
        while len(sizes) < MAX_CORRECTIONS:
            joined = not gap.any() and bool(np.all(np.abs(phi) <= self.allowed(q)))
            if joined and self.contacts.is_done(q):
                worst = self.worst(self.violations(system.q_ref))
                if sizes and depth > before:
                    before, worst = depth, contact.removeprefix("the ")
                return Assembly(system, q, self.t, before, worst, self.lam)
            dq = gap.copy()
            dq[:n] = self._correction(q, gap, phi)
            rotation = float(np.max(np.abs(dq[self.slopes]), initial=0.0))
            length = self.contacts.limit_length(q, dq, MAX_ROTATION / max(MAX_ROTATION, rotation))
            if length == 0.0:
                break
            q = q + length * dq
            gap = (1.0 - length) * gap if length < 1.0 else self.none
            phi = self.violations(q)
            with np.errstate(over="ignore"):  # infinite sizes end the corrections below
                sizes.append(float(np.sqrt(self.mass @ dq[:n] ** 2 / self.mass.sum())))
            recent = sizes[: -MIN_CORRECTIONS // 2]
            decreases = len(sizes) <= MIN_CORRECTIONS or sizes[-1] <= 0.9 * min(recent)
            if not (np.isfinite(sizes[-1]) and decreases):
                break
        if joined:
            remaining, _, contact, where = self.contacts.deepest(q)
            raise InputError(
                f"push_out=True leaves a penetration of {remaining:.3g} m of {contact} at {where}, "
                f"of {depth:.3g} m at first: joints or other contacts hold the bodies there, or "
                "axes cross: move one of them"
            )
        raise AssemblyError(self.worst(phi) or "drive", float(np.max(self.reported(phi))), before)

    def prescribed_gap(self, q: Vector) -> Vector:
        """Return the missing displacements of prescribed coordinates, (n_all,) [m, 1]."""
        gap = np.zeros_like(q)
        if self.now is not None and len(self.now.q):
            first = len(q) - len(self.now.q)
            gap[first:] = self.now.q - q[first:]
        return gap

    def worst(self, phi: Vector) -> str:
        """Return the name of the most violated constraint, if any."""
        if not len(phi) or not phi.any():
            return ""
        return self.system.constraints.labels[int(np.argmax(self.reported(phi)))]

    def reported(self, phi: Vector) -> Vector:
        """Return the sizes of the violations, of distances as lengths, (m,) [m]."""
        prescribed = np.zeros(len(phi))
        if self.now is not None and len(self.now.s):
            prescribed[len(phi) - len(self.now.s) :] = self.now.s
        return np.abs(violated_lengths(self.system, phi, prescribed))

    def _correction(self, q: Vector, gap: Vector, phi: Vector) -> Vector:
        """Return the minimal motion that satisfies the linearized equations, (n_free,) [m, 1]."""
        system, n, m = self.system, self.system.n_free, self.system.n_multipliers
        values = np.array(self.assembly.material(1.0, 1.0 / self.shift, q))
        phi_q = system.constraints.jacobian(q)
        if m:
            diagonal = values[system.pattern.indptr[:n]]
            flexible = phi_q[:, :n].power(2) @ (1.0 / np.abs(diagonal))
            flexible[flexible == 0.0] = np.max(flexible, initial=1.0 / np.max(diagonal))
            values[system.pattern.indptr[n : n + m]] -= RELATIVE_FLEXIBILITY * flexible
        force, change, coupling, seed = np.zeros(n), np.zeros(m), None, self.seed
        if self.contacts:
            pressures, stiffness, coupling = self.contacts.linearize(
                q, self.mass, values[system.pattern.indptr[:n]]
            )
            values += stiffness
        if coupling is not None:
            pattern = system.pattern.indptr, system.pattern.indices
            seed, values = coupled_seed(*pattern, values, coupling, n)
        seed.factor(values)
        if gap.any():  # forces and violations by prescribed displacements
            h = DIFFERENCE_RATIO / float(np.max(np.abs(gap)))
            difference = self.assembly.force(q + h * gap) - self.assembly.force(q - h * gap)
            force, change = difference[:n] / (2.0 * h), phi_q @ gap
        target = -phi - change
        r = np.concatenate([-force / self.shift, target])
        if self.contacts:
            r[:n] -= pressures
        x = np.array(seed.solve(r))
        if m:  # the remaining violation by the flexibility
            r[:n], r[n:] = 0.0, target - phi_q[:, :n] @ x[:n]
            x += seed.solve(r)
        return x[:n]
