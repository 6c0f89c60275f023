"""A static equilibrium."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.results import fields, plotting
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.solutions.solution import SingleState
from ancfsparse.scene import Body
from ancfsparse.system.coordinates.state import State, StateHistory
from ancfsparse.system.system import System

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ancfsparse.results.fields.contact_table import ContactTable


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium(SingleState):
    """A static equilibrium under the loads at a time.

    Parameters
    ----------
    system : System
        The discrete system.
    q : ndarray, shape (n,)
        Coordinates, m for positions and dimensionless for slopes.
    lam : ndarray, shape (m,)
        Lagrange multipliers of the constraints.
    stats : RunStats
        Operation counts and times; steps are load steps.
    t : float
        Time of loads and prescribed motions [s].
    internal : ndarray, shape (h,), optional
        Internal variables: deflections of bristles of contacts [m].
    memory : ndarray, optional
        Internal variables of forces that ``simulate(..., start=equilibrium)`` begins with.
    """

    system: System
    q: Vector
    lam: Vector
    stats: RunStats
    t: float = 0.0
    internal: Vector = field(default_factory=lambda: np.empty(0))
    memory: Vector = field(default_factory=lambda: np.empty(0))

    def __repr__(self) -> str:
        """Summarise the solution in one line."""
        return (
            f"Equilibrium: {len(self.q)} coordinates, {len(self.lam)} multipliers, "
            f"{self.stats.steps} load steps, {self.stats.iterations} iterations"
            + f", unstable ({self.stats.negative_pivots} negative pivots)"
            * (not self.stable)
        )

    @property
    def state(self) -> State:
        """The state at rest at time t from which ``simulate(..., start=equilibrium)`` starts."""
        rest = np.zeros_like(self.q)
        memory = {"scene": self.system.description, "contributions": self.memory}
        return self.system.state(self.t, self.q, rest, rest, self.lam, memory=memory)

    @property
    def stable(self) -> bool:
        """True if the equilibrium is stable: every small displacement requires energy.

        The stiffness is then positive definite.  For moments about fixed axes in space, which have
        no potential, the criterion is its symmetric part, which is sufficient but not necessary.
        """
        return self.stats.negative_pivots == 0

    @property
    def _states(self) -> StateHistory:
        rest = np.zeros((1, len(self.q)))
        times = np.array([self.t])
        return StateHistory(self.q[None], rest, rest, self.lam[None], times, self.internal[None])

    @property
    def multipliers(self) -> Vector:
        """Lagrange multipliers of the constraints, shape (m,); the same as `lam`."""
        return self.lam

    @property
    def elastic_energy(self) -> float:
        """Strain energy of the scene [J]."""
        q, v, _, _, t, _ = self._states
        return float(self.system.energies(q, v, t)[1][0])

    def contacts(self) -> ContactTable:
        """Return the places that touch, as `Trajectory.contacts` does."""
        return fields.contact_table(self.system, self.q, np.zeros(len(self.q)), self.internal)

    def plot(
        self,
        what: str = "shape",
        of: Body | None = None,
        *,
        ax: Axes | None = None,
        view: str | tuple[float, float] | None = None,
        colour: str | None = None,
    ) -> Axes:
        """Plot the deformed and the reference shape, or a quantity along a beam.

        Parameters
        ----------
        what : str, optional
            ``"shape"``, ``"N"``, ``"Q"``, ``"M"``, ``"T"``, ``"strain"``, ``"curvature"``,
            ``"pressure"`` or ``"friction"``.
        of : Beam or Mesh, optional
            Body; by default all.
        ax, view, colour
            As in `Trajectory.plot`; with a `colour` the reference shape is left out.

        Returns
        -------
        Axes
            The axes.
        """
        return plotting.plot_equilibrium(
            self.system, self._states, what, of, ax=ax, view=view, colour=colour
        )
