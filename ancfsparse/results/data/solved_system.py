"""What results ask of a system: where things stand in its vectors, and what they add up to."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from ancfsparse.kernels.catalog import ElementKind
from ancfsparse.scene import Body, ElasticBody, Joint, Point, Scene
from ancfsparse.system.coordinates.state import State

if TYPE_CHECKING:
    from ancfsparse.scene.force_elements.ropes import Rope
    from ancfsparse.scene.loads.attachment import Attached
    from ancfsparse.system.recovery.joint_forces import States

Array = NDArray[np.float64]
Handle = TypeVar("Handle", Body, Point)
Places = tuple[NDArray[np.integer], Array]


class SolvedSystem(Protocol):
    """The part of a system that results rely on.

    Shapes: k saved states, n coordinates, m multipliers, dim components.
    """

    @property
    def scene(self) -> Scene:
        """What it was made of."""
        ...

    @property
    def bodies(self) -> tuple[Body, ...]:
        """What the scene had when this was made; later it may have more."""
        ...

    @property
    def joints(self) -> tuple[Joint, ...]:
        """The same of its joints."""
        ...

    @property
    def attached(self) -> tuple[Attached, ...]:
        """The same of what is attached to points."""
        ...

    @property
    def q_ref(self) -> Array:
        """Coordinates of the reference shape, (n,) [m, 1]."""
        ...

    def own(self, handle: Handle) -> Handle:
        """Give the handle of what was solved for one of the scene that a plan was made for."""
        ...

    def kind_of(self, beam: Body) -> ElementKind:
        """Return the name of the element of a body."""
        ...

    def elements(self, beam: ElasticBody) -> NDArray[np.int32]:
        """Give the places of the coordinates of every element of a body, (n_e, 2 n_c)."""
        ...

    def rows(self, node: Point) -> NDArray[np.int32]:
        """Give the places of the coordinates of all rows of a node, (k, n_c)."""
        ...

    def point(self, node: Point) -> Places:
        """Return how a position follows from the coordinates.

        Returns ``places`` (dim, p) and ``weights`` (p,): component i of the position is
        ``sum_j weights[j] q[places[i, j]]``.
        """
        ...

    def slope(self, node: Point) -> Places:
        """Return the same for the slope r' [-]."""
        ...

    def energies(self, q: Array, v: Array, t: Array | None = None) -> tuple[Array, Array, Array]:
        """Give kinetic, elastic and gravity's potential energy, each (k,) [J]."""
        ...

    @property
    def winds(self) -> bool:
        """Whether lengths or strains without force change with time."""
        ...

    def winding(self, q: Array, t: Array) -> Array:
        """Give the work of what changes them between consecutive states, (k - 1,) [J]."""
        ...

    def tension(self, rope: Rope, states: States) -> Array:
        """Give the tension of a rope, (k,) [N]."""
        ...

    def power(self, q: Array, v: Array, t: Array) -> Array:
        """Give the power of all applied forces but gravity, (k,) [W]."""
        ...

    @property
    def is_driven(self) -> bool:
        """Whether anything is prescribed over time."""
        ...

    def drive_work(self, q: Array, v: Array, a: Array, lam: Array, t: Array) -> Array:
        """Return the work of drives in steps of `EnergyMomentum`, (k - 1,) [J]."""

    def drive_power(self, q: Array, v: Array, a: Array, lam: Array, t: Array) -> Array:
        """Give the power of what drives coordinates and equations, (k,) [W]."""
        ...

    def dissipation(self, q: Array, v: Array, lam: Array) -> Array:
        """Give the power that damping takes, (k,) [W], never negative."""
        ...

    def state(self, t: float, q: Array, v: Array, a: Array, lam: Array, **more: Any) -> State:
        """Give a state with the meaning of its coordinates."""
        ...

    def reaction(self, node: Point, q: Array, v: Array, a: Array, lam: Array, t: Array) -> Array:
        """Give the force of the joints at a node on the beam, (k, dim) [N]."""
        ...

    def rows_of(self, joint: Joint) -> list[int]:
        """Give the multipliers of the equations of a joint."""
        ...

    def joint_force(self, joint: Joint, states: States) -> tuple[Array, Array, Array]:
        """Give force (k, dim) [N], moment (k,) or (k, 3) [N m] and axes (k, dim, dim)."""
        ...


def combine(places: Places, q: Array) -> Array:
    """Evaluate a position or slope for all states.

    Parameters
    ----------
    places : tuple of ndarray
        Places (dim, p) and weights (p,), as a system gives them.
    q : ndarray, shape (..., n)
        Coordinates, or velocities or accelerations: interpolation is linear.

    Returns
    -------
    ndarray, shape (..., dim)
        The interpolated vectors.
    """
    where, weights = places
    return np.asarray(q[..., where] @ weights)
