"""Access to solutions by the names of the scene: points, joints, ropes and beams."""

from __future__ import annotations

from abc import abstractmethod
from contextlib import AbstractContextManager, nullcontext
from typing import TYPE_CHECKING, Any, TypeVar, cast, overload

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results import fields
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.scene import ElasticBody, Joint, Point
from ancfsparse.system import recovery
from ancfsparse.system.coordinates.state import StateHistory
from ancfsparse.system.system import System

if TYPE_CHECKING:
    from ancfsparse.results.fields.contact_forces import BeamContactForce, ContactForce
    from ancfsparse.results.fields.joint_forces import JointForce
    from ancfsparse.results.fields.section_forces import SectionForce, SectionPoints
    from ancfsparse.scene.force_elements.beam_contacts import BeamContact
    from ancfsparse.scene.force_elements.contacts import Contact
    from ancfsparse.scene.force_elements.ropes import Rope
    from ancfsparse.scene.mechanisms.winch import Winch

Values = TypeVar("Values", "Vector", "JointForce", "SectionForce", "ContactForce")


class Configurations:
    """One configuration of a scene, or k of them: all arrays then have a leading axis of length k.

    Attributes
    ----------
    system : System
        The discrete system.
    q : ndarray, shape (n,) or (k, n)
        Coordinates, m for positions and dimensionless for slopes.
    """

    system: System
    q: Vector

    def position(self, node: Point) -> Vector:
        """Return the position of a point.

        Parameters
        ----------
        node : Point
            Any point of a body, for example ``rod.end``.

        Returns
        -------
        ndarray, shape (dim,) or (k, dim)
            Position [m].
        """
        return interpolate(self.system.point(node), self.q)

    def displacement(self, node: Point) -> Vector:
        """Return the displacement of a point from the reference shape.

        Parameters
        ----------
        node : Point
            Any point of a body.

        Returns
        -------
        ndarray, shape (dim,) or (k, dim)
            Displacement [m].
        """
        return np.asarray(self.position(node) - node.position)

    def slope(self, node: Point) -> Vector:
        """Return the slope r', the derivative of the position by reference arc length.

        Parameters
        ----------
        node : Point
            Any point of a beam.

        Returns
        -------
        ndarray, shape (dim,) or (k, dim)
            Slope [-]; its length is the local stretch.
        """
        return interpolate(self.system.slope(node), self.q)


