"""Stiffness of the springs that stand for constraints, beside what resists them otherwise."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ancfsparse.nonlinear.iteration import EPSILON
from ancfsparse.system import System

if TYPE_CHECKING:
    import scipy.sparse as sp

Vector = NDArray[np.float64]

# A correction leaves its inverse of a violation, and eps times it is lost to rounding.
PENALTY = 1e4


class Penalties:
    """Springs for constraints, stiffer than what they hold.

    A coordinate of an element resists by its own stiffness.  A rigid body has none: the curvature
    of its equations is a force over a length, and may be what rounding leaves of one.  So bodies
    that equations join all resist alike in every direction, by the stiffest spring or beam that is
    fastened to them, or by their loads over their size where that is more.

    Parameters
    ----------
    system : System
        What is at rest.
    phi_q : (m, n_free) sparse
        One for every entry that gradients of the constraints may have.
    forces : (n_free,) float
        What is unbalanced at the start, under all loads [N, N m].

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
        """Find the bodies that equations or coordinates join, and the loads on them."""
        import scipy.sparse as sp
        from scipy.sparse.csgraph import connected_components

        n, k = system.n_free, 0
        size, arm = np.zeros(n), np.zeros(n)  # of the body [m], and of the coordinate [m, 1]
        owner, owned = [], []
        for body, places, kind in zip(
            system.scene.bodies, system.places, system.kinds, strict=True
        ):
            if body.n_elements:
                continue
            for name in kind.vectors:
                own = places[:, kind.columns(name)].ravel()
                own = own[own < n]
                size[own] = np.maximum(size[own], body.size)
                arm[own] = np.maximum(arm[own], 1.0 if name == "r" else body.size)
                owner.append(np.full(len(own), k))
                owned.append(own)
            k += 1
        pairs = np.concatenate(owner), np.concatenate(owned)
        has = sp.csr_array((np.ones(len(pairs[0])), pairs), shape=(k, n))
        meets = has @ phi_q.T
        _, group = connected_components(has @ has.T + meets @ meets.T, directed=False)
        every = np.zeros(n, dtype=np.intp)
        every[pairs[1]] = group[pairs[0]]
        self._places = np.flatnonzero(arm)
        self._arm, self._group = arm[self._places], every[self._places]
        self._others = arm == 0.0
        # Groups in the columns: which equations hold them.
        of_places = (np.ones(len(self._places)), (self._places, self._group))
        self._holds = phi_q @ sp.csr_array(of_places, shape=(n, int(group.max()) + 1))
        self._loads = np.zeros(self._holds.shape[1])
        loads = np.abs(forces[self._places]) / (self._arm * size[self._places])
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
            That of what is fastened alone, without multipliers; for rigid bodies.
        """
        squares = phi_q.power(2)
        resistance = np.abs(diagonal)
        if material is not None:
            resistance[self._places] = self._of_bodies(squares, resistance, material)
        resistance[resistance == 0.0] = np.max(resistance)
        return np.asarray(PENALTY / (squares @ (1.0 / resistance)))

    def _of_bodies(self, squares: sp.csr_array, resistance: Vector, material: Vector) -> Vector:
        """Return the resistance of the coordinates of rigid bodies."""
        stiffest = self._loads.copy()
        np.maximum.at(stiffest, self._group, material[self._places] / self._arm**2)
        # What is fastened by equations: the stiffness of beams, one behind the other.
        beams = self._others & (resistance > 0.0)
        by_beam = squares @ beams > EPSILON * (squares @ np.ones(len(beams)))
        gives = squares[by_beam][:, beams] @ (1.0 / resistance[beams])
        held = self._holds[by_beam].tocoo()
        np.maximum.at(stiffest, held.coords[1], 1.0 / gives[held.coords[0]])
        # Where nothing resists and nothing pushes, any spring will do.
        stiffest[stiffest == 0.0] = np.max(stiffest) or 1.0
        return np.asarray(stiffest[self._group] * self._arm**2)
