"""The discrete equations of motion of a scene, on which all solvers work."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import LoadError
from ancfsparse.scene import Scene
from ancfsparse.system.assembly.sparsity_pattern import build_pattern
from ancfsparse.system.contributions.interface import sum_of
from ancfsparse.system.contributions.selection import contributions_of
from ancfsparse.system.coordinates.discretization import Discretization
from ancfsparse.system.coordinates.state import CoordinateLayout, State, describe_coordinates

if TYPE_CHECKING:
    from ancfsparse.system.assembly.assembly_protocol import CompiledAssembly


DAMPING_KERNELS = {"residual": ("damping", "inertia"), "tangent": ("material", "mass")}
"""Additional kernels for damping of the strains and of the masses."""


class System(Discretization):
    """The discrete equations of motion of a scene, with compiled evaluation.

    Attributes
    ----------
    contributions : list of Contribution
        The terms of the equations of motion.
    pattern : Pattern
        Lower triangle of the saddle point matrix.
    assembly : compiled object
        ``residual``, ``matrix``, ``force``, ``inertia``, ``strain_energy``.
    damped : bool
        Whether any force depends on velocities.
    gravity_load : (n_all,) float
        Generalized gravity [N, N m].
    is_redundant : bool
        Whether constraints repeat others at the start, as found by `warn_of_redundant_constraints`.
    """

    is_redundant = False

    def __init__(self, scene: Scene, start: State | None = None) -> None:
        super().__init__(scene, start)
        self.contributions = contributions_of(self)
        cliques = [table for each in self.contributions for table in each.cliques()]
        self.pattern = build_pattern(self.n_free + self.n_multipliers, cliques)
        del cliques
        for each in self.contributions:
            self.parts.append(each.compile(self.pattern))
        self.assembly: CompiledAssembly = compiled_module("assembly").Assembly(
            self.n_free, self.n_all, self.loads.n_amplitudes, self.pattern.indptr, self.parts
        )
        self.damped = self.assembly.damped
        self.capsule = self.assembly.capsule
        self.gravity_load = self._gravity()
        self._memory = self.assembly.memory

    def __reduce__(self) -> tuple[type[System], tuple[Scene, State]]:
        """Pickle scene and initial state, from which another process compiles its own system.

        The function of the initial velocities may be unknown there.
        """
        return System, (self.scene, self.state(self.t0, self.q0, self.v0))

    def restore_memory(self, memory: Vector) -> None:
        """Set the internal variables of contributions, here and for the start of motions."""
        self.assembly.memory = memory
        for each in self.contributions:
            each.forget_deepest()  # of another motion
        self._memory = self.assembly.memory

    def reset_memory(self) -> None:
        """Reset the internal variables of contributions to those of the start."""
        if len(self._memory):
            self.assembly.memory = self._memory

    @property
    def contact_changes(self) -> int:
        """Number of accepted steps in which points touch or separate, a sum over contacts."""
        return sum(getattr(each, "contact_changes", 0) for each in self.parts)

    def set_history(self, history: Vector) -> None:
        """Set the history variables that are saved with a state, zero if empty."""
        if self.assembly.n_history:
            memory = self.assembly.memory
            memory[self._history_indices] = history if len(history) else 0.0
            self.assembly.memory = memory

    @contextmanager
    def equilibria(self, q: Vector) -> Iterator[None]:
        """Let friction act in equilibria, by displacements from coordinates on."""
        for each in self.contributions:
            each.begin_equilibria(q)
        try:
            yield
        finally:
            for each in self.contributions:
                each.end_equilibria()

    def approach_equilibrium(self, dt: float) -> None:
        """Set the time between the last equilibrium and the next one [s]."""
        for each in self.contributions:
            each.approach_equilibrium(dt)

    def accept_equilibrium(self, q: Vector) -> None:
        """Update the history of forces to an equilibrium."""
        for each in self.contributions:
            each.accept_equilibrium(q)

    def admits(self, q0: Vector, q1: Vector) -> bool:
        """Return whether no bodies pass through each other in a straight motion to a state."""
        return all(each.admits(q0, q1) for each in self.contributions)

    def rest_warnings(self, q: Vector, when: Callable[[int], str]) -> list[Warning]:
        """Return warnings of equilibria (k, n_all); `when` names the time or load of the k-th."""
        return [each for part in self.contributions for each in part.rest_warnings(q, when)]

    def memory_at_rest(self, q: Vector) -> Vector:
        """Return the internal variables of contributions at rest, with their present history."""
        history = self.assembly.history
        self.assembly.begin(q)
        self.set_history(history)
        return self.assembly.memory

    def coupling_stiffness(self, q: Vector) -> Any:
        """Return the stiffness between elements that the pattern has no entries for, or None.

        Sparse and symmetric, (n_free, n_free) [N/m, N, N m].
        """
        n = self.n_free
        out = sum_of(each.coupling_stiffness(q) for each in self.contributions)
        return None if out is None else out[:n, :n]

    def unsymmetric_stiffness(self, q: Vector) -> Any:
        """Return the stiffness that is left out since it is unsymmetric, or None.

        Sparse, (n_free, n_free) [N/m, N, N m].
        """
        n = self.n_free
        out = sum_of(each.unsymmetric_stiffness(q) for each in self.contributions)
        return None if out is None else out[:n, :n]

    @contextmanager
    def sticking_friction(self) -> Iterator[None]:
        """Let matrices contain the stiffness of friction that sticks in the present state."""
        for each in self.contributions:
            each.set_sticking(True)
        try:
            yield
        finally:
            for each in self.contributions:
                each.set_sticking(False)

    @cached_property
    def _history_indices(self) -> Indices:
        """Indices of the history variables in the internal variables of all contributions."""
        memory = self.assembly.memory
        self.assembly.memory = np.arange(len(memory), dtype=np.float64)
        indices = self.assembly.history.astype(np.int32)
        self.assembly.memory = memory
        return indices

    @cached_property
    def layout(self) -> CoordinateLayout:
        """Meaning and indices of the coordinates."""
        return CoordinateLayout(describe_coordinates(self.description), self.places, self.q_ref)

    def state(
        self,
        t: float,
        q: Vector,
        v: Vector,
        a: Vector | None = None,
        lam: Vector | None = None,
        **more: Any,
    ) -> State:
        """Return a state of this system; accelerations and multipliers are zero by default."""
        a = np.zeros(self.n_all) if a is None else a
        lam = np.zeros(self.n_multipliers) if lam is None else lam
        return State(self.layout, float(t), q, v, a, lam, **more)

    @property
    def conservative(self) -> bool:
        """True if all forces at rest have a potential."""
        return all(each.conservative for each in self.contributions)

    @property
    def gyroscopic(self) -> Any:
        """The matrix of Coriolis forces over the free coordinates, sparse [kg/s], or None."""
        return next(
            (each.gyroscopic for each in self.contributions if each.gyroscopic is not None), None
        )

    @property
    def dead_load(self) -> Vector:
        """Sum of gravity and all constant loads, (n_all,) [N, N m]; read-only."""
        constant = self.loads.constant
        return self.gravity_load + constant if constant.any() else self.gravity_load

    def energies(
        self, q: Vector, v: Vector, t: Vector | None = None
    ) -> tuple[Vector, Vector, Vector, Vector]:
        """Return kinetic, elastic, potential and contact energies [J], each of shape (k,).

        The third one is the potential of gravity and, in a rotating frame, of centrifugal forces,
        the last one that of contact pressures.

        Parameters
        ----------
        q, v : (k, n_all) float
            States.
        t : (k,) float, optional
            Times [s], by default the initial time.
        """
        kinetic = np.array([0.5 * row @ self.assembly.inertia(row) for row in v])
        times = np.full(len(q), self.t0) if t is None else t
        elastic = self._elastic(q, self._energy_amplitudes(times))
        other, contact = np.zeros((2, len(q)))
        for each in self.contributions:
            other += each.potential(q)
            contact += each.contact_energy(q)
        return kinetic, elastic - other - contact, other - q @ self.gravity_load, contact

    @property
    def has_parametric_work(self) -> bool:
        """True if stress-free lengths or strains depend on time."""
        return self.assembly.tunes and self.loads.n_amplitudes > 0

    def parametric_work(self, q: Vector, t: Vector) -> Vector:
        """Return the work of time-dependent stress-free strains in each step, (k - 1,) [J].

        This is the change of the energy at constant coordinates, the mean of both states: the
        trapezoidal rule for energies that are quadratic in these strains.
        """
        amplitudes = self._energy_amplitudes(t)
        before, after = q[:-1], q[1:]
        work = self._elastic(before, amplitudes[1:]) - self._elastic(before, amplitudes[:-1])
        work += self._elastic(after, amplitudes[1:]) - self._elastic(after, amplitudes[:-1])
        return 0.5 * work

    def _energy_amplitudes(self, times: Vector) -> Vector:
        """Return the amplitudes that energies depend on, (k, n_amplitudes)."""
        return (
            self.loads.amplitudes(times) if self.has_parametric_work else np.zeros((len(times), 0))
        )

    def _elastic(self, q: Vector, amplitudes: Vector) -> Vector:
        rows = zip(q, amplitudes, strict=True)
        return np.array([self.assembly.strain_energy(*row) for row in rows])

    def inputs(self, times: Vector, rates: bool = False) -> tuple[Vector, LoadError | None]:
        """Return time-dependent inputs up to the first time at which a function fails.

        Parameters
        ----------
        times : (k,) float
            Times [s].
        rates : bool, optional
            Include the rates of prescribed equations, for explicit integrators.

        Returns
        -------
        table : (j, n_inputs) float
            Amplitudes of the loads, followed by prescribed values.
        failure : LoadError or None
            Failure at time j.
        """
        table, failure = self.loads.tabulate(times)
        if self.prescribed:
            more, failed = self.prescribed.tabulate(times[: len(table)], rates)
            table, failure = np.hstack([table[: len(more)], more]), failed or failure
        return table, failure

    def power(self, q: Vector, v: Vector, t: Vector) -> Vector:
        """Return the power of the applied forces except gravity, shape (k,) [W]."""
        amplitudes = self.loads.amplitudes(t)
        power = np.asarray(v @ self.loads.constant)
        for each in self.contributions:
            power += each.power(q, v, amplitudes)
        return power

    @property
    def is_driven(self) -> bool:
        """True if coordinates or equations are prescribed over time."""
        return bool(self.prescribed)

    def dissipation(self, q: Vector, v: Vector, lam: Vector) -> Vector:
        """Return the power dissipated by damping in states (k, n_all), (k, m), shape (k,) [W]."""
        if not self.damped:
            return np.zeros(len(q))
        states = zip(q, v, strict=True)
        out = np.array([rate @ self.assembly.damping(state, rate) for state, rate in states])
        return out + sum(each.dissipation(q, v, lam) for each in self.contributions)

    @property
    def depends_on_reactions(self) -> bool:
        """True if friction depends on joint forces."""
        return any(each.depends_on_reactions for each in self.contributions)

    def stiffness_diagonal(self, q: Vector) -> Vector:
        """Return the diagonal of the stiffness over the free coordinates, (n_free,) [N/m, N m]."""
        amplitudes = self.loads.amplitudes(np.array([self.t0]))[0]
        values = self.assembly.matrix(0.0, 1.0, q, np.zeros(self.n_multipliers), amplitudes)
        return np.asarray(values[self.pattern.indptr[: self.n_free]])

    def largest_length(self) -> float:
        """Return the largest position or size of a constraint at the start [m].

        It is the scale of their rounding.
        """
        positions, sizes = self.q0[self.positions], self.constraints.sizes(self.q0)
        return float(np.max(np.abs(np.concatenate([positions, sizes]))))

    @property
    def mass(self) -> float:
        """Mass of the scene [kg]."""
        uniform = self.uniform(0)
        return float(uniform @ self.assembly.inertia(uniform))

    @property
    def mass_diagonal(self) -> Vector:
        """Diagonal of the mass matrix over the free coordinates, (n_free,) [kg, kg m2].

        Includes the masses of equations, because some coordinates may have no mass.
        """
        values = self.assembly.mass
        if any(self.constraints.mass):
            none = np.zeros(max(self.n_multipliers, self.loads.n_amplitudes))
            values = self.assembly.matrix(1.0, 0.0, self.q_ref, none, none)
        return np.asarray(values)[self.pattern.indptr[: self.n_free]]

    def operations(self, kernel: str) -> int:
        """Return the arithmetic operations of one evaluation of a kernel for all elements.

        For ``"residual"`` and ``"tangent"`` they include damping.
        """
        of_strains, of_mass = DAMPING_KERNELS.get(kernel, ("", ""))
        total = 0
        for beam in self.scene.beams:
            kind = self.kind_of(beam)
            count = kind.operations[kernel]
            if of_strains and beam.strains_damped:
                count += kind.operations[of_strains]
            if of_mass and beam.masses_damped:
                count += kind.operations[of_mass]
            total += beam.n_elements * count
        return total

    def _gravity(self) -> Vector:
        """Return gravity as a generalized force, (n_all,) [N, N m]."""
        uniform = np.zeros(self.n_all)
        for places in self.vectors("r"):
            uniform[places] = self.scene.gravity
        return np.asarray(self.assembly.inertia(uniform))
