"""Stiffness of the penalty springs in place of constraints."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp


# A correction leaves its inverse of a violation, and rounding of eps times it.
PENALTY_RATIO = 1e4  # stiffness of a spring over that of the coordinates in the constraint


class Penalties:
    """Penalty springs, stiffer than the coordinates in the constraints.

    Coordinates of elements have a stiffness.  Rigid bodies have none: the curvature of their
    constraints is a force over a length, and may be rounding.  So connected rigid bodies get one
    stiffness in all directions: that of the stiffest spring or beam attached to them, or their
    loads over their size if that is more.

    Parameters
    ----------
    system : System
        The system at rest.
    phi_q : (m, n_free) sparse
        One for every entry that gradients of the constraints may have.
    forces : (n_free,) float
        Residual at the start under all loads [N, N m].

    Attributes
    ----------
    rigid : bool
        Whether there are bodies without elements.
    """

    def __init__(self, system: System, phi_q: sp.csr_array, forces: Vector) -> None:
        self.rigid = any(body.n_elements == 0 for body in system.scene.bodies)
        if self.rigid:
            self._join(system, phi_q, forces)

    def _join(self, system: System, phi_q: sp.csr_array, forces: Vector) -> None:
        """Find the groups of connected rigid bodies, and the loads on them."""
        import scipy.sparse as sp
        from scipy.sparse.csgraph import connected_components

        n, k = system.n_free, 0
        size, arm = np.zeros(n), np.zeros(n)  # of the body [m], and of the coordinate [m, 1]
        bodies, coordinates = [], []
        for body, places, kind in zip(
            system.scene.bodies, system.places, system.kinds, strict=True
        ):
            if body.n_elements:
                continue
            for name in kind.vectors:
                indices = places[:, kind.columns(name)].ravel()
                indices = indices[indices < n]
                size[indices] = np.maximum(size[indices], body.size)
                arm[indices] = np.maximum(arm[indices], 1.0 if name == "r" else body.size)
                bodies.append(np.full(len(indices), k))
                coordinates.append(indices)
            k += 1
        pairs = np.concatenate(bodies), np.concatenate(coordinates)
        has = sp.csr_array((np.ones(len(pairs[0])), pairs), shape=(k, n))
        meets = has @ phi_q.T
        _, group = connected_components(has @ has.T + meets @ meets.T, directed=False)
        group_of = np.zeros(n, dtype=np.intp)
        group_of[pairs[1]] = group[pairs[0]]
        self._rigid = np.flatnonzero(arm)
        self._arm, self._group = arm[self._rigid], group_of[self._rigid]
        self._others = arm == 0.0
        # For each group in the columns, the constraints that contain it.
        entries = (np.ones(len(self._rigid)), (self._rigid, self._group))
        self._holds = phi_q @ sp.csr_array(entries, shape=(n, int(group.max()) + 1))
        self._loads = np.zeros(self._holds.shape[1])
        loads = np.abs(forces[self._rigid]) / (self._arm * size[self._rigid])
        np.maximum.at(self._loads, self._group, loads)

    def springs(self, phi_q: sp.csr_array, diagonal: Vector, material: Vector | None) -> Vector:
        """Return a stiffness for each constraint, (m,) [N/m].

        Parameters
        ----------
        phi_q : (m, n_free) sparse
            Gradients of the constraints.
        diagonal : (n_free,) float
            Diagonal of the stiffness [N/m, N m].
        material : (n_free,) float or None
            Diagonal of the material stiffness alone; for rigid bodies.
        """
        squares = phi_q.power(2)
        stiffness = np.abs(diagonal)
        if material is not None:
            stiffness[self._rigid] = self._of_bodies(squares, stiffness, material)
        stiffness[stiffness == 0.0] = np.max(stiffness)
        return np.asarray(PENALTY_RATIO / (squares @ (1.0 / stiffness)))

    def _of_bodies(self, squares: sp.csr_array, stiffness: Vector, material: Vector) -> Vector:
        """Return the stiffness of the coordinates of rigid bodies."""
        stiffest = self._loads.copy()
        np.maximum.at(stiffest, self._group, material[self._rigid] / self._arm**2)
        # Beams that constraints attach: their coordinates act in series.
        beams = self._others & (stiffness > 0.0)
        by_beam = squares @ beams > EPSILON * (squares @ np.ones(len(beams)))
        flexibility = squares[by_beam][:, beams] @ (1.0 / stiffness[beams])
        attached = self._holds[by_beam].tocoo()
        np.maximum.at(stiffest, attached.coords[1], 1.0 / flexibility[attached.coords[0]])
        # Any spring will do without stiffness and loads.
        stiffest[stiffest == 0.0] = np.max(stiffest) or 1.0
        return np.asarray(stiffest[self._group] * self._arm**2)
