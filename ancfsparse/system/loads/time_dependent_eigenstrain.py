"""Time-dependent eigenstrains: changes of kernel parameters as amplitudes."""

from __future__ import annotations

import numpy as np

from ancfsparse.array_types import Integers, Vector
from ancfsparse.errors import LoadError
from ancfsparse.kernels.element_kind import ElementKind
from ancfsparse.kernels.layout import pad
from ancfsparse.scene.bodies.beam import Beam
from ancfsparse.scene.bodies.strained_reference import strained_ends

TIMES_PER_BLOCK = 64  # times that are evaluated together
TRIAL_STRAINS = (1e-3, -1e-2)
"""Rotations along an element [rad] and elongations [-] that detect which parameters change."""


class TimeDependentEigenstrain:
    """Changes of the parameters of the elements of a beam with its eigenstrain.

    Elements with equal parameters share their columns.

    Parameters
    ----------
    body : Beam
        A beam with ``changing`` eigenstrains.
    kind : ElementKind
        Its element type.
    ends : (n_e, 2, n_c) float
        Coordinates of both nodes of its elements in the reference shape.
    base : (n_e, n_base) float
        Base parameters of its elements without changes.

    Attributes
    ----------
    width : int
        Number of amplitudes.
    """

    def __init__(self, body: Beam, kind: ElementKind, ends: Vector, base: Vector) -> None:
        assert body.eigen is not None
        self._body, self._kind = body, kind
        still = pad(kind, base)
        # The last element, without stiffness, pads its block.
        element = np.minimum(np.arange(len(still)), body.n_elements - 1)
        vectors = np.concatenate(
            [ends[:, :, kind.columns(name)] for name in kind.vectors[1:]], axis=2
        )
        turned = vectors.reshape(body.n_elements, -1)[element]
        keys = [still, body.eigen[element], turned]
        _, first, self._row = np.unique(
            np.hstack(keys), axis=0, return_index=True, return_inverse=True
        )
        self._row = self._row.ravel()
        self._base, self._ends = still[first], ends[element[first]]
        self._eigen, self._lengths = body.eigen[element[first]], body.lengths[element[first]]
        self._reference = np.flatnonzero([name.startswith("reference") for name in kind.parameters])
        self._still = kind.prepare(self._base)
        trials = [self._derived(trial * self._unit()) for trial in TRIAL_STRAINS]
        changed = np.any([each != self._still for each in trials], axis=(0, 1))
        self._changed = np.flatnonzero(changed)
        self.width = len(first) * len(self._changed)

    def places(self, set_of: Integers, lanes: int) -> tuple[Integers, Integers]:
        """Return the indices of changed parameters and of their amplitudes.

        Parameters
        ----------
        set_of : (n_blocks,) int32
            Parameter set of each block, see `Layout`.
        lanes : int
            Elements in a block.

        Returns
        -------
        place : (k,) int32
            Indices in the flat array of parameters (n_sets, n_derived, lanes).
        column : (k,) int32
            Indices of amplitudes, relative to the first.
        """
        _, block = np.unique(np.where(set_of < 0, ~set_of, set_of), return_index=True)
        sets, changed, lane = np.ogrid[: len(block), : len(self._changed), :lanes]
        row = self._row[block[sets] * lanes + lane]
        place = (sets * self._still.shape[1] + self._changed[changed]) * lanes + lane
        column = row * len(self._changed) + changed
        return place.ravel().astype(np.int32), np.broadcast_to(column, place.shape).ravel().astype(
            np.int32
        )

    def tabulate(self, times: Vector) -> tuple[Vector, LoadError | None]:
        """Return the changes of parameters, (j, width), up to a strain of -1."""
        changes = self._body.eigen_changes(times)
        lowest = changes[:, None, 0] + self._eigen[None, :, 0]
        wrong = np.flatnonzero(~(lowest > -1.0).all(axis=1))
        failure = None
        if len(wrong):
            at = int(wrong[0])
            failure = LoadError(
                f"the eigenstrain of {self._body.name} at t = {times[at]:.6g} s is "
                f"{lowest[at].min():g}: it must be above -1, the strain of zero length",
                float(times[at]),
            )
            changes = changes[:at]
        table = np.empty((len(changes), self.width))
        for i in range(0, len(changes), TIMES_PER_BLOCK):
            part = np.repeat(changes[i : i + TIMES_PER_BLOCK], len(self._base), axis=0)
            derived = self._derived(part).reshape(-1, *self._still.shape) - self._still
            table[i : i + TIMES_PER_BLOCK] = derived[:, :, self._changed].reshape(len(derived), -1)
        return table, failure

    def _unit(self) -> Vector:
        """Return an elongation of 1 and a rotation of 1 rad for each distinct element."""
        out = np.ones_like(self._eigen)
        out[:, 1:] /= self._lengths[:, None]
        return out

    def _derived(self, changes: Vector) -> Vector:
        """Return derived parameters for changes of eigenstrain, (k rows, ...)."""
        times = len(changes) // len(self._base)
        base, ends = np.tile(self._base, (times, 1)), np.tile(self._ends, (times, 1, 1))
        eigen = np.tile(self._eigen, (times, 1)) + changes
        free = strained_ends(self._kind, ends, np.tile(self._lengths, times), eigen)
        base[:, self._reference] = free.reshape(len(base), -1)
        return np.asarray(self._kind.prepare(base))
