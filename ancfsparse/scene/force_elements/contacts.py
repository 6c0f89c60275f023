"""Contact of beams with obstacles, fixed or on rigid bodies, with friction, and with each other."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, overload

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_flag, check_moderate
from ancfsparse.errors import InputError
from ancfsparse.messages import format_numbers, format_value
from ancfsparse.scene import force_elements
from ancfsparse.scene.bodies.body import Point
from ancfsparse.scene.bodies.elastic_body import ElasticBody
from ancfsparse.scene.force_elements import obstacles
from ancfsparse.scene.loads.attachment import ContactLaw, check_coefficient
from ancfsparse.scene.methods.scene_base import SceneBase
from ancfsparse.scene.records.record import At, BodyRef, Record

if TYPE_CHECKING:
    from ancfsparse.scene.bodies.rigid_body import RigidBody
    from ancfsparse.scene.force_elements.beam_contacts import BeamContact
    from ancfsparse.scene.force_elements.obstacles import Obstacle
    from ancfsparse.scene.joints.joint import Joint

GAUSS_POINTS = 3  # per element, which are exact to degree five
# Thickness of the layer in which the pressure begins, over the radius of the beam: a tenth of a
# penetration of 1 % of the radius, whose position of rest it shifts by a twentieth.
LAYER_RATIO = 1e-3
# Stiffness of bristles over the one of the contact.  A cable on a drum that slides takes as many
# iterations as without friction, and with 1 in place of .1 up to five times as many.
GRIP_RATIO = 0.1


@dataclass(frozen=True, eq=False)
class ContactSpec(Record):
    """The record of `Scene.contact`."""

    body: BodyRef
    obstacle: Obstacle | BodyRef
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
        out = ", pushed out" * self.push_out
        if not isinstance(made, Contact):
            numbers = [made.stiffness, *made.radii]
            if made.friction:
                numbers += [made.friction, made.slip_speed]
            numbers += [each for each in (self.restitution, self.static_friction) if each]
            return f"contact ({self.body.body}; {made.other.name}): {format_numbers(numbers)}{out}"
        numbers = [made.radius, self.friction, self.slip_speed or 0.0, self.stiffness or 0.0]
        numbers += [each for each in (self.restitution, self.static_friction) if each]
        on = "" if self.on is None else f" on {self.on.body}"
        return f"contact ({self.body.body}; {self.obstacle!r}{on}): {format_numbers(numbers)}{out}"


@dataclass(frozen=True, eq=False)
class Contact(ContactLaw):
    """Contact of a beam or a mesh with an obstacle.

    Attributes
    ----------
    body, obstacle, stiffness, radius, friction, slip_speed, on, restitution
        As in `Scene.contact`; no restitution is 0.
    static_friction
        Likewise; by default both frictions are equal.
    separates
        `push_out`.
    """

    body: ElasticBody
    obstacle: Obstacle
    stiffness: float | None
    radius: float
    friction: float
    slip_speed: float
    on: RigidBody | None
    restitution: float
    static_friction: float
    separates: bool

    @property
    def what(self) -> str:
        """Name in messages."""
        return f"the contact of {self.body.name} with the {self.obstacle.noun}"

    @property
    def points(self) -> list[Point]:
        """Quadrature points on the axis of the body, in the order of its elements."""
        xi = 0.5 + 0.5 * np.polynomial.legendre.leggauss(GAUSS_POINTS)[0]
        return [Point(self.body, e, x) for e in range(self.body.n_elements) for x in xi.tolist()]

    def notes(self, joints: Iterable[Joint]) -> list[str]:
        """Return sentences on the parts that it leaves out."""
        points = force_elements.fixed_points(self, joints)
        return [force_elements.describe_left_out(self.what, each) for each in points]

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
        weights = 0.5 * np.polynomial.legendre.leggauss(GAUSS_POINTS)[1]
        return np.outer(self.body.lengths, weights).ravel()


class Contacts(SceneBase):
    """Contacts of a scene."""

    @overload
    def contact(
        self,
        body: ElasticBody,
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
        body: ElasticBody,
        obstacle: ElasticBody,
        *,
        stiffness: float,
        radius: float | None = None,
        friction: float = 0.0,
        static_friction: float | None = None,
        slip_speed: float | None = None,
        restitution: float | None = None,
        push_out: bool = False,
    ) -> BeamContact: ...

    def contact(
        self,
        body: ElasticBody,
        obstacle: Obstacle | ElasticBody,
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
        """Let a beam or a mesh touch an obstacle, another beam or mesh, or itself.

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
        body : Beam or Mesh
            The body, with given element and number of elements.
        obstacle : HalfSpace, Drum, Ball, Capsule, Block, Torus, TriangleMesh, HeightField or body
            The obstacle, or another body; `body` again if it touches itself.
        stiffness : float, optional
            Force per length and penetration k [N/m2].  A line of weight w per length that rests on
            it sinks in by w/k, one under the tension T around a drum of radius R by T/(R k).  By
            default 2 (w + T/R) over 1 % of the radius, with the initial tension, all weights, and
            all point forces that are constants or signals in T, or more, so that an impact after a
            fall from where the body begins sinks in by a tenth of the radius.
        radius : float, optional
            Distance of the surface of the body from its axis [m]; by default half the diameter of a
            `Circle` or `Tube`, and needed for other sections.  If given, it is that of both bodies.
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
        The force is evaluated at three Gauss points of each element.  Without a `restitution`,
        `EnergyMomentum` conserves the energy of an impact with any step.  With other implicit
        integrators an impact loses energy if it takes few steps: 1 % with 15, all with two.  In
        equilibria bristles are deflected by displacements since the last equilibrium, and friction
        with a `slip_speed` vanishes.

        Two bodies need a stiffness, and press on each other with k e per length, integrated where
        they overlap; planar ones lie in one plane.  Two elements that touch have one bristle, and
        with a `restitution` one factor 1 + gamma tanh(10 W'/(eps sqrt(K/M) W)) of all pressures,
        where W is their energy, K the stiffness of all touching points [N/m] and M the reduced mass
        of both bodies [kg].
        Friction opposes the relative motion of points of both axes, without the motion of surfaces
        by rotation, and acts on these points, without a moment.  A body touches itself where the
        arc between two places is longer than half a turn of its radius and two elements.

        Near a joint that fixes the body inside an obstacle (added before the contact) or to the
        other body, contact leaves out the axis over the penetration there plus the distance of axis
        and surface, or of both axes, when they touch.
        """
        if not isinstance(body, ElasticBody):
            raise InputError(
                f"contact needs a beam or a mesh of this scene, got {format_value(body)}"
            )
        self._own("a contact", body)
        if body.automatic:
            raise InputError(
                f"contact of {body.name} has its points inside elements: give element and "
                f"n_elements instead of 'auto' for {' and '.join(body.automatic)}"
            )
        if isinstance(obstacle, ElasticBody):
            if on is not None:
                raise InputError(
                    f"on= of a contact is for obstacles: leave it out for {obstacle.name}"
                )
            law = friction, slip_speed, restitution, static_friction
            return self._contact_of_beams(body, obstacle, stiffness, radius, *law, push_out)
        if not isinstance(obstacle, obstacles.Obstacle):
            raise InputError(
                f"contact of {body.name} needs one of {', '.join(obstacles.OBSTACLE_TYPES)}, a "
                f"beam or a mesh, got {format_value(obstacle)}"
            )
        if obstacle.dim != self.dim:
            raise InputError(
                f"the {obstacle.noun} has {obstacle.dim} coordinates and the scene {self.dim}"
            )
        contact = Contact(
            body,
            obstacle,
            None
            if stiffness is None
            else check_moderate(f"stiffness of the contact of {body.name}", stiffness, "N/m2"),
            force_elements.radius_of(body, radius),
            check_coefficient(f"friction of the contact of {body.name}", friction),
            force_elements.check_slip_speed(body, slip_speed),
            None if on is None else self._own("a contact", force_elements.check_on(obstacle, on)),
            force_elements.check_restitution(body, restitution),
            force_elements.check_static_friction(body, friction, static_friction, slip_speed),
            check_flag("push_out", push_out),
        )
        force_elements.check_reach(contact)
        if not contact.separates:
            force_elements.check_penetration(contact, self.joints)
        force_elements.check_elements(contact)
        for other in self.attachments:
            same = body, obstacle, on
            if isinstance(other, Contact) and (other.body, other.obstacle, other.on) == same:
                raise InputError(f"{contact.what} was added before: leave one of them out")
        record = ContactSpec(
            BodyRef(body.name),
            obstacle,
            contact.stiffness,
            contact.radius,
            contact.friction,
            slip_speed if slip_speed is None else contact.slip_speed,
            None if on is None else BodyRef(on.name),
            restitution if restitution is None else contact.restitution,
            static_friction if static_friction is None else contact.static_friction,
            contact.separates,
        )
        return self._attach(contact, record)

    def _contact_of_beams(
        self,
        body: ElasticBody,
        other: ElasticBody,
        stiffness: float | None,
        radius: float | None,
        friction: float,
        slip_speed: float | None,
        restitution: float | None,
        static_friction: float | None,
        push_out: bool,
    ) -> BeamContact:
        self._own("a contact", other)
        if other.automatic:
            raise InputError(
                f"contact of {body.name} with {other.name} needs element and n_elements of "
                f"{other.name} instead of 'auto' for {' and '.join(other.automatic)}"
            )
        if stiffness is None:
            raise InputError(f"contact of {body.name} with {other.name} needs a stiffness= [N/m2]")
        radii = force_elements.radius_of(body, radius), force_elements.radius_of(other, radius)
        law = friction, slip_speed, restitution, static_friction
        contact = force_elements.make_beam_contact(
            body, other, stiffness, radii, *law, push_out, self.attachments
        )
        record = ContactSpec(
            BodyRef(body.name),
            BodyRef(other.name),
            contact.stiffness,
            radius and radii[0],
            contact.friction,
            slip_speed if slip_speed is None else contact.slip_speed,
            restitution=restitution if restitution is None else contact.restitution,
            static_friction=static_friction if static_friction is None else contact.static_friction,
            push_out=contact.separates,
        )
        return self._attach(contact, record)
