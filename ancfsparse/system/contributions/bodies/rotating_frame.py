"""Centrifugal and Coriolis forces of a frame with constant angular velocity.

All coordinates are components of vectors, and the mass matrix is the same along every axis of
space, M = A x 1.  With the vectors in the frame, ``q' + W q`` are their velocities in space, so
``M (q'' + 2 W q' + W^2 (q - c))`` are the inertia forces.  W and M commute: the centrifugal
forces have the potential ``(q - c).M W^2 (q - c) / 2``, and the Coriolis forces do no work.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.array_types import Indices, Integers, Vector
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.scene.force_elements.masses import RotatingFrame
from ancfsparse.system.assembly.column_colouring import colour_columns
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution, matrix_unknowns
from ancfsparse.system.coordinates.discretization import Discretization
from ancfsparse.system.loads.amplitudes import ConstantAmplitude

if TYPE_CHECKING:
    from ancfsparse.system.assembly.assembly_protocol import CompiledAssembly

ISOTROPY_TOLERANCE = 1e-9  # difference of the mass matrix between axes, relative to its forces


class RotatingFrameContribution(Contribution):
    """The inertia forces of a rotating frame."""

    is_load = True

    def __init__(self, system: Discretization, frame: RotatingFrame, amplitude: int) -> None:
        self._system, self._frame, self._amplitude = system, frame, amplitude
        self._place, self._centre = _collect_vectors(system, frame)
        self._row, self._column = self._coupled_vectors()
        self._mass = np.zeros(0)

    def _coupled_vectors(self) -> tuple[Integers, Integers]:
        """Return pairs of vectors that may have common masses, by rows, in both orders."""
        import scipy.sparse as sp

        number = np.full(self._system.n_all, -1)
        number[self._place[:, 0]] = np.arange(len(self._place))
        pairs = []
        for body, places in zip(self._system.bodies, self._system.places, strict=True):
            table = number[places if body.masses is not None else self._system.elements(body)]
            table = table.reshape(-1, len(table[0]))
            table = table[:, table[0] >= 0]
            k = table.shape[1]
            pairs.append(np.stack([table.repeat(k, axis=1), np.tile(table, k)]).reshape(2, -1))
        row, column = np.concatenate(pairs, axis=1)
        n = len(self._place)
        coupling = sp.coo_array((np.ones(len(row)), (row, column)), shape=(n, n)).tocsr().tocoo()
        return coupling.coords[0], coupling.coords[1]

    def _entries(self) -> tuple[Integers, Vector]:
        """Return pairs of coordinates (j, 2) coupled by centrifugal forces, and matrix entries."""
        square, dim = self._frame.spin @ self._frame.spin, self._system.dim
        mass = self._mass if len(self._mass) else np.ones(len(self._row))
        pairs, values = [], []
        for i in range(dim):
            for j in range(dim):
                if square[i, j] != 0.0:
                    places = self._place[self._row, i], self._place[self._column, j]
                    pairs.append(np.stack(places, axis=1))
                    values.append(square[i, j] * mass)
        table = np.concatenate([np.zeros((0, 2), dtype=np.int32), *pairs])
        lower = table[:, 0] >= table[:, 1]
        return table[lower].astype(np.int32), np.concatenate([np.zeros(0), *values])[lower]

    def cliques(self) -> list[Indices]:
        """Return the two coordinates of each entry."""
        return [matrix_unknowns(self._entries()[0], self._system.n_free)]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled forces."""
        system = self._system
        self._find_masses(pattern)
        pairs, values = self._entries()
        slots = pattern.slots(
            matrix_unknowns(pairs.copy(), system.n_free)
        )  # (i, i), (j, i), (j, j)
        slot = np.where(pairs[:, 0] == pairs[:, 1], slots[:, 0], slots[:, 1])
        start = np.zeros(len(self._place) + 1, dtype=np.int32)
        np.cumsum(np.bincount(self._row, minlength=len(self._place)), out=start[1:])
        made: Compiled = compiled_module("rotating").Rotating(
            self._place,
            self._centre,
            start,
            self._column.astype(np.int32),
            self._mass,
            np.array(self._frame.spin),
            np.ascontiguousarray(slot, dtype=np.int32),
            values,
            self._amplitude,
        )
        return made

    def _find_masses(self, pattern: Pattern) -> None:
        """Compute the mass matrix over the vectors from the inertia forces of all contributions."""
        import scipy.sparse as sp

        system, n = self._system, len(self._place)
        masses: CompiledAssembly = compiled_module("assembly").Assembly(
            system.n_free, system.n_all, system.loads.n_amplitudes, pattern.indptr, system.parts
        )
        coupling = sp.csc_array((np.ones(len(self._row)), (self._row, self._column)), shape=(n, n))
        group = colour_columns(coupling)
        self._mass = np.zeros(len(self._row))
        for each in range(int(group.max()) + 1):
            unit = np.zeros(system.n_all)
            unit[self._place[group == each, 0]] = 1.0
            force = np.asarray(masses.inertia(unit))
            members = group[self._column] == each
            self._mass[members] = force[self._place[self._row[members], 0]]
        trial = np.random.default_rng(0).standard_normal(system.n_all)
        force = np.asarray(masses.inertia(trial))[self._place]
        error = np.abs(force - self._matrix @ trial[self._place]).max(axis=1)
        if np.any(error > ISOTROPY_TOLERANCE * (abs(self._matrix) @ np.ones(n))):
            raise InputError(
                "the masses of the scene are not the same along every axis of space, as a rotating "
                "frame needs: describe the scene in space"
            )

    @property
    def _matrix(self) -> Any:
        import scipy.sparse as sp

        n = len(self._place)
        return sp.csr_array((self._mass, (self._row, self._column)), shape=(n, n))

    @cached_property
    def gyroscopic(self) -> Any:
        """The matrix of the Coriolis forces over the free coordinates, sparse [kg/s]."""
        import scipy.sparse as sp

        n, spin = self._system.n_free, self._frame.spin
        if not spin.any():
            return None
        parts = []
        for i, j in np.argwhere(spin):
            row, column = self._place[self._row, i], self._place[self._column, j]
            free = (row < n) & (column < n)
            values = 2.0 * spin[i, j] * self._mass[free]
            parts.append(sp.coo_array((values, (row[free], column[free])), shape=(n, n)).tocsr())
        return sum(parts[1:], parts[0])

    def potential(self, q: Vector) -> Vector:
        """Return the potential of the centrifugal forces, (k,) [J]."""
        arms = q[:, self._place] - self._centre
        rotated = arms @ (self._frame.spin @ self._frame.spin)
        matrix = self._matrix
        return np.array(
            [0.5 * np.sum(one * (matrix @ two)) for one, two in zip(arms, rotated, strict=True)]
        )


