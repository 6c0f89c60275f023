"""The motion a simulation found, read by the names of the scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from ancfsparse.results.energy import Energy, energy_of
from ancfsparse.results.sections import SectionForce, Where, curvature, section_force, strain
from ancfsparse.results.source import Array, SolvedSystem, combine
from ancfsparse.results.stats import RunStats
from ancfsparse.scene import Body, Node

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False, repr=False)
class Trajectory:
    """Saved states of a run, the first one included.

    Parameters
    ----------
    system : SolvedSystem
        The system that moved.
    t : ndarray, shape (k,)
        Times [s].
    q, v, a : ndarray, shape (k, n)
        Coordinates (m for positions, dimensionless for slopes), their rates and second rates; of
        a run with ``output`` or ``save_nodes`` tables that are read like arrays (`tables`).
    lam : ndarray, shape (k, m)
        Multipliers of the constraints, none for joints made by numbering.
    stats : RunStats
        What the run cost.
    settings : mapping, optional
        What it was run with.
    """

    system: SolvedSystem
    t: Array
    q: Array
    v: Array
    a: Array
    lam: Array
    stats: RunStats
    settings: Mapping[str, Any] = field(default_factory=dict)

    def __repr__(self) -> str:
        """Sum the run up in two lines."""
        stats = self.stats
        return (
            f"Trajectory: {len(self.t)} states from t = {self.t[0]:.6g} s to {self.t[-1]:.6g} s, "
            f"{self.q.shape[1]} coordinates, {self.lam.shape[1]} multipliers\n  "
            + ("" if self.finished else f"unfinished: {self._aim}; ")
            + (
                f"{stats.steps} steps"
                + (f", {stats.short_steps} shorter ones" if stats.short_steps else "")
                + f", {stats.iterations_per_step:.2f} iterations per step, "
                f"{stats.factorizations} factorizations, {stats.march_seconds:.3g} s"
                if stats.steps or len(self.t) == 1
                else "ended without its counts"
            )
            + (f", {stats.solver}" if stats.solver else "")
        )

    @property
    def finished(self) -> bool:
        """Whether the run came to the end, and to the accuracy, that it was started for."""
        accuracy = self.settings.get("accuracy")
        return self._ended and (accuracy is None or self.stats.error <= accuracy)

    @property
    def _ended(self) -> bool:
        t_end = self.settings.get("t_end")
        return t_end is None or bool(self.t[-1] >= t_end * (1.0 - 1e-9))

    @property
    def _aim(self) -> str:
        """Say what the run did not come to."""
        if self._ended:
            error = f"the error is about {self.stats.error:.3g} m"
            return f"accuracy is {self.settings['accuracy']:.3g} m, {error}"
        return f"t_end is {self.settings['t_end']:.6g} s"

    @property
    def multipliers(self) -> Array:
        """Multipliers of the constraints, shape (k, m); another name for `lam`."""
        return self.lam

    @cached_property
    def energy(self) -> Energy:
        """The energy balance, worked out when first asked for."""
        return energy_of(self.system, self.t, self.q, self.v)

    def position(self, node: Node) -> Array:
        """Give the position of a point over time.

        Parameters
        ----------
        node : Node
            Any point of a beam, for example ``rod.end``.

        Returns
        -------
        ndarray, shape (k, dim)
            Positions [m].
        """
        return combine(self.system.point(node), self.q)

    def velocity(self, node: Node) -> Array:
        """Give the velocity of a point over time.

        Parameters
        ----------
        node : Node
            Any point of a beam.

        Returns
        -------
        ndarray, shape (k, dim)
            Velocities [m/s].
        """
        return combine(self.system.point(node), self.v)

    def acceleration(self, node: Node) -> Array:
        """Give the acceleration of a point over time.

        Parameters
        ----------
        node : Node
            Any point of a beam.

        Returns
        -------
        ndarray, shape (k, dim)
            Accelerations [m/s2].
        """
        return combine(self.system.point(node), self.a)

    def slope(self, node: Node) -> Array:
        """Give the slope r', the derivative of position by reference arc length, over time.

        Parameters
        ----------
        node : Node
            Any point of a beam.

        Returns
        -------
        ndarray, shape (k, dim)
            Slopes [-]; their length is the local stretch.
        """
        return combine(self.system.slope(node), self.q)

    def reaction(self, node: Node) -> Array:
        """Give the force that the joints at a node put on the beam, over time.

        Parameters
        ----------
        node : Node
            A node with a joint.

        Returns
        -------
        ndarray, shape (k, dim)
            Forces [N].
        """
        return self.system.reaction(node, self.q, self.v, self.a, self.lam, self.t)

    def strain(self, body: Body, s: Where = None) -> Array:
        """Give the strain of the axis over time.

        Parameters
        ----------
        body : Beam or Mesh
            One of the bodies.
        s : float, array_like of shape (p,), or sequence of Node, optional
            Arc coordinates along a beam [m], or points of a beam or a mesh, such as
            ``[mesh.at(3, 0.1)]``; a node between two elements counts with the one that begins
            there.  By default the middle of every element, in the order of elements or edges.

        Returns
        -------
        ndarray, shape (k, p)
            Elongation per length of the reference shape, |r'| - 1 [-].

        Raises
        ------
        InputError
            If the body is not of the run, or a point is not on it.
        """
        return strain(self.system, self.q, body, s)

    def curvature(self, body: Body, s: Where = None) -> Array:
        """Give how sections turn along the axis, over time.

        Parameters
        ----------
        body, s
            As in `strain`.

        Returns
        -------
        ndarray, shape (k, p) in the plane or (k, p, 3)
            Turn per length of the reference shape [1/m]: in the plane counterclockwise; of a cable
            in space as a vector in space; of a thick beam in space its twist and its curvatures
            about e_y and e_z of the section.
        """
        return curvature(self.system, self.q, body, s)

    def section_force(self, body: Body, s: Where = None) -> SectionForce:
        """Give axial force, shear, bending moment and torsion over time.

        Parameters
        ----------
        body, s
            As in `strain`.

        Returns
        -------
        SectionForce
            ``N``, ``Q``, ``M`` and ``T`` in the axes of the section, ``force`` and ``moment`` in
            space [N], [N m]: of the part beyond, at larger s, on the part before.
        """
        return section_force(self.system, self.q, self.v, body, s)

    def plot(
        self,
        what: str = "shape",
        of: Body | Node | None = None,
        *,
        times: ArrayLike | None = None,
        ax: Axes | None = None,
        view: str | tuple[float, float] | None = None,
    ) -> Axes:
        """Draw shapes at instants, or any quantity, into axes of matplotlib.

        Parameters
        ----------
        what : str, optional
            ``"shape"``; ``"energy"``; of a point, over time, ``"position"``, ``"velocity"``,
            ``"acceleration"``, ``"slope"`` or ``"reaction"``; ``"N"``, ``"Q"``, ``"M"``, ``"T"``,
            ``"strain"`` or ``"curvature"``, over time at a point or along a beam at instants.
        of : Beam, Mesh or Node, optional
            What it is of, ``rod`` or ``rod.end``; by default all bodies.
        times : array_like, optional
            Instants [s] of shapes and of quantities along a beam; the nearest saved states are
            drawn.  By default six, from the first to the last.
        ax : Axes, optional
            Where to draw; a new figure if not given.
        view : str or (float, float), optional
            For shapes in space: a plane such as ``"xz"``, or elevation and azimuth of the eye
            [degrees].  By default the plane that nothing leaves, else perspective.

        Returns
        -------
        Axes
            The axes drawn into; ``run.plot().figure.savefig("run.png")`` writes a file.

        Raises
        ------
        InputError
            If an argument is invalid.
        """
        from ancfsparse.results.pictures import plot

        return plot(self, what, of, times=times, ax=ax, view=view)

    def animate(
        self,
        path: str | Path,
        *,
        of: Body | None = None,
        seconds: float | None = None,
        fps: int = 25,
        dpi: int = 100,
        view: str | tuple[float, float] | None = None,
        trace: Sequence[Node] = (),
        progress: bool = True,
    ) -> Path:
        """Write a film of the motion.

        Parameters
        ----------
        path : str or Path
            Name of the file, ``"run.gif"`` or ``"run.mp4"``; the latter needs the program ffmpeg.
            A file of that name is replaced.
        of : Beam or Mesh, optional
            Which body; by default all.
        seconds : float, optional
            How long the film lasts [s]; by default as long as the motion, but at least 2 and at
            most 10.
        fps : int, optional
            Pictures per second, each of the saved state nearest in time.
        dpi : int, optional
            Pixels per inch; a picture is about 6.4 inches wide.
        view
            As in `plot`.
        trace : sequence of Node, optional
            Points whose way is drawn, such as ``[rod.end]``.
        progress : bool, optional
            Whether to draw a progress bar.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If an argument is invalid, or ffmpeg is missing.
        """
        from ancfsparse.results.animation import animate

        return animate(
            self, path, of=of, seconds=seconds, fps=fps, dpi=dpi, view=view, trace=trace,
            progress=progress,
        )  # fmt: skip
