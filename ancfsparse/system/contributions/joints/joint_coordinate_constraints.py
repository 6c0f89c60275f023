"""Joint coordinates (angles, lengths, displacements) in constraint equations."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import compiled_module
from ancfsparse.scene.kinematics.joint_coordinates import ANGLE, JointCoordinate
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import (
    Compiled,
    Contribution,
    matrix_unknowns,
    offsets_of,
)
from ancfsparse.system.coordinates.discretization import Discretization

FULL_TURN = 2.0 * np.pi


class JointCoordinateContribution(Contribution):
    """The joint coordinates in the equations of a system."""

    def __init__(self, system: Discretization) -> None:
        self._system = system
        terms = system.constraints.measures
        self._n_free = system.n_free
        self._terms = [(k, c, each) for k, c, each in terms if isinstance(each, JointCoordinate)]

    def cliques(self) -> list[Indices]:
        """Return the multiplier and the coordinates of each joint coordinate, (1, 1 + m)."""
        tables = []
        for row, _, measure in self._terms:
            coordinates = matrix_unknowns(measure.place.copy(), self._n_free)
            tables.append(np.concatenate([[self._n_free + row], coordinates])[None])
        return tables

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled joint coordinates."""
        # Pairs by rows: (row, row), (i, row), (i, i), (j, row), (j, i), (j, j), ...
        pairs = [pattern.slots(each).ravel() for each in self.cliques()]
        lines = [np.split(each, _row_starts(each)[1:]) for each in pairs]
        rows, factors, measures = zip(*self._terms, strict=True)
        slots = [np.concatenate([line[1:] for line in each[1:]]) for each in lines]
        arrays = flatten(measures) | {
            "row": np.array(rows, dtype=np.int32),
            "factor": np.array(factors, dtype=float),
            "slot": np.concatenate(slots).astype(np.int32),
            "first_slot": offsets_of(slots),
            "slot_of_row": np.array(
                [line[0] for each in lines for line in each[1:]], dtype=np.int32
            ),
            "turn": self._turns(),
        }
        made: Compiled = compiled_module("couplings").Couplings(arrays)
        return made

    def _turns(self) -> Any:
        """Return the initial values; prescribed angles include the full turns of their motion."""
        system = self._system
        start = [float(each.values(system.q0[None])[0]) for _, _, each in self._terms]
        first = system.n_multipliers - system.prescribed.n_equations
        values, failure = system.prescribed.tabulate(np.array([system.t0]))
        if failure is None:
            for k, (row, factor, measure) in enumerate(self._terms):
                if row >= first and measure.kind == ANGLE:
                    goal = values[0, 3 * system.prescribed.n + row - first] / factor
                    start[k] += FULL_TURN * round((goal - start[k]) / FULL_TURN)
        return np.array(start)


def flatten(measures: Sequence[JointCoordinate]) -> dict[str, Any]:
    """Return joint coordinates as the arrays of coordinate_functions.pxi."""
    return {
        "kind": np.array([each.kind for each in measures], dtype=np.int32),
        "start": offsets_of(each.place for each in measures),
        "place": np.concatenate([each.place for each in measures]),
        "weight": np.concatenate([each.weight for each in measures]),
        "constant": np.array([each.constant for each in measures]),
    }


def _row_starts(pairs: Any) -> Any:
    """Return the starts of the rows of a lower triangle that is stored by rows."""
    n = int(np.sqrt(2 * len(pairs)))
    return np.cumsum(np.arange(n))


def of(system: Discretization) -> list[JointCoordinateContribution]:
    """Return the joint coordinates in the equations of a system."""
    return [JointCoordinateContribution(system)]
