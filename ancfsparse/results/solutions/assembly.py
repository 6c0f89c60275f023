"""Where an assembly has put a scene, read by the names of the scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.results.data.interpolation import Array
from ancfsparse.results.solutions.solution import Configurations
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System


@dataclass(frozen=True, eq=False, repr=False)
class Assembly(Configurations):
    """A state in which all joints hold and all drives are where they should be.

    Parameters
    ----------
    system : System
        The system that was assembled.
    q : ndarray, shape (n,)
        Coordinates, m for positions and dimensionless for slopes.
    t : float
        The time of the drives [s].
    violation : float
        Largest violation of a joint or a drive in the reference shape [m].
    worst : str
        The joint of which it was, empty if it was a drive or none.
    multipliers : ndarray, shape (m,)
        Multipliers of the constraints at rest without loads, zero.
    """

    system: System
    q: Array
    t: float
    violation: float
    worst: str
    multipliers: Array

    def __repr__(self) -> str:
        """State in one line what was moved and why."""
        if self.violation == 0.0:
            return "Assembly: everything was in place"
        body, node, moved = self._farthest
        why = f", most by the {self.worst}" * bool(self.worst)
        return (
            f"Assembly: moved by up to {moved:.6g} m, at {body}, node {node}; out of place by up "
            f"to {self.violation:.6g} m before{why}"
        )

    @property
    def moved(self) -> float:
        """How far the node that moved farthest has moved [m]."""
        return self._farthest[2]

    @property
    def _farthest(self) -> tuple[str, int, float]:
        best = "", 0, -1.0
        change, layout = self.q - self.system.q_ref, self.state.layout
        for body, places in zip(self.system.scene.bodies, layout.places, strict=True):
            steps = np.linalg.norm(change[places[:, body.kind.columns("r")]], axis=1)
            row = int(np.argmax(steps))
            if steps[row] > best[2]:
                best = body.name, int(body.row_nodes[row]), float(steps[row])
        return best

    @property
    def state(self) -> State:
        """The state, at rest, from which a motion or statics may start."""
        rest, lam = np.zeros_like(self.q), self.multipliers
        return self.system.state(self.t, self.q, rest, rest, lam)
