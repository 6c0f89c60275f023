"""The motion a simulation found, read by the names of the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.errors import InputError
from ancfsparse.integrators import EnergyMomentum
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.data.solved_system import Array, SolvedSystem, combine
from ancfsparse.results.data.stored_tables import Chosen, StoredState
from ancfsparse.results.fields.energy_balance import Energy, energy_of
from ancfsparse.results.solutions.trajectory_output import Outputs
from ancfsparse.scene import ElasticBody, Joint, Point
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    from ancfsparse.results.fields.joint_forces import JointForce
    from ancfsparse.results.fields.rigid_body_motion import BodyMotion
    from ancfsparse.results.fields.section_forces import SectionForce, Where
    from ancfsparse.scene.bodies.rigid_body import RigidBody
    from ancfsparse.scene.force_elements.ropes import Rope
    from ancfsparse.scene.mechanisms.winch import Winch


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory(Outputs):
    """Saved states of a run, the first one included.

    Parameters
    ----------
    system : SolvedSystem
        The system that moved.
    t : ndarray, shape (k,)
        Times [s].
    q, v, a : ndarray, shape (k, n)
        Coordinates (m for positions, dimensionless for slopes), their rates and second rates; of
        a run with ``output`` or ``save_nodes`` tables that are read like arrays (`tables`).
    lam : ndarray, shape (k, m)
        Multipliers of the constraints, none for joints made by numbering.
    stats : RunStats
        What the run cost.
    settings : mapping, optional
        What it was run with.
    ending : State or StoredState, optional
        The last state with what the steps after it depend on, where that is known.
    """

    system: SolvedSystem
    t: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    stats: RunStats
    settings: Mapping[str, Any] = field(default_factory=dict)
    ending: State | StoredState | None = None

    def __repr__(self) -> str:
        """Sum the run up in two lines."""
        stats = self.stats
        return (
            f"Trajectory: {len(self.t)} states from t = {self.t[0]:.6g} s to {self.t[-1]:.6g} s, "
            f"{self.q.shape[1]} coordinates, {self.lam.shape[1]} multipliers\n  "
            + ("" if self.finished else f"unfinished: {self._aim}; ")
            + (
                f"{stats.steps} steps"
                + (f", {stats.short_steps} shorter ones" if stats.short_steps else "")
                + f", {stats.iterations_per_step:.2f} iterations per step, "
                f"{stats.factorizations} factorizations, {stats.march_seconds:.3g} s"
                if stats.steps or len(self.t) == 1
                else "ended without its counts"
            )
            + (f", {stats.solver}" if stats.solver else "")
        )

    @property
    def finished(self) -> bool:
        """Whether the run came to the end, and to the accuracy, that it was started for."""
        accuracy = self.settings.get("accuracy")
        return self._ended and (accuracy is None or self.stats.error <= accuracy)

    @property
    def _ended(self) -> bool:
        t_end = self.settings.get("t_end")
        return t_end is None or bool(self.t[-1] >= t_end * (1.0 - 1e-9))

    @property
    def _aim(self) -> str:
        """Report what the run did not reach."""
        if self._ended:
            error = f"the error is about {self.stats.error:.3g} m"
            return f"accuracy is {self.settings['accuracy']:.3g} m, {error}"
        return f"t_end is {self.settings['t_end']:.6g} s"

    @property
    def multipliers(self) -> Array:
        """Multipliers of the constraints, shape (k, m); another name for `lam`."""
        return self.lam

    @property
    def last(self) -> State:
        """The last state, from which ``simulate(..., start=run.last)`` continues.

        Raises
        ------
        InputError
            If only some coordinates were kept, and the run was ended from outside.
        """
        if self.ending is not None:
            return self.ending if isinstance(self.ending, State) else self.ending.read(self.system)
        if isinstance(self.q, Chosen):
            raise InputError(
                "the run ended early and kept only some coordinates (save_nodes), so its last "
                "state is not known: run again without save_nodes, or with an earlier t_end"
            )
        rows = (np.array(table[-1]) for table in (self.q, self.v, self.a, self.lam))
        return self.system.state(float(self.t[-1]), *rows)

    @cached_property
    def energy(self) -> Energy:
        """The energy balance, worked out when first asked for."""
        means = self.settings.get("integrator") == repr(EnergyMomentum())
        lag = 0.5 * self.settings["dt"] if means else 0.0
        return energy_of(self.system, self.t, self.q, self.v, self.a, self.lam, lag)

    def position(self, node: Point) -> Array:
        """Give the position of a point over time.

        Parameters
        ----------
        node : Point
            Any point of a beam, for example ``rod.end``.

        Returns
        -------
        ndarray, shape (k, dim)
            Positions [m].
        """
        return combine(self.system.point(node), self.q)

    def velocity(self, node: Point) -> Array:
        """Give the velocity of a point over time.

        Parameters
        ----------
        node : Point
            Any point of a beam.

        Returns
        -------
        ndarray, shape (k, dim)
            Velocities [m/s].
        """
        return combine(self.system.point(node), self.v)

    def acceleration(self, node: Point) -> Array:
        """Give the acceleration of a point over time.

        Parameters
        ----------
        node : Point
            Any point of a beam.

        Returns
        -------
        ndarray, shape (k, dim)
            Accelerations [m/s2].
        """
        return combine(self.system.point(node), self.a)

    def slope(self, node: Point) -> Array:
        """Give the slope r', the derivative of position by reference arc length, over time.

        Parameters
        ----------
        node : Point
            Any point of a beam.

        Returns
        -------
        ndarray, shape (k, dim)
            Slopes [-]; their length is the local stretch.
        """
        return combine(self.system.slope(node), self.q)

    def body(self, body: RigidBody) -> BodyMotion:
        """Return the motion of a rigid body.

        Parameters
        ----------
        body : RigidBody
            One of the scene, as `add_body` returned it.

        Returns
        -------
        BodyMotion
            Over time: ``centre``, ``velocity``, ``rotation``, ``quaternion``, ``angles``,
            ``angular_velocity``, ``momentum``, ``angular_momentum`` and ``kinetic_energy``.
        """
        from ancfsparse.results.fields.rigid_body_motion import motion_of

        return motion_of(self.system, self.q, self.v, body)

    def reaction(self, node: Point) -> Array:
        """Give the force that the joints at a node exert on the beam, over time.

        Parameters
        ----------
        node : Point
            A node with a joint.

        Returns
        -------
        ndarray, shape (k, dim)
            Forces [N].
        """
        return self.system.reaction(node, self.q, self.v, self.a, self.lam, self.t)

    def joint_force(self, joint: Joint, frame: str = "space") -> JointForce:
        """Give the force and the moment of a joint over time.

        Parameters
        ----------
        joint : Joint
            One of the scene, as its method returned it, such as ``scene.revolute(...)``; of a
            drive, of what it drives.
        frame : str, optional
            ``"space"``; or ``"joint"``, the axes of the joint: the axis it has, or the first one of
            space, and those across it, which turn with its second side and stand still at the
            ground.

        Returns
        -------
        JointForce
            ``force`` (k, dim) [N] on the first side, and ``moment`` (k, 3) about its point, in the
            plane (k,) [N m]; on the second side act the opposite ones.

        Raises
        ------
        InputError
            If the joint does not belong to the scene, or has no axes.
        SingularSceneError
            If other joints hold the same coordinates, so that its force is not determined.

        Notes
        -----
        Of a joint made by equations they follow from its multipliers; of one made by numbering
        from what its sides lack for the balance without it.  Where equations repeat others, see
        `RedundantConstraintsWarning`, their forces are distributed arbitrarily.  `EnergyMomentum`
        saves means over the step before.
        """
        from ancfsparse.results.fields.joint_forces import joint_force
        from ancfsparse.system.recovery.joint_forces import States

        states = States(*(np.asarray(each) for each in (self.q, self.v, self.a, self.lam, self.t)))
        return joint_force(self.system, joint, states, frame)

    def tension(self, rope: Rope | Winch) -> Array:
        """Give the tension of a rope over time, shape (k,) [N]; of a winch negative in pressure.

        Parameters
        ----------
        rope : Rope or Winch
            One of the scene, as ``scene.rope`` or ``scene.winch`` returned it.
        """
        from ancfsparse.results.fields.joint_forces import tension
        from ancfsparse.system.recovery.joint_forces import States

        states = States(*(np.asarray(each) for each in (self.q, self.v, self.a, self.lam, self.t)))
        return tension(self.system, rope, states)

    def strain(self, body: ElasticBody, s: Where = None) -> Array:
        """Give the strain of the axis over time.

        Parameters
        ----------
        body : Beam or Mesh
            One of the bodies.
        s : float, array_like of shape (p,), or sequence of Point, optional
            Arc coordinates along a beam [m], or points of a beam or a mesh, such as
            ``[mesh.at(3, 0.1)]``; a node between two elements counts with the one that begins
            there.  By default the middle of every element, in the order of elements or edges.

        Returns
        -------
        ndarray, shape (k, p)
            Elongation per length of the reference shape, |r'| - 1 [-].

        Raises
        ------
        InputError
            If the body is not of the run, or a point is not on it.
        """
        from ancfsparse.results.fields.section_forces import strain

        return strain(self.system, self.q, body, s)

    def curvature(self, body: ElasticBody, s: Where = None) -> Array:
        """Give the curvature of the axis over time.

        Parameters
        ----------
        body, s
            As in `strain`.

        Returns
        -------
        ndarray, shape (k, p) in the plane or (k, p, 3)
            Turn per length of the reference shape [1/m]: in the plane counterclockwise; of a cable
            in space as a vector in space; of a thick beam in space its twist and its curvatures
            about e_y and e_z of the section.
        """
        from ancfsparse.results.fields.section_forces import curvature

        return curvature(self.system, self.q, body, s)

    def section_force(self, body: ElasticBody, s: Where = None) -> SectionForce:
        """Give axial force, shear, bending moment and torsion over time.

        Parameters
        ----------
        body, s
            As in `strain`.

        Returns
        -------
        SectionForce
            ``N``, ``Q``, ``M`` and ``T`` in the axes of the section, ``force`` and ``moment`` in
            space [N], [N m]: of the part beyond, at larger s, on the part before.
        """
        from ancfsparse.results.fields.section_forces import section_force

        return section_force(self.system, self.q, self.v, self.t, body, s)
