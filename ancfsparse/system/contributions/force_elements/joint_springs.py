"""Springs, stops and friction in joints."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.scene.force_elements.joint_springs import RUBBING, STOP, JointSpring
from ancfsparse.scene.mechanisms.coordinate_functions import joint_coordinate
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import (
    Compiled,
    Contribution,
    matrix_unknowns,
    offsets_of,
)
from ancfsparse.system.contributions.joints.joint_coordinate_constraints import flatten
from ancfsparse.system.coordinates.discretization import Discretization
from ancfsparse.system.coordinates.joint_lowering import Lowering


class JointForceTerms(NamedTuple):
    """The force of a joint as a sum over terms of its equations, for _joint_springs.pyx."""

    row: Integers
    other: Integers
    direction: Integers
    factor: Vector
    about: Vector

    def size(self, q: Vector, lam: Vector) -> Vector:
        """Return its magnitude (k,) [N] in states q (k, n_all) with multipliers lam (k, m)."""
        arms = np.where(self.other >= 0, q[:, self.other] - self.about, 1.0)
        parts = self.factor * lam[:, self.row] * arms
        along = [parts[:, self.direction == d].sum(axis=1) for d in range(3)]
        return np.asarray(np.sqrt(np.sum(np.square(along), axis=0)))


class JointSpringContribution(Contribution):
    """Springs, stops and friction along the joint coordinates of a system."""

    is_load = True

    def __init__(self, system: Discretization, springs: list[JointSpring]) -> None:
        self._n_free, self._springs = system.n_free, springs
        lowering = Lowering(system.scene, system.kinds)
        final = lowering.final_indices(system.places)
        self._measures = [joint_coordinate(lowering, s.joint, s.of).placed(final) for s in springs]
        self._forces = [
            _joint_force_terms(system, s if s.law == RUBBING else None) for s in springs
        ]
        self.depends_on_reactions = any(s.law == RUBBING for s in springs)

    def cliques(self) -> list[Indices]:
        """Return the coordinates of each measure, (1, m)."""
        return [matrix_unknowns(each.place.copy(), self._n_free)[None] for each in self._measures]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled springs."""
        slots = [pattern.slots(each).ravel() for each in self.cliques()]
        columns = {
            name: np.array([getattr(each, name) for each in self._springs], dtype=float)
            for name in ("low", "high", "stiffness", "damping", "slip")
        }
        made: Compiled = compiled_module("joint_springs").JointSprings(
            flatten(self._measures)
            | columns
            | _flatten_forces(self._forces)
            | {
                "law": np.array([each.law for each in self._springs], dtype=np.int32),
                "slot": np.concatenate(slots),
                "first_slot": offsets_of(slots),
            }
        )
        return made

    def unilateral_forces(
        self, q: Vector, v: Vector, amplitudes: Vector
    ) -> list[tuple[str, Vector]]:
        """Return the penetration of stops."""
        out = []
        for spring, along in zip(self._springs, self._measures, strict=True):
            if spring.law == STOP:
                x = along.values(q)
                if along.is_angle:  # angles of stops are counted from the middle of their range
                    middle = 0.5 * (spring.low + spring.high)
                    x = middle + np.remainder(x - middle + np.pi, 2.0 * np.pi) - np.pi
                penetration = np.maximum(np.maximum(x - spring.high, spring.low - x), 0.0)
                unit = "rad" if along.is_angle else "m"
                out.append((f"the penetration of {spring.what} [{unit}]", penetration))
        return out

    def dissipation(self, q: Vector, v: Vector, lam: Vector) -> Vector | float:
        """Return the power dissipated by friction that depends on joint forces, (k,) [W]."""
        power = np.zeros(len(q))
        for spring, along, force in zip(self._springs, self._measures, self._forces, strict=True):
            if spring.law == RUBBING:
                rate = np.sum(along.gradients(q) * v[:, along.place], axis=1)
                limit = spring.damping * force.size(q, lam)
                power += limit * rate**2 / np.hypot(rate, spring.slip)
        return power

    def resisted_motions(self, q: Vector) -> Any:
        """Return the gradient of the joint coordinate of each spring."""
        import scipy.sparse as sp

        found = [m for m, s in zip(self._measures, self._springs, strict=True) if s.stiffness]
        if not found:
            return None
        values = np.concatenate([each.gradients(q[None])[0] for each in found])
        rows = np.repeat(np.arange(len(found)), [len(each.place) for each in found])
        places = (rows, np.concatenate([each.place for each in found]))
        return sp.csr_array((values, places), shape=(len(found), len(q)))


def _joint_force_terms(system: Discretization, spring: JointSpring | None) -> JointForceTerms:
    """Return the force on the first side of a joint with friction; others have no terms."""
    rows, factors = [], []
    if spring is not None:
        body = spring.joint.sides[0].beam
        places = system.places[[id(each) for each in system.bodies].index(id(body))]
        columns = places[:, system.kind_of(body).columns("r")]
        direction = {int(p): d for d, column in enumerate(columns.T) for p in column}
        c, mine = system.constraints, set(system.rows_of(spring.joint))
        for row, i, j, factor, about in zip(c.row, c.i, c.j, c.coefficient, c.about, strict=True):
            for one, other in ((i, j), (j, i)):
                if row in mine and one in direction:
                    rows.append((row, other, direction[one]))
                    factors.append((factor, about))
        if not rows:
            raise InputError(
                f"{spring.what} depends on the joint force, which joints without multipliers "
                "do not provide: make a pin by as_constraint=True, or join another point than the "
                "origin of a body"
            )
    integers = np.array(rows, dtype=np.int32).reshape(-1, 3)
    reals = np.array(factors, dtype=float).reshape(-1, 2)
    columns_of = [x.copy() for x in integers.T]
    return JointForceTerms(
        columns_of[0], columns_of[1], columns_of[2], *(x.copy() for x in reals.T)
    )


def _flatten_forces(forces: list[JointForceTerms]) -> dict[str, Any]:
    tables = {
        f"force_{name}": np.concatenate([getattr(each, name) for each in forces])
        for name in JointForceTerms._fields
    }
    return tables | {"force_start": offsets_of(each.row for each in forces)}


def of(system: Discretization) -> list[JointSpringContribution]:
    """Return the springs, stops and friction in the joints of a system."""
    springs = [each for each in system.scene.attachments if isinstance(each, JointSpring)]
    return [JointSpringContribution(system, springs)] if springs else []
