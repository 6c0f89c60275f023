"""Time-dependent loads of `system.loads.applied_loads`; constant ones are one system vector."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution
from ancfsparse.system.coordinates.discretization import Discretization


class NodalLoadContribution(Contribution):
    """Forces on coordinates that are functions of time, weights times amplitudes."""

    is_load = True

    def __init__(self, indices: ArrayLike, columns: ArrayLike, weights: ArrayLike) -> None:
        self._place = np.array(indices, dtype=np.int32)
        self._column = np.array(columns, dtype=np.int32)
        self._weight = np.array(weights, dtype=float)

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled loads."""
        made: Compiled = compiled_module("loads").Loads(self._place, self._column, self._weight)
        return made

    def power(self, q: Vector, v: Vector, amplitudes: Vector) -> Vector:
        """Return the power of the loads, shape (k,) [W]."""
        forces = self._weight * amplitudes[:, self._column]
        return np.asarray(np.sum(v[:, self._place] * forces, axis=1))


def of(system: Discretization) -> list[NodalLoadContribution]:
    """Return the time-dependent loads of a system."""
    loads = system.loads
    return [NodalLoadContribution(loads.place, loads.column, loads.weight)]
