"""Shapes in which a scene vibrates or buckles, addressed by its handles."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.checks import MAX_MAGNITUDE, check_finite
from ancfsparse.errors import InputError
from ancfsparse.results import plotting
from ancfsparse.results.data.index_checks import check_index
from ancfsparse.results.data.interpolation import Array, combine
from ancfsparse.scene import Point
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def check_amplitude(amplitude: object) -> float:
    """Return an amplitude [m] whose products with frequencies are in the range of numbers."""
    size = check_finite("amplitude", amplitude, "m")
    if abs(size) > MAX_MAGNITUDE:
        raise InputError(f"amplitude must be at most {MAX_MAGNITUDE:g} m, got {size:g} m")
    return size


class ModeShapes(ABC):
    """Small motions about a state.

    Attributes
    ----------
    system : System
        The system that moves.
    about : State
        The state.
    shapes : ndarray, shape (n, n_all)
        Motions of the coordinates, m for positions and dimensionless for slopes; they may be
        complex.
    """

    system: System
    about: State
    shapes: Any

    @abstractmethod
    def _name(self, mode: int) -> str:
        """Return what a picture calls a mode."""

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.shapes)

    def displacement(self, node: Point) -> Array:
        """Return the displacement of a point in every mode.

        Parameters
        ----------
        node : Point
            Any point of a beam or of a rigid body.

        Returns
        -------
        ndarray, shape (n, dim)
            Displacements [m] of `shapes`, with their scale; complex if they are.
        """
        return combine(self.system.point(node), self.shapes)

    def position(self, node: Point) -> Array:
        """Return the position of a point in the state of reference, shape (dim,) [m]."""
        return combine(self.system.point(node), self.about.q)

    def state(self, mode: int, amplitude: float) -> State:
        """Return the state of rest at the turning point of a vibration in one mode.

        ``simulate(scene, ..., start=modes.state(0, 1e-3))`` releases it.

        Parameters
        ----------
        mode : int
            Which, from 0; from the last one if negative.
        amplitude : float
            Displacement of the node that moves farthest [m]; small compared with the scene.

        Returns
        -------
        State
            At the time of `about`.
        """
        moved = self.about.q + check_amplitude(amplitude) * self._unit(mode).real
        rest = np.zeros_like(moved)
        return replace(self.about, q=moved, v=rest, a=rest, b=None, memory={})

    def _unit(self, mode: object) -> Array:
        """Return the shape whose real part moves the node that moves farthest by 1 m."""
        shape, dim = self.shapes[check_index("mode", mode, len(self))], self.system.scene.dim
        moves = [
            np.sum(shape.real[p[:, :dim]] ** 2, axis=1).max() for p in self.about.layout.places
        ]
        farthest = float(np.sqrt(max(moves)))
        if farthest == 0.0:
            raise InputError(f"no node is displaced in mode {mode}, so it has no amplitude in m")
        return np.asarray(shape / farthest)

    def plot(
        self,
        mode: int = 0,
        amplitude: float | None = None,
        *,
        ax: Axes | None = None,
        view: str | tuple[float, float] | None = None,
    ) -> Axes:
        """Draw a mode to both sides, and the state it is about.

        Parameters
        ----------
        mode : int, optional
            Which, from 0; from the last one if negative.
        amplitude : float, optional
            As in `state` [m]; by default a tenth of the size of the scene.
        ax, view
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The axes drawn into.
        """
        unit, q = self._unit(mode).real, self.about.q
        if amplitude is not None:
            amplitude = check_amplitude(amplitude)
        name = self._name(mode)
        return plotting.plot_mode(self.system, q, unit, amplitude, name, ax=ax, view=view)
