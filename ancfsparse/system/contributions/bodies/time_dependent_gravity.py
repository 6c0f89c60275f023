"""Time-dependent gravity: a force on each coordinate in proportion to its mass."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.dispatch import compiled_module
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.applied.nodal_loads import NodalLoadContribution
from ancfsparse.system.contributions.interface import Compiled
from ancfsparse.system.coordinates.discretization import Discretization

if TYPE_CHECKING:
    from ancfsparse.system.assembly.assembly_protocol import CompiledAssembly


class GravityContribution(NodalLoadContribution):
    """Uniform accelerations of all masses of the previous contributions."""

    def __init__(self, system: Discretization) -> None:
        super().__init__([], [], [])
        self._system = system

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled loads."""
        system = self._system
        masses: CompiledAssembly = compiled_module("assembly").Assembly(
            system.n_free,
            system.n_all,
            system.loads.n_amplitudes,
            pattern.indptr,
            system.parts,
        )
        places, columns, weights = [], [], []
        for direction in range(system.dim):
            force = masses.inertia(system.uniform(direction))
            acting = np.flatnonzero(force)
            for column in system.loads.gravity_column:
                places.append(acting)
                columns.append(np.full(len(acting), column[direction]))
                weights.append(force[acting])
        self._place = np.concatenate(places).astype(np.int32)
        self._column = np.concatenate(columns).astype(np.int32)
        self._weight = np.concatenate(weights)
        return super().compile(pattern)


def of(system: Discretization) -> list[GravityContribution]:
    """Return the time-dependent gravity of a system."""
    return [GravityContribution(system)]
