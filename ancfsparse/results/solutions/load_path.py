"""A path of equilibria, addressed by the handles of a scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.results import plotting
from ancfsparse.results.data.index_checks import check_index
from ancfsparse.results.data.interpolation import Array
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.solutions.solution import Configurations
from ancfsparse.scene import Point
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class LoadPath(Configurations):
    """Equilibria under multiples of the loads, in the order in which they follow each other.

    Parameters
    ----------
    system : System
        The system at rest.
    factors : ndarray, shape (k,)
        Multiples of all loads [-], from 0.
    q : ndarray, shape (k, n)
        Coordinates, m for positions and dimensionless for slopes.
    lam : ndarray, shape (k, m)
        Multipliers of the constraints.
    negative_pivots : ndarray of int, shape (k,)
        Independent directions in which each equilibrium is unstable.
    turns : ndarray of int
        Numbers of the points where the load turns, the limit points.
    forks : ndarray of int
        Number of the point where another branch was followed, if one was.
    complete : bool
        Whether the path got to the multiple that was asked for, and not to ten times the opposite.
    stats : RunStats
        What it cost.
    t : float
        The time of loads and drives [s].
    """

    system: System
    factors: Array
    q: Array
    lam: Array
    negative_pivots: NDArray[np.intp]
    turns: NDArray[np.intp]
    forks: NDArray[np.intp]
    complete: bool
    stats: RunStats
    t: float = 0.0

    def __repr__(self) -> str:
        """Sum the path up in one line."""
        limits = ", ".join(f"{each:.6g}" for each in self.limits)
        return (
            f"LoadPath: {len(self)} points to {self.factors[-1]:.6g} times the loads"
            + f", turns at {limits}" * bool(limits)
            + "".join(f", leaves its branch at {each:.6g}" for each in self.factors[self.forks])
            + ", not complete" * (not self.complete)
        )

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.factors)

    @property
    def limits(self) -> Array:
        """Multiples of the loads where the load turns [-]."""
        return np.asarray(self.factors[self.turns])

    @property
    def stable(self) -> NDArray[np.bool_]:
        """Whether every small motion away from each equilibrium takes energy, (k,)."""
        return np.asarray(self.negative_pivots == 0)

    def state(self, point: int) -> State:
        """Return the state of rest at a point, from which ``simulate(..., start=...)`` starts.

        Parameters
        ----------
        point : int
            Its number, from 0; from the last one if negative.
        """
        k = check_index("point", point, len(self))
        rest = np.zeros(self.q.shape[1])
        return self.system.state(self.t, self.q[k], rest, rest, self.lam[k])

    def plot(self, node: Point, axis: int = -1, *, ax: Axes | None = None) -> Axes:
        """Draw the multiples of the loads over the displacement of a point.

        Parameters
        ----------
        node : Point
            Any point of a beam or of a rigid body.
        axis : int, optional
            Component of the displacement; by default the last one.
        ax : Axes, optional
            Where to draw.

        Returns
        -------
        Axes
            The axes drawn into; unstable parts of the path are dashed.
        """
        x = self.displacement(node)
        return plotting.plot_load_path(x, self.factors, self.stable, self.turns, axis, ax)
