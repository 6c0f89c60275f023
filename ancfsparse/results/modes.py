"""Natural frequencies and mode shapes, addressed by the handles of a scene."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from ancfsparse.checks import check_finite
from ancfsparse.errors import InputError
from ancfsparse.results.source import Array, SolvedSystem, combine
from ancfsparse.scene import Node
from ancfsparse.system.state import State
from ancfsparse.words import shown

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class Modes:
    """Small vibrations of a scene about a state, in ascending order of their eigenvalues.

    Parameters
    ----------
    system : SolvedSystem
        The system that vibrates.
    about : State
        The state.
    eigenvalues : ndarray, shape (n,)
        Squares of the angular frequencies [1/s2]: negative where the state is unstable, and 0
        within rounding, as for free rigid motions.
    shapes : ndarray, shape (n, n_all)
        Motions of the coordinates, m for positions and dimensionless for slopes, with the modal
        mass ``x.M x`` of 1 kg m2.
    damping_rates : ndarray, shape (n,)
        ``x.C x`` with the damping matrix C [1/s].
    rounding : ndarray, shape (n,)
        Bound of the rounding error of each eigenvalue [1/s2].
    effective_masses : ndarray, shape (n, dim)
        Effective mass of each mode along each axis [kg]; the sum over all modes is at most the
        mass of the scene.
    """

    system: SolvedSystem
    about: State
    eigenvalues: Array
    shapes: Array
    damping_rates: Array
    rounding: Array
    effective_masses: Array

    def __repr__(self) -> str:
        """Summarise the modes in one line."""
        first = ", ".join(f"{each:.6g}" for each in self.frequencies[:6])
        unstable = int(np.count_nonzero(self.eigenvalues < 0.0))
        return (
            f"Modes: {len(self)} modes, {first}{', ...' * (len(self) > 6)} Hz"
            + f", unstable ({unstable} growing)" * (unstable > 0)
        )

    def __len__(self) -> int:
        """Return the number of modes."""
        return len(self.eigenvalues)

    @property
    def frequencies(self) -> Array:
        """Natural frequencies without damping, (n,) [Hz]; 0 for rigid and for growing motions."""
        return np.asarray(np.sqrt(np.maximum(self.eigenvalues, 0.0)) / (2.0 * np.pi))

    @property
    def growth(self) -> Array:
        """Growth rates of motions from an unstable state, (n,) [1/s], without damping."""
        return np.asarray(np.sqrt(np.maximum(-self.eigenvalues, 0.0)))

    @property
    def stable(self) -> bool:
        """Whether no small motion grows."""
        return not (self.eigenvalues < 0.0).any()

    @property
    def damping(self) -> Array:
        """Damping ratios, (n,) [-], to first order in the damping; NaN without a frequency.

        Exact where damping is a combination of mass and stiffness matrix, as Rayleigh's is about
        the stress-free shape.
        """
        omega = 2.0 * np.pi * self.frequencies
        ratio = np.full(len(omega), np.nan)
        np.divide(self.damping_rates, 2.0 * omega, out=ratio, where=omega > 0.0)
        return ratio

    def displacement(self, node: Node) -> Array:
        """Return the displacement of a point in every mode.

        Parameters
        ----------
        node : Node
            Any point of a beam or of a rigid body.

        Returns
        -------
        ndarray, shape (n, dim)
            Displacements of shapes with the modal mass 1 kg m2 [m].
        """
        return combine(self.system.point(node), self.shapes)

    def position(self, node: Node) -> Array:
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
        moved = self.about.q + check_finite("amplitude", amplitude, "m") * self._unit(mode)
        rest = np.zeros_like(moved)
        return replace(self.about, q=moved, v=rest, a=rest, b=None, memory={})

    def _unit(self, mode: object) -> Array:
        """Return the shape in which the node that moves farthest moves by 1 m."""
        if isinstance(mode, bool) or not isinstance(mode, (int, np.integer)):
            raise InputError(f"mode is a number such as 0, got {shown(mode)}")
        if not -len(self) <= mode < len(self):
            raise InputError(f"mode counts from 0 to {len(self) - 1}, got {mode}")
        shape, dim = self.shapes[int(mode)], self.system.scene.dim
        moves = [np.sum(shape[p[:, :dim]] ** 2, axis=1).max() for p in self.about.layout.places]
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
        """Draw the two ends of a vibration in one mode, and the state between them.

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
        from ancfsparse.results.pictures import plot_mode

        unit, q = self._unit(mode), self.about.q
        if amplitude is not None:
            amplitude = check_finite("amplitude", amplitude, "m")
        name = f"mode {mode % len(self)}, {self.frequencies[mode]:.4g} Hz"
        return plot_mode(self.system, q, unit, amplitude, name, ax=ax, view=view)
