"""Shapes of vibration and buckling modes."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from ancfsparse.array_types import Vector
from ancfsparse.checks import MAX_MAGNITUDE, check_finite
from ancfsparse.errors import InputError
from ancfsparse.results import plotting
from ancfsparse.results.data.index_checks import check_index
from ancfsparse.results.data.interpolation import interpolate
from ancfsparse.scene import Point
from ancfsparse.system.coordinates.state import State
from ancfsparse.system.system import System

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def check_amplitude(amplitude: object) -> float:
    """Return an amplitude [m] whose products with frequencies do not overflow."""
    size = check_finite("amplitude", amplitude, "m")
    if abs(size) > MAX_MAGNITUDE:
        raise InputError(f"amplitude must be at most {MAX_MAGNITUDE:g} m, got {size:g} m")
    return size


@dataclass(frozen=True, eq=False, repr=False)
class ModeShapes(ABC):
    """Small motions about a state.

    Parameters
    ----------
    system : System
        The discrete system.
    about : State
        State of linearisation.
    shapes : ndarray, shape (n, n_all)
        Motions of the coordinates, m for positions and dimensionless for slopes, with the modal
        mass ``x.M x`` of 1 kg m2; complex ones with ``x^H M x`` of 1 kg m2, and with a phase for
        which ``x.M x`` is real and positive.
    """

    system: System
    about: State
    shapes: Any

    @abstractmethod
    def _name(self, mode: int) -> str:
        """Return the label of a mode in plots."""

    def _first(self, values: Vector) -> str:
        """Return the first six of some values of the modes."""
        return ", ".join(f"{each:.6g}" for each in values[:6]) + ", ..." * (len(self) > 6)

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.shapes)

    def displacement(self, node: Point) -> Vector:
        """Return the displacement of a point in every mode.

        Parameters
        ----------
        node : Point
            Any point of a beam or of a rigid body.

        Returns
        -------
        ndarray, shape (n, dim)
            Displacements [m] in the scale of `shapes`; complex for complex modes.
        """
        return interpolate(self.system.point(node), self.shapes)

    def position(self, node: Point) -> Vector:
        """Return the position of a point in the state `about`, shape (dim,) [m]."""
        return interpolate(self.system.point(node), self.about.q)

    def state(self, mode: int, amplitude: float) -> State:
        """Return the state at maximum displacement of a vibration in one mode, at rest.

        ``simulate(scene, ..., start=modes.state(0, 1e-3))`` releases it.

        Parameters
        ----------
        mode : int
            Its index, from 0; from the last one if negative.
        amplitude : float
            Largest displacement of a node [m]; small compared with the scene.

        Returns
        -------
        State
            At the time of `about`.
        """
        moved = self.about.q + check_amplitude(amplitude) * self._unit(mode).real
        rest = np.zeros_like(moved)
        return replace(self.about, q=moved, v=rest, a=rest, b=None, memory={})

    def _unit(self, mode: object) -> Vector:
        """Return the shape scaled to a largest nodal displacement of its real part of 1 m."""
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
        """Plot both extreme shapes of a mode, and the state of linearisation.

        Parameters
        ----------
        mode : int, optional
            Its index, from 0; from the last one if negative.
        amplitude : float, optional
            As in `state` [m]; by default a tenth of the extent of the scene.
        ax, view
            As in `Trajectory.plot`.

        Returns
        -------
        Axes
            The axes.
        """
        unit, q = self._unit(mode).real, self.about.q
        if amplitude is not None:
            amplitude = check_amplitude(amplitude)
        name = self._name(mode)
        return plotting.plot_mode(self.system, q, unit, amplitude, name, ax=ax, view=view)
