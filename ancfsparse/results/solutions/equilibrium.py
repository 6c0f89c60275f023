"""The shape at rest that a static solution found, read by the names of the scene."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.data.solved_system import Array, SolvedSystem, combine
from ancfsparse.scene import Body, ElasticBody, Joint, Point
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ancfsparse.results.fields.joint_forces import JointForce
    from ancfsparse.results.fields.section_forces import SectionForce, Where
    from ancfsparse.scene.force_elements.ropes import Rope
    from ancfsparse.scene.mechanisms.winch import Winch


@dataclass(frozen=True, eq=False, repr=False)
class Equilibrium:
    """A state of rest under the loads at a time.

    Parameters
    ----------
    system : SolvedSystem
        The system at rest.
    q : ndarray, shape (n,)
        Coordinates, m for positions and dimensionless for slopes.
    lam : ndarray, shape (m,)
        Multipliers of the constraints.
    stats : RunStats
        What the solution cost; its steps are load steps.
    t : float
        The time of loads and drives [s].
    """

    system: SolvedSystem
    q: Array
    lam: Array
    stats: RunStats
    t: float = 0.0

    def __repr__(self) -> str:
        """Sum the solution up in one line."""
        return (
            f"Equilibrium: {len(self.q)} coordinates, {len(self.lam)} multipliers, "
            f"{self.stats.steps} load steps, {self.stats.iterations} iterations"
            + f", unstable ({self.stats.negative_pivots} negative pivots)"
            * (not self.stable)
        )

    @property
    def state(self) -> State:
        """The state of rest at time t that ``simulate(..., start=equilibrium)`` starts from."""
        rest = np.zeros_like(self.q)
        return self.system.state(self.t, self.q, rest, rest, self.lam)

    @property
    def stable(self) -> bool:
        """Whether it is stable: every small displacement from it takes energy.

        The stiffness is then definite.  Of moments about fixed axes in space, which have no
        potential, its symmetric part is looked at: where that is not definite the equilibrium may
        be stable all the same.
        """
        return self.stats.negative_pivots == 0

    @property
    def multipliers(self) -> Array:
        """Multipliers of the constraints, shape (m,); another name for `lam`."""
        return self.lam

    @property
    def elastic_energy(self) -> float:
        """Strain energy of the scene [J]."""
        state = self.q[None, :]
        return float(self.system.energies(state, np.zeros_like(state), np.array([self.t]))[1][0])

    def position(self, node: Point) -> Array:
        """Give the position of a point.

        Parameters
        ----------
        node : Point
            Any point of a beam.

        Returns
        -------
        ndarray, shape (dim,)
            Position [m].
        """
        return combine(self.system.point(node), self.q)

    def displacement(self, node: Point) -> Array:
        """Give how far a point has moved from the reference shape.

        Parameters
        ----------
        node : Point
            Any point of a beam.

        Returns
        -------
        ndarray, shape (dim,)
            Displacement [m].
        """
        return self.position(node) - node.position

    def slope(self, node: Point) -> Array:
        """Give the slope r', the derivative of position by reference arc length.

        Parameters
        ----------
        node : Point
            Any point of a beam.

        Returns
        -------
        ndarray, shape (dim,)
            Slope [-]; its length is the local stretch.
        """
        return combine(self.system.slope(node), self.q)

    def reaction(self, node: Point) -> Array:
        """Give the force that the joints at a node exert on the beam.

        Parameters
        ----------
        node : Point
            A node with a joint.

        Returns
        -------
        ndarray, shape (dim,)
            Force [N].
        """
        state = self.q[None, :]
        rest = np.zeros_like(state)
        force = self.system.reaction(node, state, rest, rest, self.lam[None, :], np.array([self.t]))
        return np.asarray(force[0])

    def joint_force(self, joint: Joint, frame: str = "space") -> JointForce:
        """Give force (dim,) [N] and moment [N m] of a joint, see `Trajectory.joint_force`."""
        from ancfsparse.results.fields.joint_forces import joint_force
        from ancfsparse.system.recovery.joint_forces import States

        state = self.q[None, :]
        rest = np.zeros_like(state)
        states = States(state, rest, rest, self.lam[None, :], np.zeros(1))
        return joint_force(self.system, joint, states, frame).at(0)

    def tension(self, rope: Rope | Winch) -> float:
        """Give the tension of a rope [N], see `Trajectory.tension`."""
        from ancfsparse.results.fields.joint_forces import tension
        from ancfsparse.system.recovery.joint_forces import States

        state = self.q[None, :]
        rest = np.zeros_like(state)
        states = States(state, rest, rest, self.lam[None, :], np.array([self.t]))
        return float(tension(self.system, rope, states)[0])

    def strain(self, body: ElasticBody, s: Where = None) -> Array:
        """Give the strain of the axis, |r'| - 1, shape (p,) [-]; see `Trajectory.strain`."""
        from ancfsparse.results.fields.section_forces import strain

        return np.asarray(strain(self.system, self.q[None, :], body, s)[0])

    def curvature(self, body: ElasticBody, s: Where = None) -> Array:
        """Give the curvature of the axis, (p,) or (p, 3) [1/m]: `Trajectory.curvature`."""
        from ancfsparse.results.fields.section_forces import curvature

        return np.asarray(curvature(self.system, self.q[None, :], body, s)[0])

    def section_force(self, body: ElasticBody, s: Where = None) -> SectionForce:
        """Give forces and moments in sections as `Trajectory.section_force`, for one state.

        Parameters
        ----------
        body, s
            As in `Trajectory.strain`.

        Returns
        -------
        SectionForce
            Without the axis of states: ``N`` has shape (p,) [N].
        """
        state = self.q[None, :]
        from ancfsparse.results.fields.section_forces import section_force

        return section_force(
            self.system, state, np.zeros_like(state), np.array([self.t]), body, s
        ).at(0)

    def plot(
        self,
        what: str = "shape",
        of: Body | None = None,
        *,
        ax: Axes | None = None,
        view: str | tuple[float, float] | None = None,
    ) -> Axes:
        """Draw the shape beside the reference shape, or a quantity along a beam.

        Parameters
        ----------
        what : str, optional
            ``"shape"``, ``"N"``, ``"Q"``, ``"M"``, ``"T"``, ``"strain"`` or ``"curvature"``.
        of : Beam or Mesh, optional
            Of which body; by default all.
        ax, view
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The axes drawn into.
        """
        from ancfsparse.results.plotting.plot import plot_at_rest

        return plot_at_rest(self.system, self.q, self.t, what, of, ax=ax, view=view)
