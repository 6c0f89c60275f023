"""Elastic ropes over points."""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.scene import Point
from ancfsparse.scene.force_elements.ropes import Rope
from ancfsparse.scene.mechanisms.coordinate_functions import distance
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
from ancfsparse.system.loads.amplitudes import FunctionAmplitude


class RopeContribution(Contribution):
    """The elastic ropes of a system."""

    is_load = True

    def __init__(self, system: Discretization, ropes: list[Rope]) -> None:
        self._n_free, self._ropes = system.n_free, ropes
        lowering = Lowering(system.scene, system.kinds)
        final = lowering.final_indices(system.places)
        self._fixed = np.zeros(len(ropes))
        self._parts = []
        for k, rope in enumerate(ropes):
            parts = []
            for one, other in pairwise(rope.points):
                if isinstance(one, Point) or isinstance(other, Point):
                    parts.append(distance(lowering, one, other).placed(final))
                else:
                    self._fixed[k] += float(np.linalg.norm(one - other))
            self._parts.append(parts)
        self._places = [np.unique(np.concatenate([m.place for m in p])) for p in self._parts]
        self._column = np.full(len(ropes), -1, dtype=np.int32)
        for k, rope in enumerate(ropes):
            if rope.change is not None:
                self._column[k] = system.loads.n_amplitudes
                system.loads.sources.append(FunctionAmplitude(rope.change))

    def cliques(self) -> list[Indices]:
        """Return the coordinates of each rope, (1, m), then those of each part of each."""
        parts = [part.place for parts in self._parts for part in parts]
        return [
            matrix_unknowns(each.copy(), self._n_free)[None] for each in (*self._places, *parts)
        ]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled ropes."""
        slots = [pattern.slots(each).ravel() for each in self.cliques()]
        n, parts = len(self._ropes), [part for parts in self._parts for part in parts]
        own = [
            np.searchsorted(places, part.place)
            for places, mine in zip(self._places, self._parts, strict=True)
            for part in mine
        ]
        columns = {
            "natural": "length",
            "stiffness": "stiffness",
            "viscosity": "damping",
            "width": "slack",
        }
        made: Compiled = compiled_module("ropes").Ropes(
            flatten(parts)
            | {
                name: np.array([getattr(each, field) for each in self._ropes], dtype=float)
                for name, field in columns.items()
            }
            | {
                "fixed": self._fixed,
                "column": self._column,
                "first": offsets_of(self._parts),
                "begin": offsets_of(self._places),
                "places": np.concatenate(self._places),
                "own": np.concatenate(own).astype(np.int32),
                "slot": np.concatenate(slots[:n]),
                "first_slot": offsets_of(slots[:n]),
                "slot_of_part": np.concatenate(slots[n:]),
                "first_of_part": offsets_of(slots[n:]),
            }
        )
        return made

    def tension(self, rope: Any, q: Vector, v: Vector, amplitudes: Vector) -> Vector | None:
        """Return the tension of one of its ropes in states (k, n_all), shape (k,) [N]."""
        if rope not in self._ropes:
            return None
        return self._tension(self._ropes.index(rope), q, v, amplitudes)

    def _tension(self, k: int, q: Vector, v: Vector, amplitudes: Vector) -> Vector:
        path, rate = np.full(len(q), self._fixed[k]), np.zeros(len(q))
        for part in self._parts[k]:
            path += part.values(q)
            rate += part.rates(q, v)
        change = amplitudes[:, self._column[k]] if self._column[k] >= 0 else 0.0
        rope = self._ropes[k]
        return rope.tension(path, rate, rope.length + change)

    def unilateral_forces(
        self, q: Vector, v: Vector, amplitudes: Vector
    ) -> list[tuple[str, Vector]]:
        """Return the tensions of the ropes."""
        return [
            (f"the tension of {each.what} [N]", self._tension(k, q, v, amplitudes))
            for k, each in enumerate(self._ropes)
        ]

    def resisted_motions(self, q: Vector) -> Any:
        """Return the gradient of each path; of a taut rope also the normals of each part."""
        import scipy.sparse as sp

        lines: list[tuple[Integers, Vector]] = []
        for k, (rope, parts) in enumerate(zip(self._ropes, self._parts, strict=True)):
            path = self._fixed[k] + sum(float(part.values(q[None])[0]) for part in parts)
            if path > rope.length:
                lines += [(part.place, part.weight[:, d]) for part in parts for d in range(3)]
            slopes = np.concatenate([part.gradients(q[None])[0] for part in parts])
            lines.append((np.concatenate([part.place for part in parts]), slopes))
        rows = np.repeat(np.arange(len(lines)), [len(place) for place, _ in lines])
        columns, values = (np.concatenate(each) for each in zip(*lines, strict=True))
        table = sp.coo_array((values, (rows, columns)), shape=(len(lines), len(q))).tocsr()
        table.eliminate_zeros()
        return table[np.diff(table.indptr) > 0]


def of(system: Discretization) -> list[RopeContribution]:
    """Return the elastic ropes of a system."""
    found = [each for each in system.scene.attachments if isinstance(each, Rope)]
    return [RopeContribution(system, found)] if found else []