def _collect_vectors(system: Discretization, frame: RotatingFrame) -> tuple[Integers, Vector]:
    """Return the indices (n, dim) of all vectors without repetition, and their origins [m]."""
    places, positions = [], []
    for body, kind, table in zip(system.bodies, system.kinds, system.places, strict=True):
        columns = [np.arange(table.shape[1])[kind.columns(name)] for name in kind.vectors]
        if np.size(columns) != table.shape[1]:
            raise InputError(
                f"{body.name} has coordinates that are not components of vectors in space, so it "
                "cannot be described in a rotating frame"
            )
        for name, column in zip(kind.vectors, columns, strict=True):
            places.append(table[:, column])
            positions.append(np.full(len(table), name == "r"))
    every, first = np.unique(np.concatenate(places), axis=0, return_index=True)
    if len(np.unique(every)) < every.size:
        raise InputError(
            "a joint of the scene shares single components of vectors between bodies, which a "
            "rotating frame mixes: give the joint as_constraint=True"
        )
    centre = np.where(np.concatenate(positions)[first][:, None], frame.point, 0.0)
    return np.ascontiguousarray(every, dtype=np.int32), np.ascontiguousarray(centre)


def of(system: Discretization) -> list[RotatingFrameContribution]:
    """Return the inertia forces of the rotating frame of a system."""
    amplitude = system.loads.n_amplitudes
    system.loads.sources.append(ConstantAmplitude())
    frame = next(each for each in system.scene.attachments if isinstance(each, RotatingFrame))
    return [RotatingFrameContribution(system, frame, amplitude)]
