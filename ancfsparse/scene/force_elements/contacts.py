"""Contact of beams with obstacles, fixed or on rigid bodies, with friction, and with each other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, ClassVar, overload

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Indices, Vector
from ancfsparse.checks import check_flag, check_moderate
from ancfsparse.errors import InputError
from ancfsparse.messages import format_numbers, format_value
from ancfsparse.scene import force_elements
from ancfsparse.scene.bodies.body import Body, Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.force_elements import obstacles
from ancfsparse.scene.loads.attachment import ContactLaw, names
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import At, BodyRef, Record

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.rigid_body import RigidBody
    from ancfsparse.scene.force_elements.beam_contacts import BeamContact
    from ancfsparse.scene.force_elements.obstacles import Obstacle
    from ancfsparse.scene.joints.joint import Joint

# Thickness of the layer in which the pressure begins, over the radius of the beam: a tenth of a
# penetration of 1 % of the radius, whose position of rest it shifts by a twentieth.
LAYER_RATIO = 1e-3
# Stiffness of bristles over the one of the contact.  A cable on a drum that slides takes as many
# iterations as without friction, and with 1 in place of .1 up to five times as many.
GRIP_RATIO = 0.1


@dataclass(frozen=True, eq=False)
class ContactSpec(Record):
    """The record of `Scene.contact`."""

    body: BodyRef | tuple[BodyRef, ...]
    obstacle: Obstacle | BodyRef | tuple[BodyRef, ...]
    stiffness: float | None
    radius: float | None
    friction: float = 0.0
    slip_speed: float | None = None
    on: BodyRef | None = None
    restitution: float | None = None
    static_friction: float | None = None
    push_out: bool = False
    method = "contact"
    units: ClassVar = {"stiffness": "N/m2", "radius": "m", "slip_speed": "m/s"}

    def describe(self, at: At, made: Contact | BeamContact) -> str:
        """Describe both sides and the numbers."""
        if isinstance(made, Contact):
            sides, on = [made.bodies], "" if made.on is None else f" on {made.on.name}"
            other = f"{made.obstacle!r}{on}"
            numbers = [*made.radii, made.friction, made.slip_speed, made.stiffness or 0.0]
        else:
            sides = [made.one, made.other]
            other = ", ".join(each.name for each in made.other)
            numbers = [
                made.stiffness or 0.0,
                *(made.radius(each) for side in sides for each in side),
            ]
            if made.friction:
                numbers += [made.friction, made.slip_speed]
        numbers += [each for each in (self.restitution, self.static_friction) if each]
        body = ", ".join(each.name for each in sides[0])
        out = ", pushed out" * self.push_out
        return f"contact ({body}; {other}): {format_numbers(numbers)}{out}"


@dataclass(frozen=True, eq=False)
class Contact(ContactLaw):
    """Contact of beams and meshes with an obstacle.

    Attributes
    ----------
    bodies : tuple of Beam or Mesh
        The bodies.
    radii : tuple of float
        Distances of their surfaces from their axes [m].
    obstacle, stiffness, friction, slip_speed, on, restitution
        As in `Scene.contact`; no restitution is 0.
    static_friction
        Likewise; by default both frictions are equal.
    separates
        `push_out`.
    added_joints : tuple of Joint
        Joints of the scene that were added before.
    """

    bodies: tuple[ElasticBody, ...]
    obstacle: Obstacle
    stiffness: float | None
    radii: tuple[float, ...]
    friction: float
    slip_speed: float
    on: RigidBody | None
    restitution: float
    static_friction: float
    separates: bool
    added_joints: tuple[Joint, ...] = field(default=(), repr=False)

    @property
    def what(self) -> str:
        """Name in messages."""
        return self.name_with(self.bodies)

    def name_with(self, bodies: Sequence[Body]) -> str:
        """Return the name, in messages, of the contact for some of its bodies."""
        return f"the contact of {names(bodies)} with the {self.obstacle.noun}"

    def describe_touch(self, first: Point, last: Point) -> str:
        """Return the stretch between two points, as text."""
        return f"{self.obstacle.noun}, from {first!r} to {last!r}"

    @property
    def points(self) -> list[Point]:
        """Quadrature points on the axes of the bodies, in the order of their elements."""
        return [
            Point(body, e, x)
            for body, (elements, xi, _) in zip(self.bodies, self._point_data, strict=True)
            for e, x in zip(elements.tolist(), xi.tolist(), strict=True)
        ]

    @cached_property
    def _point_data(self) -> list[tuple[Indices, Vector, Vector]]:
        """Elements, positions and lengths of the points of each body, see `distribute_points`."""
        return [
            force_elements.distribute_points(body, radius, self.obstacle, self.added_joints)
            for body, radius in zip(self.bodies, self.radii, strict=True)
        ]

    def per_point(self, values: ArrayLike) -> Vector:
        """Return values of the bodies, repeated for each quadrature point, (k,)."""
        return np.repeat(values, [len(elements) for elements, _, _ in self._point_data])

    @property
    def elements(self) -> Indices:
        """Elements of the quadrature points, numbered among those of all bodies, (k,)."""
        first = self.per_point(self.starts).astype(np.int64)
        return np.asarray(first + np.concatenate([each[0] for each in self._point_data]))

    def notes(self, joints: Iterable[Joint]) -> list[str]:
        """Return sentences on the parts that it leaves out."""
        points = force_elements.fixed_points(self, joints)
        return [
            force_elements.describe_left_out(self.name_with((each.point.beam,)), each)
            for each in points
        ]

    @property
    def frame(self) -> Vector:
        """Axes of the core as rows, (dim, dim), in space, or along the vectors of the body `on`."""
        axes = self.obstacle.core.axes
        return axes if self.on is None else np.asarray(axes @ self.on.vectors[0].T)

    @property
    def base_point(self) -> Point:
        """Point of the body `on` at the base of the obstacle."""
        assert self.on is not None
        offset = np.array(self.obstacle.base) - self.on.positions[0]
        return self.on.at(self.on.vectors[0] @ offset)

    @property
    def weights(self) -> Vector:
        """Lengths that the quadrature points represent, (k,) [m]."""
        return np.concatenate([lengths for _, _, lengths in self._point_data])


class Contacts(SceneBase):
    """Contacts of a scene."""

    @overload
    def contact(
        self,
        body: ElasticBody | Sequence[ElasticBody],
        obstacle: Obstacle,
        *,
        stiffness: float | None = None,
        radius: float | None = None,
        friction: float = 0.0,
        static_friction: float | None = None,
        slip_speed: float | None = None,
        restitution: float | None = None,
        on: RigidBody | None = None,
        push_out: bool = False,
    ) -> Contact: ...

    @overload
    def contact(
        self,
        body: ElasticBody | Sequence[ElasticBody],
        obstacle: ElasticBody | Sequence[ElasticBody],
        *,
        stiffness: float | None = None,
        radius: float | None = None,
        friction: float = 0.0,
        static_friction: float | None = None,
        slip_speed: float | None = None,
        restitution: float | None = None,
        push_out: bool = False,
    ) -> BeamContact: ...

    def contact(
        self,
        body: ElasticBody | Sequence[ElasticBody],
        obstacle: Obstacle | ElasticBody | Sequence[ElasticBody],
        *,
        stiffness: float | None = None,
        radius: float | None = None,
        friction: float = 0.0,
        static_friction: float | None = None,
        slip_speed: float | None = None,
        restitution: float | None = None,
        on: RigidBody | None = None,
        push_out: bool = False,
    ) -> Contact | BeamContact:
        """Let beams and meshes touch an obstacle, each other, or themselves.

        The obstacle presses on the body with a force per length of the penetration e,
        k (e^3/D^2 - e^4/(2 D^3)) up to D = radius/1000 and k (e - D/2) beyond, and has a potential.
        Friction is that of bristles: springs of the stiffness k/10 between the body and the
        surface, which stick until their force reaches mu p, where p is the pressure, and then
        slide with that force.  With a `static_friction` mu_s they stick until it reaches mu_s p.
        With `slip_speed` friction is mu p u / sqrt(u^2 + slip_speed^2) against the sliding velocity
        u instead, and a body that would stick creeps: under a fraction f of the force of full
        sliding with ``slip_speed f / sqrt(1 - f^2)``.

        Parameters
        ----------
        body : Beam or Mesh, or sequence of these
            The body or bodies, with given element and number of elements; ``scene.beams`` are all
            that have been added.
        obstacle : HalfSpace, Drum, Ball, Capsule, Block, Torus, TriangleMesh, HeightField or body
            The obstacle, or one or several bodies.  Each body on one side touches each body on the
            other side; a body on both sides touches itself.
        stiffness : float, optional
            Force per length and penetration k [N/m2].  A line of weight w per length that rests on
            it sinks in by w/k, one under the tension T around a drum of radius R by T/(R k).  By
            default 2 (w + T/R) over 1 % of the radius, with the initial tension, all weights, and
            all point forces that are constants or signals in T, or more, so that an impact after a
            fall from where the body begins sinks in by at most 1 % of the radius, with a
            restitution by 10 %.  Between bodies a crossing is assumed to bear the weight of a line
            over the extent of a body.
        radius : float, optional
            Distance of the surface of the body from its axis [m]; by default half the diameter of a
            round section, and needed for others.  If given, it is that of all bodies.
        friction : float, optional
            Coefficient of friction mu [-].
        static_friction : float, optional
            Static coefficient of friction, at least `friction` [-]; by default equal to it.  A
            point, or pair of elements, that slides sticks again where its sliding stops or turns.
        slip_speed : float, optional
            Sliding velocity at which friction has 0.71 of its full force [m/s]; by default bodies
            stick.  Explicit integrators need it.
        restitution : float, optional
            Coefficient of restitution eps of impacts, the relative speed after an impact over that
            before it, larger than 0 and at most 1 [-].  The pressure is multiplied by
            1 + gamma tanh(e'/u) with gamma = (1 - eps^2)/(1 + eps^2), u = eps sqrt(k/m) (e + D)/20
            and the mass m per length; between beams see the notes.  A fixed step must be at most
            eps/12 of the duration of an impact, pi sqrt(m/k), where m is the reduced mass of both
            beams.  By default damping is numerical only, see the notes.
        on : RigidBody, optional
            The rigid body that the obstacle is a part of; the obstacle is given in its position at
            the start.  It moves and turns with the body, and the forces act on both.
        push_out : bool, optional
            Whether bodies that begin inside each other are moved apart, by the least motion that
            leaves a penetration of at most 1 % of the radius and satisfies all joints; see
            `assemble`.  Runs and equilibria without a `start` begin there.

        Returns
        -------
        Contact or BeamContact
            The handle, for ``run.contact_force(contact)``.

        Raises
        ------
        InputError
            If an argument is invalid, the body begins inside the obstacle by more than 5 % of its
            radius, with a given stiffness by more than its radius, or an element is longer than a
            quarter of its circumference.

        Notes
        -----
        The force is evaluated at three Gauss points of each element, or of each part of it at free
        ends and where elements are long for a round obstacle.  Without a `restitution`,
        `EnergyMomentum` conserves the energy of an impact with any step.  With other implicit
        integrators an impact loses energy if it takes few steps: 1 % with 15, all with two.  In
        equilibria bristles are deflected by displacements since the last equilibrium, and friction
        with a `slip_speed` vanishes.

        Two bodies press on each other with k e per length, integrated where they overlap; planar
        ones lie in one plane.  Two elements that touch have one bristle, and
        with a `restitution` one factor 1 + gamma tanh(10 W'/(eps sqrt(K/M) W)) of all pressures,
        where W is their energy, K the stiffness of all points at which the two bodies touch [N/m]
        and M their reduced mass [kg].
        Friction opposes the relative motion of points of both axes, without the motion of surfaces
        by rotation, and acts on these points, without a moment.  A body touches itself where the
        arc between two places is longer than half a turn of its radius and two elements.

        Near a joint that fixes the body inside an obstacle (added before the contact) or to the
        other body, contact leaves out the axis over the penetration there plus the distance of axis
        and surface, or of both axes, when they touch.
        """
        one = force_elements.check_bodies(body, self._own)
        law = force_elements.check_law(one, friction, slip_speed, restitution, static_friction)
        if stiffness is not None:
            stiffness = check_moderate(
                f"stiffness of the contact of {names(one)}", stiffness, "N/m2"
            )
        push_out = check_flag("push_out", push_out)
        contact: Contact | BeamContact
        if isinstance(obstacle, obstacles.Obstacle):
            if obstacle.dim != self.dim:
                raise InputError(
                    f"the {obstacle.noun} has {obstacle.dim} coordinates and the scene {self.dim}"
                )
            if on is not None:
                self._own("a contact", force_elements.check_on(obstacle, on))
            radii = tuple(force_elements.radius_of(each, radius) for each in one)
            contact = Contact(
                one,
                obstacle,
                stiffness,
                radii,
                on=on,
                separates=push_out,
                added_joints=tuple(self.joints),
                **law,
            )
            force_elements.check_contact(contact, self.joints, self.attachments)
        elif isinstance(obstacle, ElasticBody | list | tuple):
            other = force_elements.check_bodies(obstacle, self._own)
            if on is not None:
                raise InputError(
                    f"on= of a contact is for obstacles: leave it out for {names(other)}"
                )
            bodies = tuple(dict.fromkeys((*one, *other)))
            radii = tuple(force_elements.radius_of(each, radius) for each in bodies)
            contact = force_elements.BeamContact(
                bodies, one, other, stiffness, radii, separates=push_out, **law
            )
            force_elements.check_pairs(contact, self.attachments)
        else:
            raise InputError(
                f"contact of {names(one)} needs one of {', '.join(obstacles.OBSTACLE_TYPES)}, a "
                f"list of bodies, a beam or a mesh, got {format_value(obstacle)}"
            )
        record = ContactSpec(
            _reference(body),
            obstacle if isinstance(obstacle, obstacles.Obstacle) else _reference(obstacle),
            stiffness,
            radius if radius is None else radii[0],
            contact.friction,
            slip_speed if slip_speed is None else contact.slip_speed,
            None if on is None else BodyRef(on.name),
            restitution if restitution is None else contact.restitution,
            static_friction if static_friction is None else contact.static_friction,
            push_out,
        )
        return self._attach(contact, record)


def _reference(side: ElasticBody | Sequence[ElasticBody]) -> BodyRef | tuple[BodyRef, ...]:
    """Return the bodies of a side as data."""
    if isinstance(side, ElasticBody):
        return BodyRef(side.name)
    return tuple(BodyRef(each.name) for each in side)
