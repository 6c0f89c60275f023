"""Contact of beams with each other and with themselves."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.scene.force_elements.beam_contacts import (
    BeamContact,
    following_elements,
    free_ends,
    untouched_elements,
)
from ancfsparse.scene.force_elements.contacts import GRIP_RATIO
from ancfsparse.scene.force_elements.fixed_ends import MAX_START_DEPTH_RATIO
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.force_elements.beam_contact.compiled_interface import (
    CompiledBeamContact,
)
from ancfsparse.system.contributions.force_elements.beam_contact.touch_matrices import (
    TouchMatrices,
)
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
    default_stiffness_between,
)
from ancfsparse.system.contributions.force_elements.penetrations import (
    LimitedPenetration,
    Penetration,
    PenetrationLimit,
)
from ancfsparse.system.contributions.interface import (
    Compiled,
    matrix_unknowns,
    offsets_of,
    sum_of,
)
from ancfsparse.system.coordinates.discretization import Discretization

# Pairs that touch and stick, per element: in dense packings of parallel cables up to 6.
SLOTS_PER_ELEMENT = 8
# Largest penetration after a correction of an equilibrium, over the distance of the axes at the
# touch.  First corrections of straight cables are long, and deep penetrations have forces far above
# the loads, which make the matrix indefinite as they turn with the normals.  Two straight cables
# that cross take 12 corrections with 1e10 N/m2, and 33 with 0.5.
MAX_FIRST_DEPTH = 0.003
# The same over the penetration before, if that is more.  With 3e4 N/m2 they take 14
# corrections, and 65 without it.
MAX_GROWTH = 8.0
# In piles the forces of a touching pair, with the search, take 11 us, the time of 140 000 of an
# element's operations.  With these a pile of 30 cables evaluates 27 % fewer residuals and 3 % more
# factors than with none, in 15 % less time; a knot 17 % fewer and 54 % more, in the same time.
OPERATIONS_PER_PAIR = 140_000


class BeamContactContribution(LimitedPenetration):
    """A contact of beams of a system."""

    is_load = True
    is_contact = True
    is_between_beams = True

    def __init__(self, system: Discretization, contact: BeamContact, first_history: int) -> None:
        self._system, self.contact = system, contact
        self.separates, self.sticks = contact.separates, contact.sticks
        # Of the bristles of pairs among the history variables of the system.
        self._first_history = first_history
        self.stiffness = contact.stiffness or default_stiffness_between(system, contact)
        self.penetration_limit = PenetrationLimit(
            contact.what, contact.stiffness is None, 1.5, contact.restitution
        )
        self._indices = np.concatenate([_axis_indices(system, body) for body in contact.bodies])
        self.compiled: CompiledBeamContact
        self._matrices: TouchMatrices

    @property
    def _straight(self) -> Integers:
        flags = [body.kind.is_string for body in self.contact.bodies]
        return self.contact.per_element(flags).astype(np.int32)

    def cliques(self) -> list[Indices]:
        """Return the coordinates of each element."""
        n = len(self._indices)
        unknowns = matrix_unknowns(self._indices.copy(), self._system.n_free)
        unknowns[self._straight.astype(bool), 1::2] = -1
        return [unknowns.reshape(n, -1)]

    def coupled_pairs(self) -> list[tuple[Any, Indices]]:
        """Return the compiled list of touching elements, and the unknowns of each element."""
        return [(self.compiled, self.cliques()[0])]

    def operations(self) -> int:
        """Return the arithmetic operations of its forces, by the pairs that touch."""
        return OPERATIONS_PER_PAIR * len(self.compiled.coupled_pairs)

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled contact; raise if bodies begin inside each other."""
        contact, system = self.contact, self._system
        lengths = np.concatenate([body.lengths for body in contact.bodies])
        near = untouched_elements(contact, system.joints)
        self.compiled = compiled_module("beam_contacts").BeamContact(
            self._indices,
            pattern.slots(self.cliques()[0]),
            lengths,
            contact.per_element(contact.radii),
            self._straight,
            contact.per_element(contact.sides).astype(np.int32),
            contact.per_element(range(len(contact.bodies))).astype(np.int32),
            np.concatenate([free_ends(body) for body in contact.bodies]),
            offsets_of(near),
            np.concatenate([np.empty(0, dtype=np.int32), *near]).astype(np.int32),
            np.concatenate([body.masses_per_length for body in contact.bodies]),
            self.stiffness,
            contact.friction,
            contact.slip_speed,
            contact.static_friction,
            GRIP_RATIO,
            np.concatenate(list(self._following())),
            self._n_slots,
            2.0 * BRISTLE_DAMPING,
            contact.restitution,
            SLOW_RATIO * contact.restitution,
            np.array([body.total_mass for body in contact.bodies]),
        )
        self._matrices = TouchMatrices(lengths, self.compiled, self._indices, self._straight)
        if np.array_equal(system.q0, system.q_ref) and not self.separates:
            self._check_start(system.q0)
        return self.compiled

    def divide(self, n_free: int, n_all: int, threads: int) -> bool:
        """Distribute the pairs of elements among threads."""
        self.compiled.divide(threads)
        return True

    def _following(self) -> Iterator[Integers]:
        """Yield the elements that continue those of each body, numbered among all."""
        for body, first in zip(self.contact.bodies, self.contact.starts, strict=True):
            table = following_elements(body)
            yield np.where(table < 0, -1, table + first).astype(np.int32)

    @property
    def n_history(self) -> int:
        """Number of history variables: code, stiffness and force of the bristle of each pair.

        With a static friction also whether it slides.  Losses are the last ones.
        """
        width = 2 + self._system.dim + self.contact.has_static_friction
        return self._n_slots * width + N_LOSSES

    @property
    def _n_slots(self) -> int:
        return SLOTS_PER_ELEMENT * len(self._indices) if self.contact.sticks else 0

    def friction(self, q: Vector, v: Vector, history: Vector | None) -> Vector:
        """Return friction on the points that touch, (k, dim) [N].

        History variables of the system are needed for bristles.
        """
        own = slice(self._first_history, self._first_history + self.n_history)
        of_pairs = np.empty(0) if history is None else np.ascontiguousarray(history[own])
        return self.compiled.friction(q, v, of_pairs)

    def _check_start(self, q: Vector) -> None:
        """Refuse bodies that begin inside each other."""
        depth, distance, where = self._deepest(q, lambda radii: radii.sum(axis=1))
        if depth > MAX_START_DEPTH_RATIO * distance:
            raise InputError(
                f"{self.contact.what} begins with a penetration of {depth:.3g} m at {where}: move "
                "them apart, give contact push_out=True, or start from an equilibrium"
            )

    def deepest_point(self, q: Vector) -> tuple[float, float, str, str]:
        """Return the largest penetration and the smaller radius [m], and both names."""
        depth, radius, _, where = self.deepest_at(q)
        return depth, radius, self.contact.what, where

    def deepest_at(self, q: Vector) -> Penetration:
        """Return the penetration in a state with the largest ratio to the smaller radius."""
        depth, radius, where = self._deepest(q, lambda radii: radii.min(axis=1))
        return Penetration(depth, radius, self.stiffness, where)

    def _deepest(self, q: Vector, measure: Callable[[Vector], Vector]) -> tuple[float, float, str]:
        """Return the penetration with the largest ratio to a length [m], this, and its place.

        The length is a measure of the radii of both bodies, (k, 2).
        """
        contact = self.contact
        try:
            elements, positions, _, depths = self.compiled.touches(q)
        except InputError as crowded:
            raise InputError(f"{contact.what}: {crowded}") from None
        if not len(depths):
            return 0.0, min(contact.radii), ""
        lengths = measure(contact.per_element(contact.radii)[elements])
        k = int(np.argmax(depths / lengths))
        return float(depths[k]), float(lengths[k]), self._names(elements[k], positions[k])

    def _names(self, elements: Iterable[int], positions: Iterable[float]) -> str:
        """Return the names of a point and of its foot, in the order of the bodies."""
        pairs = sorted(zip(elements, positions, strict=True))
        return " and ".join(repr(self.contact.point(int(e), float(xi))) for e, xi in pairs)

    @property
    def deepest_of_motion(self) -> Penetration:
        """The penetration in the last motion with the largest ratio to both radii."""
        depth, elements, positions = self.compiled.deepest
        radius = float(self.contact.per_element(self.contact.radii)[list(elements)].min())
        names = self._names(elements, positions)
        return Penetration(depth, radius, self.stiffness, names)

    def forget_deepest(self) -> None:
        """Discard the penetrations of earlier states."""
        self.compiled.forget_deepest()

    def admits(self, q0: Vector, q1: Vector) -> bool:
        """Return whether no axes pass through each other between two states."""
        return self.compiled.admits(q0, q1)

    def admits_correction(self, q0: Vector, q1: Vector) -> bool:
        """Return whether also no penetration becomes far deeper."""
        if not self.admits(q0, q1):
            return False
        before, after = (self._relative_depth(q) for q in (q0, q1))
        return after <= max(MAX_FIRST_DEPTH, MAX_GROWTH * before)

    def _relative_depth(self, q: Vector) -> float:
        """Return the largest penetration over the distance of the axes at the touch."""
        depth, reach, _ = self._deepest(q, lambda radii: radii.sum(axis=1))
        return depth / reach

    def forces(
        self, q: Vector, v: Vector, history: Vector | None = None
    ) -> tuple[Vector, Vector, Vector, Vector]:
        """Return resultant on the first side, sums of sizes and largest penetration in states.

        The sums are of normal forces and of friction; that of bristles needs the history variables
        of the system (k, h).
        """
        n, contact = len(q), self.contact
        on_one = contact.per_element(contact.sides & 1)
        resultant, sizes, deepest = np.zeros((n, self._system.dim)), np.zeros((2, n)), np.zeros(n)
        for k, state in enumerate(zip(q, v, strict=True)):
            q_row, v_row = map(np.ascontiguousarray, state)
            elements, _, force, depths = self.compiled.touches(q_row, v_row)
            row = None if history is None else history[k]
            friction = self.friction(q_row, v_row, row)
            resultant[k] = (on_one[elements] @ (1.0, -1.0)) @ (force + friction)
            for size, each in zip(sizes, (force, friction), strict=True):
                size[k] = np.linalg.norm(each, axis=1).sum()
            deepest[k] = depths.max(initial=0.0)
        return resultant, *sizes, deepest

    def forces_on_elements(
        self, q: Vector, v: Vector, history: Vector | None
    ) -> Iterator[tuple[Indices, Vector, Vector]]:
        """Yield elements, normal forces and friction of all points in a state, then of the feet."""
        q, v = map(np.ascontiguousarray, (q, v))
        elements, _, force, _ = self.compiled.touches(q, v)
        along = self.friction(q, v, history)
        yield elements[:, 0], force, along
        yield elements[:, 1], -force, -along

    def check_step(self, dt: float, phase: float) -> None:
        """Refuse a step that does not resolve impacts of parallel lines, or is not stable."""
        impact = self.contact.what, self.stiffness, self._impact_time, dt
        check_contact_step(*impact, phase)
        check_impact_step(*impact, self.contact.restitution)

    def longest_step(self, phase: float) -> float:
        """Return the longest step that `check_step` admits [s]."""
        return find_longest_step(self.contact.restitution, self._impact_time, phase)

    def resolving_step(self, keeps_energy: bool = False) -> tuple[float, str]:
        """Return the longest step that resolves impacts of parallel lines [s], and its name."""
        return find_resolving_step(self.contact, self._impact_time, keeps_energy)

    @property
    def _impact_time(self) -> float:
        """Duration of an impact of parallel lines [s]."""
        sides = self.contact.one, self.contact.other
        masses = [min(body.masses_per_length.min() for body in side) for side in sides]
        return math.pi / math.sqrt(self.stiffness * sum(1.0 / float(each) for each in masses))

    def contact_energy(self, q: Vector) -> Vector | float:
        """Return the potential of the pressures, (k,) [J]."""
        return np.array([self.compiled.energy(np.ascontiguousarray(row)) for row in q])

    def contact_losses(self, history: Vector) -> Vector | float:
        """Return work of turning obstacles and losses up to states, (k, 3) [J]."""
        return select_losses(history, self._first_history + self.n_history)

    def unilateral_forces(
        self, q: Vector, v: Vector, amplitudes: Vector
    ) -> list[tuple[str, Vector]]:
        """Return the sum of all pressures."""
        return [(f"the pressure of {self.contact.what} [N]", self.forces(q, v)[1])]

    def begin_equilibria(self, q: Vector) -> None:
        """Let bristles be deflected by displacements from a state on, without deflections there."""
        self.compiled.begin_equilibria(np.ascontiguousarray(q))

    def accept_equilibrium(self, q: Vector) -> None:
        """Update the deflections of bristles to an equilibrium."""
        self.compiled.accept_equilibrium(np.ascontiguousarray(q))

    def end_equilibria(self) -> None:
        """Let bristles keep their deflections."""
        self.compiled.end_equilibria()

    def unsymmetric_stiffness(self, q: Vector) -> Any:
        """Return the derivative of friction that slides by the normal forces of its pairs."""
        return self._matrices.sliding_friction(q)

    def set_sticking(self, is_sticking: bool) -> None:
        """Let its matrix contain the stiffness of bristles that stick, or only in steps."""
        self.compiled.is_sticking = is_sticking

    def resisted_motions(self, q: Vector) -> Any:
        """Return the directions of approach of all points in contact."""
        return self._matrices.approaches(q)

    def coupling_stiffness(self, q: Vector) -> Any:
        """Return the stiffness of the pressures that the matrix has no entries for, or lacks."""
        parts = self._matrices.rotation(q), self.material_coupling(q), self._matrices.bristles(q)
        return sum_of(parts)

    def material_coupling(self, q: Vector) -> Any:
        """Return the stiffness between both elements of each point along its normal."""
        return self._matrices.between_elements(q)


def _axis_indices(system: Discretization, body: Any) -> Integers:
    """Return the indices of position and slope at both ends of each element, (n, 4, dim)."""
    body = system.resolve(body)
    kind = system.kind_of(body)
    ends = system.elements(body).reshape(body.n_elements, 2, -1)
    indices = np.zeros((body.n_elements, 4, system.dim), dtype=np.int32)
    indices[:, ::2] = ends[:, :, kind.columns("r")]
    if not kind.is_string:
        indices[:, 1::2] = ends[:, :, kind.columns("r_x")]
    return indices
