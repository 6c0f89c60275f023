"""The scene: a list of beams, joints and loads, checked as they are said."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ancfsparse.errors import InputError, check_choice, check_vector
from ancfsparse.scene.beams import Beam, Node, VelocityField
from ancfsparse.scene.joints import (
    SAME_PLACE,
    Clamp,
    Connect,
    Joint,
    Pin,
    Rod,
    check_joints,
    check_node,
)
from ancfsparse.scene.loads import DistributedForce, Load, PointForce, PointMoment
from ancfsparse.scene.material import Material
from ancfsparse.scene.sections import AnySection
from ancfsparse.scene.straight import place, straight_beam

AnyJoint = TypeVar("AnyJoint", Pin, Clamp, Rod, Connect)


class Scene:
    """Beams, joints and loads in one gravity field.

    Parameters
    ----------
    gravity : array_like, shape (2,) or (3,), optional
        Acceleration of gravity [m/s2].  Two components make the scene planar, three spatial.

    Attributes
    ----------
    dim : int
        2 if planar, 3 if spatial.
    gravity : ndarray, shape (dim,)
        Acceleration of gravity [m/s2], read-only.
    beams : list of Beam
        In the order they were added.
    joints : list of Joint
        Likewise.
    loads : list of Load
        Likewise.
    """

    def __init__(self, gravity: ArrayLike = (0.0, -9.81)) -> None:
        size = np.shape(gravity)
        if size not in ((2,), (3,)):
            raise InputError(
                f"gravity must have 2 components (planar scene) or 3 (spatial), got {gravity!r}"
            )
        self.dim: int = size[0]
        self.gravity: NDArray[np.float64] = check_vector("gravity", gravity, self.dim, "m/s2")
        self.beams: list[Beam] = []
        self.joints: list[Joint] = []
        self.loads: list[Load] = []

    def __repr__(self) -> str:
        """Count what the scene holds."""
        kind = "planar" if self.dim == 2 else "spatial"
        return (
            f"{kind} scene: beams {len(self.beams)}, joints {len(self.joints)}, "
            f"loads {len(self.loads)}"
        )

    def add_beam(
        self,
        element: str,
        start: ArrayLike,
        end: ArrayLike,
        n_elements: int,
        section: AnySection,
        material: Material,
        *,
        strain: str = "green",
        curvature: str = "axis",
        section_strain: str = "consistent",
        up: ArrayLike | None = None,
        velocity: ArrayLike | VelocityField | None = None,
        name: str | None = None,
    ) -> Beam:
        """Add a beam, straight and free of stress from `start` to `end`.

        Parameters
        ----------
        element : str
            ``"l2t2"`` (planar cable), ``"thin"`` (cable), or ``"thick"`` (beam with section
            vectors, so with shear and torsion).
        start, end : array_like, shape (dim,)
            Its two ends [m], apart from each other.
        n_elements : int
            Number of elements, at least 1.
        section : Rectangle, Circle or Section
            Its cross-section.  A spatial cable bends alike in all directions and needs
            ``inertia_y`` equal to ``inertia_z``.
        material : Material
            What it is made of.
        strain : str, optional
            For ``"thin"``: ``"green"`` or ``"biot"``.
        curvature : str, optional
            For ``"thick"``: ``"axis"`` or ``"section"``.
        section_strain : str, optional
            For ``"thick"``: ``"consistent"`` or ``"nodal"``.
        up : array_like, shape (3,), optional
            Rough direction of e_y, the height of the section, in a spatial scene.  The default
            turns the section as in a planar scene: e_z as near to +z as possible,
            e_y = e_z x e_x, so a beam along +x has e_y = +y and e_z = +z.  A beam along z
            takes e_y = +y.
        velocity : array_like of shape (dim,) or callable, optional
            Initial velocity [m/s]: one for all, or a function that maps reference positions
            (k, dim) [m] to velocities (k, dim).  The default is at rest.
        name : str, optional
            How messages call it; ``"beam 0"`` for the first beam and so on if not given.

        Returns
        -------
        Beam
            The handle for joints, loads and results.

        Raises
        ------
        InputError
            If anything does not fit, with what to give instead.
        """
        label = self._label(name)
        said = {"strain": strain, "curvature": curvature, "section_strain": section_strain}
        beam = straight_beam(
            label, self.dim, element, start, end, n_elements, section, material, said, up, velocity
        )
        self.beams.append(beam)
        return beam

    def pin(self, node: Node, as_constraint: bool = False) -> Pin:
        """Hold the position of a node where it is, leave its rotation free.

        Parameters
        ----------
        node : Node
            The node, for example ``rod.start``.
        as_constraint : bool, optional
            Hold it by constraint equations, whose multipliers are the reaction, instead of by
            leaving its coordinates out.  The motion is the same.

        Returns
        -------
        Pin
            The joint.
        """
        return self._add(Pin(self._mine("a pin", check_node("a pin", node)), bool(as_constraint)))

    def clamp(self, node: Node, stretch: str = "free") -> Clamp:
        """Hold the position and the rotation of a node.

        Parameters
        ----------
        node : Node
            The node, for example ``rod.start``.
        stretch : str, optional
            For cables: ``"free"`` holds the direction of the slope, ``"fixed"`` all of it.  The
            thick beam is held in r, r_x, r_y and r_z either way.

        Returns
        -------
        Clamp
            The joint.
        """
        check_choice("stretch of a clamp", stretch, ("free", "fixed"))
        return self._add(Clamp(self._mine("a clamp", check_node("a clamp", node)), stretch))

    def rod(self, node: Node, anchor: ArrayLike) -> Rod:
        """Tie a node to a fixed point with a rigid massless rod of their initial distance.

        Parameters
        ----------
        node : Node
            The node held.
        anchor : array_like, shape (dim,)
            The fixed point [m], apart from the node.

        Returns
        -------
        Rod
            The joint.
        """
        self._mine("a rod", check_node("a rod", node))
        point = check_vector(f"anchor of the rod at {node!r}", anchor, self.dim, "m")
        length = float(np.linalg.norm(node.position - point))
        if length <= SAME_PLACE * node.beam.length:
            raise InputError(
                f"the rod at {node!r} would have zero length: its anchor {place(point)} is the "
                "node itself; to hold the node there, use pin"
            )
        return self._add(Rod(node, point, length))

    def connect(self, a: Node, b: Node) -> Connect:
        """Join two nodes at one place, free to turn against each other.

        Parameters
        ----------
        a, b : Node
            Nodes with the same reference position.

        Returns
        -------
        Connect
            The joint, spherical in a spatial scene, a revolute joint in a planar one.
        """
        self._mine("a connection", check_node("a connection", a))
        self._mine("a connection", check_node("a connection", b))
        if a == b:
            raise InputError(f"a connection needs two nodes, got {a!r} twice")
        gap = float(np.linalg.norm(a.position - b.position))
        if gap > SAME_PLACE * max(a.beam.length, b.beam.length):
            raise InputError(
                f"{a!r} and {b!r} cannot be connected: they are {gap:.6g} m apart, at "
                f"{place(a.position)} and {place(b.position)}; move one beam so that they meet"
            )
        return self._add(Connect(a, b))

    def point_force(
        self, node: Node, value: ArrayLike | Callable[[float], ArrayLike]
    ) -> PointForce:
        """Apply a force at any point of a beam.

        Parameters
        ----------
        node : Node
            Where, for example ``rod.end`` or ``rod.at(0.3)``.
        value : array_like, shape (dim,), or callable
            The force [N], fixed in space, or a function of t [s] that returns it.

        Returns
        -------
        PointForce
            The load.
        """
        if not isinstance(node, Node):
            raise InputError(f"a force needs a point on a beam such as rod.end, got {node!r}")
        load = PointForce(self._mine("a force", node), value)
        self.loads.append(load)
        return load

    def point_moment(
        self, node: Node, value: ArrayLike | Callable[[float], ArrayLike]
    ) -> PointMoment:
        """Apply a moment at a node of a beam.

        Parameters
        ----------
        node : Node
            Where, for example ``rod.end``.
        value : float, array_like of shape (3,), or callable
            The moment [N m], fixed in space, or a function of t [s] that returns it: one number
            about +z in a planar scene, three components in a spatial one.

        Returns
        -------
        PointMoment
            The load.
        """
        load = PointMoment(self._mine("a moment", check_node("a moment", node)), value)
        self.loads.append(load)
        return load

    def distributed_force(
        self, beam: Beam, value: ArrayLike | Callable[[float], ArrayLike]
    ) -> DistributedForce:
        """Apply a force per reference length along a whole beam.

        Parameters
        ----------
        beam : Beam
            Where.
        value : array_like, shape (dim,), or callable
            The force per length [N/m], fixed in space, or a function of t [s] that returns it.

        Returns
        -------
        DistributedForce
            The load.
        """
        if not isinstance(beam, Beam):
            raise InputError(f"a distributed force needs a beam of the scene, got {beam!r}")
        load = DistributedForce(self._own("a distributed force", beam), value)
        self.loads.append(load)
        return load

    def _label(self, name: str | None) -> str:
        label = f"beam {len(self.beams)}" if name is None else name
        if not isinstance(label, str) or not label.strip():
            raise InputError(f"the name of a beam must be a text that is not empty, got {name!r}")
        if any(label == each.name for each in self.beams):
            raise InputError(f"the scene already has a beam named {label!r}: give another name")
        return label

    def _own(self, what: str, beam: Beam) -> Beam:
        if not any(beam is each for each in self.beams):
            raise InputError(
                f"{what} was given {beam.name} of another scene: use a handle that add_beam of "
                "this scene returned"
            )
        return beam

    def _mine(self, what: str, node: Node) -> Node:
        self._own(what, node.beam)
        return node

    def _add(self, joint: AnyJoint) -> AnyJoint:
        check_joints(self.joints, joint)
        self.joints.append(joint)
        return joint
