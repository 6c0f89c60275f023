"""An assembled configuration of a scene."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results.solutions.solution import Configurations
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System


@dataclass(frozen=True, eq=False, repr=False)
class Assembly(Configurations):
    """A configuration that satisfies all joints and prescribed motions, with bodies moved apart.

    Parameters
    ----------
    system : System
        The discrete system.
    q : ndarray, shape (n,)
        Coordinates, m for positions and dimensionless for slopes.
    t : float
        Time of the prescribed motions [s].
    violation : float
        Largest violation of a joint or a prescribed motion, or penetration with ``push_out=True``,
        in the reference shape [m].
    worst : str
        The joint or the contact with it; empty for a prescribed motion or no violation.
    multipliers : ndarray, shape (m,)
        Lagrange multipliers at rest without loads, zero.
    """

    system: System
    q: Vector
    t: float
    violation: float
    worst: str
    multipliers: Vector

    def __repr__(self) -> str:
        """Summarise the displacements and their cause in one line."""
        return f"Assembly: {self.description}"

    @property
    def description(self) -> str:
        """The displacements and their cause."""
        if self.violation == 0.0:
            return "everything was in place"
        body, node, moved = self._farthest
        why = f", most by the {self.worst}" * bool(self.worst)
        return (
            f"moved by up to {moved:.6g} m, at {body}, node {node}; out of place by up "
            f"to {self.violation:.6g} m before{why}"
        )

    @property
    def moved(self) -> float:
        """Largest displacement of a node [m]."""
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
        """The state at rest, an initial state for a motion or an equilibrium."""
        rest, lam = np.zeros_like(self.q), self.multipliers
        return self.system.state(self.t, self.q, rest, rest, lam)
