"""Follower forces, fixed to the sections they act on."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Indices, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution, matrix_unknowns
from ancfsparse.system.coordinates.discretization import Discretization
from ancfsparse.system.loads.follower_loads import Follower


class FollowerContribution(Contribution):
    """The follower forces of a scene."""

    is_load = True
    conservative = False

    def __init__(self, system: Discretization) -> None:
        self._n_free, self._n_all = system.n_free, system.n_all
        self._all = Follower.join(system.loads.followers)

    def cliques(self) -> list[Indices]:
        """Return the coordinates of each force."""
        return [matrix_unknowns(self._places(), self._n_free)]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled forces."""
        arrays = {
            "place": self._all.place,
            "weight": self._all.weight,
            "column": self._all.column,
            "factor": self._all.factor,
            "slot": pattern.slots(*self.cliques()).ravel(),
        }
        made: Compiled = compiled_module("followers").Followers(self._n_all, arrays)
        return made

    def power(self, q: Vector, v: Vector, amplitudes: Vector) -> Vector:
        """Return the power of the forces, shape (k,) [W]."""
        each = self._all
        power = np.zeros(len(q))
        for place, weight, column, factor in zip(
            each.place, each.weight, each.column, each.factor, strict=True
        ):
            rate = np.einsum("u,kud->kd", weight[0], v[:, place])
            units = np.einsum("su,kud->skd", weight[1:], q[:, place])
            if place.shape[1] == 2:
                units = np.stack([units[0], np.stack([-units[0, :, 1], units[0, :, 0]], axis=1)])
            for vector, number in zip(units, column, strict=True):
                if number >= 0:
                    unit = vector / np.linalg.norm(vector, axis=1, keepdims=True)
                    power += factor * amplitudes[:, number] * np.sum(unit * rate, axis=1)
        return power

    def _places(self) -> NDArray[np.int32]:
        return self._all.place.reshape(len(self._all.place), -1).copy()


def of(system: Discretization) -> list[FollowerContribution]:
    """Return the follower forces of a system."""
    return [FollowerContribution(system)]
