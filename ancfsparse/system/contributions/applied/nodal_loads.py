"""Time-dependent loads of `system.loads.applied_loads`; constant ones are one system vector."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution
from ancfsparse.system.coordinates.discretization import Discretization

if TYPE_CHECKING:
    from ancfsparse.system.loads.applied_loads import AppliedLoads


class NodalLoadContribution(Contribution):
    """The forces of a scene that are functions of time."""

    is_load = True

    def __init__(self, loads: AppliedLoads) -> None:
        self._place = np.array(loads.place, dtype=np.int32)
        self._column = np.array(loads.column, dtype=np.int32)
        self._weight = np.array(loads.weight, dtype=float)

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
    return [NodalLoadContribution(system.loads)]
