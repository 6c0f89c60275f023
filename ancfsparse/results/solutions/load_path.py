"""A path of equilibria under proportional loads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.array_types import Vector
from ancfsparse.results import plotting
from ancfsparse.results.data.index_checks import check_index
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.solutions.solution import Configurations
from ancfsparse.scene import Point
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class LoadPath(Configurations):
    """Equilibria under multiples of the loads, in the order of the path.

    Parameters
    ----------
    system : System
        The discrete system.
    factors : ndarray, shape (k,)
        Load factors of all loads [-], from 0.
    q : ndarray, shape (k, n)
        Coordinates, m for positions and dimensionless for slopes.
    lam : ndarray, shape (k, m)
        Lagrange multipliers of the constraints.
    negative_pivots : ndarray of int, shape (k,)
        Number of independent unstable directions of each equilibrium.
    turns : ndarray of int
        Indices of the limit points, where the load factor has an extremum.
    forks : ndarray of int
        Index of the bifurcation point where the path leaves its branch, if any.
    complete : bool
        True if the path reached the requested load factor.
    stats : RunStats
        Operation counts and times.
    t : float
        Time of loads and prescribed motions [s].
    """

    system: System
    factors: Vector
    q: Vector
    lam: Vector
    negative_pivots: NDArray[np.intp]
    turns: NDArray[np.intp]
    forks: NDArray[np.intp]
    complete: bool
    stats: RunStats
    t: float = 0.0

    def __repr__(self) -> str:
        """Summarise the path in one line."""
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
    def limits(self) -> Vector:
        """Load factors of the limit points [-]."""
        return np.asarray(self.factors[self.turns])

    @property
    def stable(self) -> NDArray[np.bool_]:
        """True for each stable equilibrium, (k,): every small displacement requires energy."""
        return np.asarray(self.negative_pivots == 0)

    def state(self, point: int) -> State:
        """Return the state at rest of a point of the path, for ``simulate(..., start=...)``.

        Parameters
        ----------
        point : int
            Its index, from 0; from the last one if negative.
        """
        k = check_index("point", point, len(self))
        rest = np.zeros(self.q.shape[1])
        return self.system.state(self.t, self.q[k], rest, rest, self.lam[k])

    def plot(self, node: Point, axis: int = -1, *, ax: Axes | None = None) -> Axes:
        """Plot load factors over the displacement of a point.

        Parameters
        ----------
        node : Point
            Any point of a beam or of a rigid body.
        axis : int, optional
            Component of the displacement; by default the last one.
        ax : Axes, optional
            Axes to plot into; by default those of a new figure.

        Returns
        -------
        Axes
            The axes; unstable parts of the path are dashed.
        """
        x = self.displacement(node)
        return plotting.plot_load_path(x, self.factors, self.stable, self.turns, axis, ax)