class Solution(Configurations):
    """Configurations with the forces in them: a `Trajectory` of k states or one `Equilibrium`.

    Arrays of a trajectory have a leading axis of length k, those of an equilibrium do not.
    """

    @property
    @abstractmethod
    def _states(self) -> StateHistory:
        """All states; tables may be in a file."""

    @property
    def _states_of_forces(self) -> StateHistory:
        """All states, with the multipliers that forces of joints follow from."""
        return self._states

    def _signals(self) -> AbstractContextManager[None]:
        """Return a context in which loads and motions have the values of this solution."""
        return nullcontext()

    @abstractmethod
    def _select(self, values: Values) -> Values:
        """Return values (k, ...) in the shape of this solution."""

    def reaction(self, node: Point) -> Vector:
        """Return the force of the joints at a node on the beam.

        Parameters
        ----------
        node : Point
            A node with a joint.

        Returns
        -------
        ndarray, shape (dim,) or (k, dim)
            Force [N].
        """
        with self._signals():
            return self._select(recovery.reaction(self.system, node, self._states_of_forces))

    def joint_force(self, joint: Joint, frame: str = "space") -> JointForce:
        """Return the force and the moment of a joint.

        Parameters
        ----------
        joint : Joint
            A joint of the scene, as its method returned it, such as ``scene.revolute(...)``; for a
            drive, the force on the driven body.
        frame : str, optional
            ``"space"``; or ``"joint"``, the axes of the joint: its own axis, or else the first one
            of space, and two normal to it, which rotate with its second side and are fixed if that
            is the ground.

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
            If other joints constrain the same coordinates, so that its force is not determined.

        Notes
        -----
        The forces of a joint made by equations follow from its multipliers; if it eliminates
        coordinates, from the residual of its sides without it.  If equations are redundant, see
        `RedundantConstraintsWarning`, their forces are distributed arbitrarily.  With prescribed
        motions, multipliers follow from the exact accelerations of these at the saved times;
        otherwise `EnergyMomentum` saves means over the step before.
        """
        with self._signals():
            states = StateHistory(*map(np.asarray, self._states_of_forces))
            return self._select(fields.joint_force(self.system, joint, states, frame))

    def tension(self, rope: Rope | Winch) -> Vector:
        """Return the tension of a rope, (k,) or a number [N]; of a winch negative in compression.

        Parameters
        ----------
        rope : Rope or Winch
            A rope or winch of the scene, as ``scene.rope`` or ``scene.winch`` returned it.
        """
        with self._signals():
            states = StateHistory(*map(np.asarray, self._states_of_forces))
            return self._select(fields.tension(self.system, rope, states))

    @overload
    def contact_force(self, contact: Contact | ElasticBody) -> ContactForce: ...

    @overload
    def contact_force(self, contact: BeamContact) -> BeamContactForce: ...

    def contact_force(self, contact: Contact | BeamContact | ElasticBody) -> Any:
        """Return pressure, friction and resultant force of a contact, or of all contacts of a body.

        Parameters
        ----------
        contact : Contact, BeamContact, Beam or Mesh
            A contact of the scene, as ``scene.contact`` returned it, or a body.

        Returns
        -------
        ContactForce or BeamContactForce
            Of an obstacle, ``pressure`` (k, n) and ``friction`` (k, n, dim) per length [N/m] at n
            points of the body with the arc coordinates ``s`` [m], and their resultant ``force``
            (k, dim) [N].
            Of two bodies, the resultant ``force`` (k, dim) on the first one, the sum of the sizes
            of all forces ``size`` (k,) [N], and the largest ``penetration`` (k,) [m].
            Of a body, the same as of an obstacle, for all its contacts with obstacles and bodies:
            ``pressure`` and ``friction`` are the mean values of its n elements, whose midpoints are
            at ``s``.

        Raises
        ------
        InputError
            If the contact or the body does not belong to the scene.
        """
        values: Any = fields.contact_force(self.system, contact, self._states)
        return self._select(values)

    def strain(self, body: ElasticBody, s: SectionPoints = None) -> Vector:
        """Return the strain of the axis.

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
        ndarray, shape (p,) or (k, p)
            Elongation per length of the reference shape, ``|r'|`` - 1 [-].

        Raises
        ------
        InputError
            If the body is not of the run, or a point is not on it.
        """
        return self._select(fields.strain(self.system, self._states.q, body, s))

    def curvature(self, body: ElasticBody, s: SectionPoints = None) -> Vector:
        """Return the curvature of the axis.

        Parameters
        ----------
        body, s
            As in `strain`.

        Returns
        -------
        ndarray, shape (k, p) in the plane or (k, p, 3)
            Rotation per length of the reference shape [1/m]: in the plane counterclockwise; of a
            cable in space as a vector in space; of a thick beam in space its twist and its
            curvatures about e_y and e_z of the section.  Without the first axis for an equilibrium.
        """
        return self._select(fields.curvature(self.system, self._states.q, body, s))

    def section_force(self, body: ElasticBody, s: SectionPoints = None) -> SectionForce:
        """Return axial force, shear, bending moment and torsion.

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
        states = self._states
        with self._signals():
            force = fields.section_force(self.system, states.q, states.v, states.t, body, s)
        return self._select(force)


class SingleState(Solution):
    """One configuration with the forces in it; arrays have no time axis."""

    def _select(self, values: Values) -> Values:
        if not isinstance(values, np.ndarray):
            return values.at(0)
        first: Any = values[0]
        return cast(Values, float(first) if values.ndim == 1 else first)
