"""Contact of beams with obstacles, and the contributions of all contacts."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import cached_property, partial
from typing import Any, Protocol

import numpy as np

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.scene import Point
from ancfsparse.scene.force_elements.beam_contacts import BeamContact
from ancfsparse.scene.force_elements.contact_points import POINTS_PER_PART
from ancfsparse.scene.force_elements.contacts import GRIP_RATIO, LAYER_RATIO, Contact
from ancfsparse.scene.force_elements.fixed_ends import fixed_points, is_left_out
from ancfsparse.system import assembly
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.force_elements.beam_contact.beam_contacts import (
    BeamContactContribution,
)
from ancfsparse.system.contributions.force_elements.contact.axis_depths import AxisDepths
from ancfsparse.system.contributions.force_elements.contact_losses import (
    N_LOSSES,
    select_losses,
)
from ancfsparse.system.contributions.force_elements.contact_steps import (
    BRISTLE_DAMPING,
    SLOW_RATIO,
    check_contact_step,
    check_impact_step,
    find_longest_step,
    find_resolving_step,
)
from ancfsparse.system.contributions.force_elements.contact_stiffness import (
    default_stiffness,
    known_depth,
    known_depth_at_rest,
)
from ancfsparse.system.contributions.force_elements.obstacle_passages import (
    MAX_DEPTH_RATIO,
    path_lengths,
    remain_outside,
)
from ancfsparse.system.contributions.force_elements.penetrations import (
    LimitedPenetration,
    Penetration,
    PenetrationLimit,
    StartLimit,
)
from ancfsparse.system.contributions.interface import Compiled, Contribution
from ancfsparse.system.contributions.point_weights import PointSums
from ancfsparse.system.coordinates.discretization import Discretization


class CompiledContact(Compiled, Protocol):
    """A contact as a contribution (_contacts.pyx), with the largest penetration in a run [m]."""

    deepest: tuple[float, int]
    is_sticking: bool

    def forget_deepest(self) -> None:
        """Discard the penetrations of earlier states."""

    def divide(self, run_start: Integers, runs: Integers, /) -> None:
        """Assign the points to threads."""

    def forces(self, q: Vector, v: Vector, history: Vector, /) -> Vector:
        """Return normal force and friction on every point, (2, n, dim) [N]."""

    def begin_equilibria(self, q: Vector, /) -> None:
        """Let bristles be deflected by displacements from coordinates on."""

    def approach_equilibrium(self, dt: float, /) -> None:
        """Set the time since the last equilibrium [s]."""

    def accept_equilibrium(self, q: Vector, /) -> None:
        """Update the deflections of bristles to an equilibrium."""

    def end_equilibria(self) -> None:
        """Let bristles keep their deflections."""

    def sliding(self, q: Vector, /) -> Vector:
        """Return derivatives of sliding friction by penetrations, (n, dim) [N/m]."""

    def motion(self, q: Vector, v: Vector, /) -> tuple[Vector, Vector]:
        """Return sliding velocities of the points, (n, dim) [m/s], and penetrations, (n,) [m]."""

    def gradients(self, q: Vector, /) -> Vector:
        """Return derivatives of the distances of points by their coordinates, (m, dim) [1]."""

    def energy(self, q: Vector, /) -> float:
        """Return the potential of the pressures [J]."""


class ContactContribution(LimitedPenetration):
    """A contact of a system, a sum over quadrature points."""

    is_load = True
    is_contact = True

    def __init__(self, system: Discretization, contact: Contact, first_history: int) -> None:
        self._n_free, self._n_all, self.contact = system.n_free, system.n_all, contact
        # Of the deflections of bristles among the history variables of the system.
        self._first_history = first_history
        self.separates, self.sticks = contact.separates, contact.sticks
        # Points that do not touch, since a joint fixes the axis there to the obstacle.
        self._left_out = is_left_out(contact, fixed_points(contact, system.joints))
        # Of each body [N/m2].
        self.stiffness = np.array(
            [contact.stiffness or default_stiffness(system, contact, k)
             for k in range(len(contact.bodies))]
        )  # fmt: skip
        is_default = contact.stiffness is None
        # The pressure of a flat obstacle is right at any depth, so a given stiffness can be soft.
        if is_default or not contact.obstacle.is_flat:
            self.penetration_limit = PenetrationLimit(
                contact.what, is_default, exponent=1.0, restitution=contact.restitution
            )
        self._known_depth = 0.0 if is_default else known_depth_at_rest(system, contact)
        if not is_default:
            self.start_limit = StartLimit(contact.what, partial(known_depth, system, contact))
        relative: list[tuple[float, Point]] = []
        vectors: list[int] = []
        if contact.on is not None:
            # Sums have the vectors of the body among their coordinates also without weights.
            body_points = [contact.on.at(unit) for unit in np.eye(system.dim)]
            relative = [(-1.0, contact.base_point), *((0.0, each) for each in body_points)]
            origin = system.point(contact.on.origin)[0][0]
            for indices, weights in map(system.point, body_points):
                vectors += np.setdiff1d(indices[0, weights != 0.0], origin).tolist()
        self._points = PointSums.of(system, [[(1.0, point), *relative] for point in contact.points])
        self._turning = np.zeros(self._points.place.shape[1], dtype=np.int32)
        for number, vector in enumerate(vectors, 1):
            self._turning[self._points.place[0] == vector] = number
        self._compiled: CompiledContact
        is_limited = self.penetration_limit is not None
        self._make_axis_depths = partial(AxisDepths, system, contact, self._left_out, is_limited)

    def cliques(self) -> list[Indices]:
        """Return the coordinates of each point and of the body of the obstacle."""
        return self._points.cliques(self._n_free)

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled contact."""
        points, contact, obstacle = self._points, self.contact, self.contact.obstacle
        dim, normal, core = obstacle.dim, obstacle.normal_vector, obstacle.core
        n = len(contact.points)
        is_affine = obstacle.projector is not None and (contact.on is None or obstacle.is_alike)
        groups = points.groups(POINTS_PER_PART, self._n_all)
        stiffness = contact.per_point(self.stiffness) * contact.weights * ~self._left_out
        impact_times = np.full(n, np.inf) if contact.restitution else self._impact_times()
        reach = obstacle.radius + contact.per_point(contact.radii)
        layer, settling = LAYER_RATIO * contact.per_point(contact.radii), self._settling_times()
        self._compiled = compiled_module("contacts").Contact(
            points.start,
            points.place,
            points.weight,
            *groups,
            points.alike(groups, [stiffness, impact_times, reach, layer, settling]),
            points.slots(pattern, self._n_free),
            stiffness,
            impact_times,
            np.zeros(dim) if contact.on else np.array(obstacle.base),
            np.zeros(dim) if normal is None else normal,
            obstacle.projector if is_affine else np.zeros((dim, dim)),
            obstacle.spin,
            self._turning,
            normal is None,
            np.zeros((0, dim)) if is_affine else contact.frame,
            core.bounds,
            core.ring,
            core.coefficients,
            core.cell,
            reach,
            layer,
            contact.friction,
            contact.slip_speed,
            contact.static_friction,
            GRIP_RATIO,
            settling,
            contact.restitution,
            self._slow_rates(),
            self._n_all,
        )
        return self._compiled

    def divide(self, n_free: int, n_all: int, threads: int) -> bool:
        """Assign the elements to threads, unless too many share coordinates."""
        _, term, indices, _ = self._points.groups(POINTS_PER_PART, n_all)
        # Coordinates of each group; those with fewer repeat their first one.
        longest = np.arange(np.diff(term).max())
        rows = term[:-1, None] + np.where(longest < np.diff(term)[:, None], longest, 0)
        # The entries of constrained coordinates share one place in the matrix.
        tables = [np.minimum(indices[rows], np.int32(n_free)).reshape(len(rows), -1)]
        runs = assembly.partition_blocks(tables, [1], n_all, threads)
        if runs is not None:
            self._compiled.divide(*runs)
        return runs is not None

    def _impact_times(self) -> Vector:
        """Return the duration of an impact at every point, (n,) [s]."""
        masses = [body.masses_per_length for body in self.contact.bodies]
        of_points = np.concatenate(masses)[self.contact.elements]
        return np.asarray(np.pi * np.sqrt(of_points / self.contact.per_point(self.stiffness)))

    def _settling_times(self) -> Vector:
        """Return the damping of bristles over their stiffness at every point, (n,) [s]."""
        ratio = 2.0 * BRISTLE_DAMPING if self.contact.has_static_friction else 0.0
        return np.asarray(ratio / (np.pi * np.sqrt(GRIP_RATIO)) * self._impact_times())

    def _slow_rates(self) -> Vector:
        """Return speeds over penetrations below which points are damped less, (n,) [1/s]."""
        return SLOW_RATIO * self.contact.restitution * np.pi / self._impact_times()

    def resolving_step(self, keeps_energy: bool = False) -> tuple[float, str]:
        """Return the longest step that resolves its impacts [s], and its name."""
        return find_resolving_step(self.contact, float(self._impact_times().min()), keeps_energy)

    def check_step(self, dt: float, phase: float) -> None:
        """Refuse a step that does not resolve impacts with a restitution, or is not stable."""
        times = self._impact_times()
        k = int(np.argmin(times))
        stiffness = float(self.contact.per_point(self.stiffness)[k])
        impact = self.contact.what, stiffness, float(times[k]), dt
        check_contact_step(*impact, phase)
        check_impact_step(*impact, self.contact.restitution)

    def longest_step(self, phase: float) -> float:
        """Return the longest step that `check_step` admits [s]."""
        restitution = self.contact.restitution
        return find_longest_step(restitution, float(self._impact_times().min()), phase)

    @property
    def n_history(self) -> int:
        """Number of history variables: deflections of bristles, whether they slide, and losses."""
        contact = self.contact
        if not contact.sticks:
            return N_LOSSES
        of_point = contact.obstacle.dim + contact.has_static_friction
        return len(contact.points) * of_point + N_LOSSES

    def forces(self, q: Vector, v: Vector, history: Vector | None = None) -> Vector:
        """Return normal force and friction on every point in states, (k, 2, n, dim) [N].

        History variables of the system (k, h) are needed for the friction of bristles.
        """
        rows = zip(q, v, self._own_history(history, len(q)), strict=True)
        return np.array([self._compiled.forces(*map(np.ascontiguousarray, row)) for row in rows])

    def forces_on_elements(
        self, q: Vector, v: Vector, history: Vector | None
    ) -> Iterator[tuple[Indices, Vector, Vector]]:
        """Yield elements, normal forces and friction of all points in a state."""
        forces = self.forces(q[None], v[None], None if history is None else history[None])[0]
        yield self.contact.elements, *forces

    def _own_history(self, history: Vector | None, k: int) -> Vector:
        """Return its history variables in k states, (k, n_history), empty without them."""
        if history is None:
            return np.empty((k, 0))
        own = slice(self._first_history, self._first_history + self.n_history)
        return np.asarray(history)[:, own]

    def motion(self, q: Vector, v: Vector) -> tuple[Vector, Vector]:
        """Return sliding velocities of the points, (n, dim) [m/s], and penetrations, (n,) [m].

        Both are for one state; penetrations are negative where there is a gap, and at points that
        are left out.
        """
        rates, depths = self._compiled.motion(np.ascontiguousarray(q), np.ascontiguousarray(v))
        depths[self._left_out] = -np.inf
        return rates, depths

    def deepest_point(self, q: Vector) -> tuple[float, float, str, str]:
        """Return the penetration with the largest ratio to the radius, both [m], and two names."""
        depth, radius, _, where = self.deepest_at(q)
        return depth, radius, self.contact.what, where

    def deepest_at(self, q: Vector) -> Penetration:
        """Return the penetration in a state with the largest ratio to the radius."""
        depths = self.motion(q, np.zeros_like(q))[1]
        k = int(np.argmax(depths / self.contact.per_point(self.contact.radii)))
        return self._penetration(float(depths[k]), k)

    @property
    def deepest_of_motion(self) -> Penetration:
        """The penetration in the last motion with the largest ratio to the radius."""
        return self._penetration(*self._compiled.deepest)

    def _penetration(self, depth: float, k: int) -> Penetration:
        contact = self.contact
        radius, stiffness = (
            float(contact.per_point(each)[k]) for each in (contact.radii, self.stiffness)
        )
        return Penetration(depth, radius, stiffness, repr(contact.points[k]))

    def forget_deepest(self) -> None:
        """Discard the penetrations of earlier states."""
        self._compiled.forget_deepest()

    def run_warnings(self, t: Vector, q: Any) -> list[Warning]:
        """Return a warning if a point, or the axis between two points, was too deep."""
        try:
            of_axis = self._axis_depths.warnings(
                q, self.deepest_of_motion, lambda k: f"at t = {t[k]:.4g} s,"
            )
        except InputError:  # not all coordinates were saved
            of_axis = []
        return super().run_warnings(t, q) or of_axis

    def rest_warnings(self, q: Vector, when: Callable[[int], str]) -> list[Warning]:
        """Return a warning if a point, or the axis between two points, is too deep."""
        deepest = self.deepest_at(q[self._deepest_state(q)])
        of_axis = self._axis_depths.warnings(q, deepest, when)
        return super().rest_warnings(q, when) or of_axis

    @cached_property
    def _axis_depths(self) -> AxisDepths:
        return self._make_axis_depths()

    def admits(self, q0: Vector, q1: Vector) -> bool:
        """Return whether no axis enters the obstacle between two states."""
        if self.contact.obstacle.is_flat:
            return True
        rest, radii = np.zeros_like(q0), self.contact.per_point(self.contact.radii)
        lengths = path_lengths(self._points, self._turning, q0, q1)
        # With a stiffness so soft that known loads press an axis in, it may be as deep.
        limits = np.maximum(MAX_DEPTH_RATIO * radii, self._known_depth)
        return remain_outside(lambda q: self.motion(q, rest)[1], q0, q1, lengths, radii, limits)

    def begin_equilibria(self, q: Vector) -> None:
        """Let bristles be deflected by displacements from a state on, without deflections there."""
        self._compiled.begin_equilibria(np.ascontiguousarray(q))

    def approach_equilibrium(self, dt: float) -> None:
        """Set the time since the last equilibrium, for the rotation of obstacles [s]."""
        self._compiled.approach_equilibrium(dt)

    def accept_equilibrium(self, q: Vector) -> None:
        """Update the deflections of bristles to an equilibrium."""
        self._compiled.accept_equilibrium(np.ascontiguousarray(q))

    def end_equilibria(self) -> None:
        """Let bristles keep their deflections."""
        self._compiled.end_equilibria()

    def unsymmetric_stiffness(self, q: Vector) -> Any:
        """Return the derivative of friction that slides by the penetrations.

        None on a body, along which motions have other weights.
        """
        if not self.contact.sticks or self.contact.on is not None:
            return None
        q = np.ascontiguousarray(q)
        friction = self._points.weight[:, None] * self._compiled.sliding(q)[self._owners]
        return self._point_matrix(friction).T @ self._point_matrix(self._compiled.gradients(q))

    def _point_matrix(self, values: Vector) -> Any:
        """Return a matrix (n_points, n_all) of values (n, dim) along the terms of the points."""
        import scipy.sparse as sp

        columns = self._points.place
        entries = values.T.ravel(), (np.tile(self._owners, len(columns)), columns.ravel())
        return sp.csr_array(entries, shape=(len(self.contact.points), self._n_all))

    @cached_property
    def _owners(self) -> Indices:
        """The point of each of their terms."""
        return np.repeat(np.arange(len(self.contact.points)), np.diff(self._points.start))

    def set_sticking(self, is_sticking: bool) -> None:
        """Let its matrix contain the stiffness of bristles that stick, or only in steps."""
        self._compiled.is_sticking = is_sticking

    def contact_energy(self, q: Vector) -> Vector | float:
        """Return the potential of the pressures, (k,) [J]."""
        return np.array([self._compiled.energy(np.ascontiguousarray(row)) for row in q])

    def contact_losses(self, history: Vector) -> Vector | float:
        """Return work of turning obstacles and losses up to states, (k, 3) [J]."""
        return select_losses(history, self._first_history + self.n_history)

    def unilateral_forces(
        self, q: Vector, v: Vector, amplitudes: Vector
    ) -> list[tuple[str, Vector]]:
        """Return the sum of all pressures."""
        forces = np.linalg.norm(self.forces(q, v)[:, 0], axis=2).sum(axis=1)
        return [(f"the pressure of {self.contact.what} [N]", forces)]

    def resisted_motions(self, q: Vector) -> Any:
        """Return the gradients of the distances of points that are pressed."""
        pressed = self.forces(q[None], np.zeros((1, len(q))))[0, 0].any(axis=1)
        if not pressed.any():
            return None
        return self._point_matrix(self._compiled.gradients(np.ascontiguousarray(q)))[pressed]


def of(system: Discretization) -> list[Contribution]:
    """Return the contacts of a system."""
    contacts: list[Contribution] = []
    n_history = 0
    for each in system.attachments:
        if isinstance(each, Contact):
            contribution = ContactContribution(system, each, n_history)
            n_history += contribution.n_history
            contacts.append(contribution)
        if isinstance(each, BeamContact):
            of_beams = BeamContactContribution(system, each, n_history)
            n_history += of_beams.n_history
            contacts.append(of_beams)
    return contacts
