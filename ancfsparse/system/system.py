"""The flattened scene: what every solver works on."""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ancfsparse.dispatch import compiled
from ancfsparse.errors import InputError, LoadError
from ancfsparse.scene import Joint, Point, Scene, check_scene
from ancfsparse.system.assembly.sparsity_pattern import build
from ancfsparse.system.contributions import contributions_of
from ancfsparse.system.coordinates.coordinates import Coordinates
from ancfsparse.system.coordinates.numbering import number
from ancfsparse.system.coordinates.state import Layout, State, check_state, meanings
from ancfsparse.system.loads.applied_loads import loads_of

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.ropes import Rope
    from ancfsparse.system.assembly.assembly_protocol import Assembly
    from ancfsparse.system.contributions.interface import Compiled
    from ancfsparse.system.recovery.joint_forces import States

Vector = NDArray[np.float64]

# Kernels that damping adds to others: of the strains, and of the masses.
DAMPING_KERNELS = {"residual": ("damping", "inertia"), "tangent": ("material", "mass")}


class System(Coordinates):
    """A scene as flat arrays, with compiled evaluation.

    The coordinate vector q holds the free coordinates first and the fixed ones after them; within
    each part beam by beam (or mesh by mesh) and node by node.

    Parameters
    ----------
    scene : Scene
        At least one beam or mesh.
    start : State, optional
        Where a motion starts; by default at t = 0 in the reference shape with the velocities of
        the beams.

    Attributes
    ----------
    n_free, n_all, n_multipliers : int
        Free coordinates, all coordinates, constraint equations.
    q_ref : (n_all,) float
        Stress-free coordinates [m, 1].
    t0 : float
        Time at the start [s].
    q0, v0 : (n_all,) float
        Coordinates [m, 1] and velocities [m/s, 1/s] at the start.
    gravity_load : (n_all,) float
        Generalized gravity [N, N m].
    pattern : Pattern
        Lower triangle of the saddle point matrix.
    constraints : Constraints
        The equations with multipliers.
    prescribed : Prescribed
        What the last coordinates and the last equations follow over time.
    bodies, joints, attached : tuple
        What the scene had of them, which may get more of them later.
    description : dict of str to str
        What the scene was when this was made, as `Scene.digest` describes it.
    damped : bool
        Whether any force depends on velocities.
    contributions : list of Contribution
        What adds to the equations of motion.
    parts : list of Compiled
        Their compiled parts.
    assembly : compiled object
        ``residual``, ``matrix``, ``force``, ``inertia``, ``strain_energy``.
    """

    def __init__(self, scene: Scene, start: State | None = None) -> None:
        check_scene(scene)
        if not scene.bodies:
            raise InputError(
                "the scene has no beam: add one with scene.add_beam or scene.add_mesh, or a rigid "
                "body with scene.add_body"
            )
        if any(body.automatic for body in scene.bodies):
            from ancfsparse.scene.bodies.auto_element import check_decided

            check_decided(scene.bodies)
        self.scene, self.description = scene, scene.digest()
        self.dim = scene.dim
        self.bodies, self.joints = tuple(scene.bodies), tuple(scene.joints)
        self.attached = tuple(scene.attached)
        self.kinds = [body.kind for body in self.bodies]
        if start is not None:
            check_state(scene, start)
        numbering = number(scene, self.kinds, start)
        self.n_free, self.n_all = numbering.n_free, numbering.n_all
        if self.n_free == 0:
            raise InputError("the joints hold every coordinate of the scene: nothing can move")
        self.q_ref, self.places = numbering.q_ref, numbering.places
        self.t0 = 0.0 if start is None else float(start.t)
        self.q0, self.v0 = numbering.q, numbering.v
        self._index = {id(beam): k for k, beam in enumerate(self.bodies)}
        self.constraints, self.prescribed = numbering.constraints, numbering.prescribed
        self.n_multipliers = len(self.constraints.offset)
        self.loads = loads_of(scene, self)
        self.contributions = contributions_of(self)
        cliques = [table for each in self.contributions for table in each.cliques()]
        self.pattern = build(self.n_free + self.n_multipliers, cliques)
        del cliques
        self.parts: list[Compiled] = []
        for each in self.contributions:
            self.parts.append(each.compile(self.pattern))
        self.assembly: Assembly = compiled("assembly").Assembly(
            self.n_free, self.n_all, self.loads.n_amplitudes, self.pattern.indptr, self.parts
        )
        self.damped = self.assembly.damped
        self.capsule = self.assembly.capsule
        self.gravity_load = self._gravity()
        self._memory = self.assembly.memory

    def __reduce__(self) -> tuple[type[System], tuple[Scene, State]]:
        """Pickle the scene, from which another process compiles its own; and where it starts.

        The function that gave initial velocities may not be known there.
        """
        return System, (self.scene, self.state(self.t0, self.q0, self.v0))

    def recall(self, memory: Vector) -> None:
        """Give contributions the memory of an earlier motion, which is that of the start now."""
        self.assembly.memory = self._memory = memory

    def forget(self) -> None:
        """Give contributions the memory of the start back after a motion of this system."""
        if len(self._memory):
            self.assembly.memory = self._memory

    @cached_property
    def layout(self) -> Layout:
        """What the coordinates are."""
        return Layout(meanings(self.description), self.places, self.q_ref)

    def state(
        self,
        t: float,
        q: Vector,
        v: Vector,
        a: Vector | None = None,
        lam: Vector | None = None,
        **more: Any,
    ) -> State:
        """Return a state of this system; without accelerations and multipliers they are zero."""
        a = np.zeros(self.n_all) if a is None else a
        lam = np.zeros(self.n_multipliers) if lam is None else lam
        return State(self.layout, float(t), q, v, a, lam, **more)

    @property
    def conservative(self) -> bool:
        """Whether all forces at rest have a potential."""
        return all(each.conservative for each in self.contributions)

    @property
    def gyroscopic(self) -> Any:
        """The matrix of Coriolis forces over the free coordinates, sparse [kg/s], or None."""
        return next(
            (each.gyroscopic for each in self.contributions if each.gyroscopic is not None), None
        )

    @property
    def dead_load(self) -> Vector:
        """Gravity and all constant loads together, (n_all,) [N, N m]; not to be changed."""
        constant = self.loads.constant
        return self.gravity_load + constant if constant.any() else self.gravity_load

    def energies(
        self, q: Vector, v: Vector, t: Vector | None = None
    ) -> tuple[Vector, Vector, Vector]:
        """Return kinetic, elastic and potential energies [J], each of shape (k,).

        The last one is that of gravity and, in a rotating frame, of centrifugal forces.

        Parameters
        ----------
        q, v : (k, n_all) float
            States.
        t : (k,) float, optional
            Times [s], by default that of the start.
        """
        kinetic = np.array([0.5 * row @ self.assembly.inertia(row) for row in v])
        times = np.full(len(q), self.t0) if t is None else t
        elastic = self._elastic(q, self._tuning(times))
        other = sum((each.potential(q) for each in self.contributions), np.zeros(len(q)))
        return kinetic, elastic - other, other - q @ self.gravity_load

    @property
    def winds(self) -> bool:
        """Whether lengths or strains without force change with time."""
        return self.assembly.tunes and self.loads.n_amplitudes > 0

    def winding(self, q: Vector, t: Vector) -> Vector:
        """Return the work of what changes them between consecutive states, (k - 1,) [J].

        It is the change of the energy at the same place, the mean of both places: the trapezoidal
        rule where the energy is quadratic in what changes.
        """
        given = self._tuning(t)
        before, after = q[:-1], q[1:]
        work = self._elastic(before, given[1:]) - self._elastic(before, given[:-1])
        work += self._elastic(after, given[1:]) - self._elastic(after, given[:-1])
        return 0.5 * work

    def tension(self, rope: Rope, states: States) -> Vector:
        """Return the tension of a rope, (k,) [N].

        Raises
        ------
        InputError
            If the rope is of another scene.
        """
        from ancfsparse.system.contributions.force_elements.ropes import Ropes

        for each in self.contributions:
            if isinstance(each, Ropes) and each.has(rope):
                return each.tension(rope, states.q, states.v, self.loads.amplitudes(states.t))
        raise InputError("the rope is not of the scene that moved: take one of its handles")

    def _tuning(self, times: Vector) -> Vector:
        """Return amplitudes for the energies at some times, (k, n_amplitudes)."""
        return self.loads.amplitudes(times) if self.winds else np.zeros((len(times), 0))

    def _elastic(self, q: Vector, amplitudes: Vector) -> Vector:
        rows = zip(q, amplitudes, strict=True)
        return np.array([self.assembly.strain_energy(*row) for row in rows])

    def inputs(self, times: Vector, rates: bool = False) -> tuple[Vector, LoadError | None]:
        """Return all that changes with time, up to the first time at which a function fails.

        Parameters
        ----------
        times : (k,) float
            Times [s].
        rates : bool, optional
            Whether to return the rates of what equations follow, too, for explicit integrators.

        Returns
        -------
        table : (j, n_inputs) float
            Amplitudes of the loads, then what is prescribed.
        failure : LoadError or None
            What happened at time j.
        """
        table, failure = self.loads.tabulate(times)
        if self.prescribed:
            more, failed = self.prescribed.tabulate(times[: len(table)], rates)
            table, failure = np.hstack([table[: len(more)], more]), failed or failure
        return table, failure

    def power(self, q: Vector, v: Vector, t: Vector) -> Vector:
        """Return the power of the applied forces without gravity, shape (k,) [W]."""
        amplitudes = self.loads.amplitudes(t)
        power = np.asarray(v @ self.loads.constant)
        for each in self.contributions:
            power += each.power(q, v, amplitudes)
        return power

    @property
    def is_driven(self) -> bool:
        """Whether anything is prescribed over time."""
        return bool(self.prescribed)

    def drive_power(self, q: Vector, v: Vector, a: Vector, lam: Vector, t: Vector) -> Vector:
        """Return the power of what drives coordinates and equations, shape (k,) [W]."""
        from ancfsparse.system.recovery.reactions import drive_power

        return drive_power(self, q, v, a, lam, t)

    def drive_work(self, q: Vector, v: Vector, a: Vector, lam: Vector, t: Vector) -> Vector:
        """Return the work of drives in steps between states of `EnergyMomentum`, (k - 1,) [J]."""
        from ancfsparse.system.recovery.reactions import drive_work

        return drive_work(self, q, v, a, lam, t)

    def dissipation(self, q: Vector, v: Vector, lam: Vector) -> Vector:
        """Return the power that damping takes, shape (k,) [W], of states (k, n_all), (k, m)."""
        if not self.damped:
            return np.zeros(len(q))
        states = zip(q, v, strict=True)
        out = np.array([rate @ self.assembly.damping(state, rate) for state, rate in states])
        return out + sum(each.dissipation(q, v, lam) for each in self.contributions)

    @property
    def reacts(self) -> bool:
        """Whether friction depends on the forces of joints."""
        return any(each.reacts for each in self.contributions)

    def reaction(
        self, node: Point, q: Vector, v: Vector, a: Vector, lam: Vector, t: Vector
    ) -> Vector:
        """Return the force of the joints on a node's position, shape (k, dim) [N].

        Fixed coordinates give it as what is missing for equilibrium, constraint equations as
        ``-phi_q^T lam``.

        Raises
        ------
        InputError
            If no joint to the ground holds the node, or it is not a node.
        """
        from ancfsparse.system.recovery.reactions import reaction

        return reaction(self, node, q, v, a, lam, t)

    def rows_of(self, joint: Joint) -> list[int]:
        """Return the equations of a joint, in their order."""
        from ancfsparse.system.recovery.joint_forces import rows_of

        return rows_of(self, joint)

    def joint_force(self, joint: Joint, states: States) -> tuple[Vector, Vector, Vector]:
        """Return force (k, dim) [N], moment [N m] and axes of a joint, see `joint_forces`."""
        from ancfsparse.system.recovery.joint_forces import joint_force

        return joint_force(self, joint, states)

    def energy_scale(self, q: Vector) -> float:
        """Return the size of the terms that cancel in the strain energy [J]: max |K_ii| q_i^2."""
        return float(np.max(np.abs(self.stiffness_diagonal(q)) * q[: self.n_free] ** 2))

    def stiffness_diagonal(self, q: Vector) -> Vector:
        """Return the diagonal of the stiffness over the free coordinates, (n_free,) [N/m, N m]."""
        amplitudes = self.loads.amplitudes(np.array([self.t0]))[0]
        values = self.assembly.matrix(0.0, 1.0, q, np.zeros(self.n_multipliers), amplitudes)
        return np.asarray(values[self.pattern.indptr[: self.n_free]])

    def uniform(self, direction: int) -> Vector:
        """Return the motion in which all points move by 1 along an axis of space, (n_all,)."""
        uniform = np.zeros(self.n_all)
        for places in self.vectors("r"):
            uniform[places[:, direction]] = 1.0
        return uniform

    @property
    def mass(self) -> float:
        """Mass of the scene [kg]."""
        uniform = self.uniform(0)
        return float(uniform @ self.assembly.inertia(uniform))

    @property
    def mass_diagonal(self) -> Vector:
        """Diagonal of the mass matrix over the free coordinates, (n_free,) [kg, kg m2].

        With that of equations which are added to it, since some coordinates may have no mass.
        """
        values = self.assembly.mass
        if any(self.constraints.mass):
            none = np.zeros(max(self.n_multipliers, self.loads.n_amplitudes))
            values = self.assembly.matrix(1.0, 0.0, self.q_ref, none, none)
        return np.asarray(values)[self.pattern.indptr[: self.n_free]]

    def operations(self, kernel: str) -> int:
        """Arithmetic operations of one evaluation of a kernel over all elements.

        Those of ``"residual"`` and ``"tangent"`` include damping, where there is any.
        """
        of_strains, of_mass = DAMPING_KERNELS.get(kernel, ("", ""))
        total = 0
        for beam in self.scene.beams:
            kind = self.kind_of(beam)
            each = kind.operations[kernel]
            if of_strains and beam.strains_damped:
                each += kind.operations[of_strains]
            if of_mass and beam.masses_damped:
                each += kind.operations[of_mass]
            total += beam.n_elements * each
        return total

    def _gravity(self) -> Vector:
        """Return gravity as a generalized force, (n_all,) [N, N m]."""
        uniform = np.zeros(self.n_all)
        for places in self.vectors("r"):
            uniform[places] = self.scene.gravity
        return np.asarray(self.assembly.inertia(uniform))
