"""Sliding joints: points that slide along beams."""

from __future__ import annotations

import math
from functools import partial

import numpy as np

from ancfsparse.array_types import Indices
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import LoadError
from ancfsparse.scene.kinematics.sliding_curve import CurveOffset, SlidingCurve
from ancfsparse.system.assembly.sparsity_pattern import Pattern
from ancfsparse.system.contributions.interface import Compiled, Contribution, matrix_unknowns
from ancfsparse.system.coordinates.discretization import Discretization


class SlidingJointContribution(Contribution):
    """A point of a system on its sliding curve."""

    def __init__(self, system: Discretization, rows: list[int], offset: CurveOffset) -> None:
        self._n_free, self._rows, self._offset = system.n_free, rows, offset
        self._label = system.constraints.labels[rows[0]].split(", normal")[0]
        self._start = offset.curve.nearest(system.q0)

    def cliques(self) -> list[Indices]:
        """Return multipliers and coordinates of the point with each element, a row each."""
        coordinates = matrix_unknowns(self._offset.reach(), self._n_free)
        rows = np.full((len(coordinates), len(self._rows)), self._n_free + np.array(self._rows))
        return [np.concatenate([rows, coordinates], axis=1).astype(np.int32)]

    def compile(self, pattern: Pattern) -> Compiled:
        """Return the compiled joint."""
        track = self._offset.curve
        arrays = {
            "ends": np.ascontiguousarray(track.ends, dtype=np.int32),
            "arcs": track.arcs,
            "point": np.ascontiguousarray(track.point.T, dtype=np.int32),
            "weights": np.ascontiguousarray(track.weights, dtype=float),
            "lateral": np.ascontiguousarray(track.lateral, dtype=float),
            "row": np.array(self._rows, dtype=np.int32),
            "slot": pattern.slots(self.cliques()[0]),
            "s": self._start,
        }
        made: Compiled = compiled_module("tracks").Tracks(
            arrays, partial(describe_run_off, self._label, track)
        )
        return made


def describe_run_off(label: str, track: SlidingCurve, s: float) -> LoadError:
    """Return the error for a point that has left its beam at an arc coordinate [m]."""
    length = float(track.arcs[-1])
    where = "start" if s < 0.0 else "end"
    reason = f"the {label} ran off its {where}, to s = {s:.6g} m of {length:.6g} m"
    advice = "end the run before, or stop the point by a spring"
    return LoadError(f"{reason}: {advice}", math.nan)


def of(system: Discretization) -> list[SlidingJointContribution]:
    """Return the sliding joints of a system."""
    rows: dict[int, list[int]] = {}
    offsets: dict[int, CurveOffset] = {}
    for row, _, each in system.constraints.measures:
        if isinstance(each, CurveOffset):
            owner = system.constraints.source[row][0]
            rows.setdefault(owner, []).append(row)
            offsets.setdefault(owner, each)
    return [
        SlidingJointContribution(system, rows[owner], offset) for owner, offset in offsets.items()
    ]
