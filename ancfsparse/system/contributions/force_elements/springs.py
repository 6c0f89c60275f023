"""Springs and dampers between two points."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from ancfsparse.array_types import Indices, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.scene import Point
from ancfsparse.scene.force_elements.springs import LAW_SIGNATURES, Spring
from ancfsparse.scene.records.compiled_callbacks import get_capsule
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution
from ancfsparse.system.contributions.point_weights import PointSums
from ancfsparse.system.coordinates.discretization import Discretization


class CompiledSprings(Compiled, Protocol):
    """Springs as a contribution (_springs.pyx)."""

    def pull(self, k: int, elongation: float, /) -> float:
        """Return the force of a spring at an elongation [N]."""


class SpringContribution(Contribution):
    """The springs of a system; the vector between their ends is a sum of coordinates."""

    is_load = True

    def __init__(self, system: Discretization, springs: list[Spring]) -> None:
        self._n_free, self._springs = system.n_free, springs
        self._points = PointSums.of(system, [_terms(each) for each in springs])
        fixed = [np.zeros(system.dim) if isinstance(s.b, Point) else s.b for s in springs]
        self._origin = np.array(fixed, dtype=float)
        self._compiled: CompiledSprings

    def cliques(self) -> list[Indices]:
        """Return the coordinates of each spring."""
        return self._points.cliques(self._n_free)

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled springs."""
        springs, points = self._springs, self._points
        linear = [0.0 if _is_law(each) else each.stiffness for each in springs]
        self._compiled = compiled_module("springs").Springs(
            points.start,
            points.place,
            points.weight,
            points.slots(pattern, self._n_free),
            self._origin,
            np.array(linear, dtype=float),
            np.array([each.damping for each in springs]),
            np.array([each.length for each in springs]),
            np.array([each.length or each.a.beam.shortest for each in springs]),
            [_law(each) if _is_law(each) else None for each in springs],
        )
        return self._compiled

    def unilateral_forces(
        self, q: Vector, v: Vector, amplitudes: Vector
    ) -> list[tuple[str, Vector]]:
        """Return the forces of springs with force laws."""
        points, out = self._points, []
        for k, spring in enumerate(self._springs):
            if _is_law(spring):
                mine = slice(points.start[k], points.start[k + 1])
                vectors = self._origin[k] + q[:, points.place[:, mine]] @ points.weight[mine]
                elongations = np.linalg.norm(vectors, axis=1) - spring.length
                pulls = [self._compiled.pull(k, each) for each in elongations]
                out.append((f"the force of {spring.what} [N]", np.array(pulls)))
        return out

    def resisted_motions(self, q: Vector) -> Any:
        """Return the directions of the springs; tensioned ones resist in all directions."""
        import scipy.sparse as sp

        points, n, dim = self._points, len(self._springs), self._origin.shape[1]
        values, rows, columns = [], [], []
        for k, spring in enumerate(self._springs):
            if spring.stiffness == 0.0:
                continue
            mine = slice(points.start[k], points.start[k + 1])
            place, weight = points.place[:, mine], points.weight[mine]
            vector = self._origin[k] + q[place] @ weight
            length = float(np.linalg.norm(vector))
            in_tension = length == 0.0 or spring.pull(length - spring.length) > 0.0
            directions = np.eye(dim) if in_tension else vector[None] / length
            for e, direction in enumerate(directions):
                values.append(np.outer(direction, weight).ravel())
                columns.append(place.ravel())
                rows.append(np.full(place.size, dim * k + e))
        if not rows:
            return None
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        table = sp.csr_array(entries, shape=(dim * n, len(q)))
        return table[np.diff(table.indptr) > 0]


def _terms(spring: Spring) -> list[tuple[float, Point]]:
    ends = [(-1.0, spring.a)]
    return [*ends, (1.0, spring.b)] if isinstance(spring.b, Point) else ends


def _is_law(spring: Spring) -> bool:
    return not isinstance(spring.stiffness, float)


def _law(spring: Spring) -> tuple[Any, Any, Callable[..., Exception]]:
    """Return a C function with its signature, or a Python function, and its error."""
    capsule = get_capsule(spring.stiffness)
    if capsule is None:
        return spring.stiffness, None, spring.failure
    return capsule, LAW_SIGNATURES.index(spring.signature), spring.failure


def of(system: Discretization) -> list[SpringContribution]:
    """Return the springs of a system."""
    found = [each for each in system.scene.attachments if isinstance(each, Spring)]
    return [SpringContribution(system, found)] if found else []
