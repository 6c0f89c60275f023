"""Pictures, films and files of a run, whose makers are loaded where they are used."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from numpy.typing import ArrayLike

from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results import export, fields, geometry, plotting
from ancfsparse.results.data.interpolation import Array
from ancfsparse.results.solutions.solution import Solution
from ancfsparse.scene import Body, Point, check_point

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from ancfsparse.results.fields.energy_balance import Energy


class Outputs(Solution):
    """Plots, films and files of a `Trajectory`."""

    t: Array
    v: Array

    @property
    @abstractmethod
    def energy(self) -> Energy:
        """The energy balance."""

    def plot(
        self,
        what: str = "shape",
        of: Body | Point | None = None,
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
        of : Beam, Mesh, RigidBody or Point, optional
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

        Notes
        -----
        A rigid body is drawn by the edges of its shape, one given by its inertia by lines from its
        centre to the points that joints use, and along its axes, as long as those of the box of
        the same mass and inertia.
        """
        return plotting.plot_motion(self, what, of, times=times, ax=ax, view=view)

    def animate(
        self,
        path: str | Path,
        *,
        of: Body | None = None,
        seconds: float | None = None,
        fps: int = 25,
        dpi: int = 100,
        view: str | tuple[float, float] | None = None,
        trace: Sequence[Point] = (),
        progress: bool = True,
    ) -> Path:
        """Write a film of the motion.

        Parameters
        ----------
        path : str or Path
            Name of the file, ``"run.gif"`` or ``"run.mp4"``; the latter needs the program ffmpeg.
            A file of that name is replaced.
        of : Beam, Mesh or RigidBody, optional
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
        trace : sequence of Point, optional
            Points whose way is drawn, such as ``[rod.end]``.
        progress : bool, optional
            Whether to draw a progress bar, on a terminal only.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If an argument is invalid, or ffmpeg is missing.
        """
        if not isinstance(trace, (list, tuple)):
            raise InputError(f"trace must be a list such as [rod.end], got {format_value(trace)}")
        paths = [self.position(check_point("a trace", node)) for node in trace]
        return plotting.animate(
            plotting.outline_for(self.system, of), self.t, self.q, path, seconds=seconds, fps=fps,
            dpi=dpi, view=view, paths=paths, progress=progress,
        )  # fmt: skip

    def render(
        self,
        path: str | Path,
        *,
        time: float | None = None,
        of: Body | None = None,
        view: tuple[float, float] | None = None,
        size: tuple[int, int] = (1000, 750),
        strain: bool = False,
    ) -> Path:
        """Draw one state with sections in their true size, by PyVista, without a display.

        Parameters
        ----------
        path : str or Path
            Name of the picture, ``"run.png"``.  A file of that name is replaced.
        time : float, optional
            Instant [s], of which the nearest saved state is drawn; by default the last.
        of : Beam, Mesh or RigidBody, optional
            Which body; by default all.
        view : (float, float), optional
            Elevation and azimuth of the eye in a spatial scene [degrees].
        size : (int, int), optional
            Width and height in pixels.
        strain : bool, optional
            Whether colours show the strain of the axis.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If an argument is invalid, or PyVista is not installed.

        Notes
        -----
        Sections are drawn round, with their area; thin rods, and the lines of bodies given by their
        inertia, as thick as shows.
        """
        row = plotting.nearest_rows(self.t, [self.t[-1] if time is None else time])[0]
        outline = plotting.outline_for(self.system, of)
        return plotting.render(outline, self.q[row], path, view=view, size=size, strain=strain)

    def to_vtk(self, path: str | Path, *, per_element: int = 4, progress: bool = True) -> Path:
        """Write all states as VTKHDF, which the reader of VTK opens with its times.

        Every element is a polyline.  Its points carry ``Velocity`` [m/s], ``Strain`` of the axis
        [-] and ``Radius`` [m], that of the circle with the area of the section, by which a tube
        filter thickens the lines; every element has its ``AxialForce`` [N] and the number of its
        ``Body``.  The edges of rigid bodies are lines without strain and radius, whose axial force
        is NaN; their numbers follow those of beams and meshes.  Numbers are in single precision.

        Parameters
        ----------
        path : str or Path
            Name of the file, ``"run.vtkhdf"``.  A file of that name is replaced.
        per_element : int, optional
            Pieces per element.
        progress : bool, optional
            Whether to draw a progress bar, on a terminal only.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If an argument is invalid, or the run kept only some points.
        """
        forces = partial(fields.axial_forces, self.system)
        return export.write_vtk(
            geometry.outline_of(self.system), self.t, self.q, self.v, path, per_element=per_element,
            forces=forces, progress=progress,
        )  # fmt: skip

    def to_csv(
        self, path: str | Path, points: Sequence[Point], quantities: Sequence[str] = ("position",)
    ) -> Path:
        """Write the motion of points as CSV, one row for every saved state.

        Parameters
        ----------
        path : str or Path
            Name of the file, ``"run.csv"``.  A file of that name is replaced.
        points : sequence of Point
            Such as ``[rod.end]``.
        quantities : sequence of str, optional
            Of ``"position"``, ``"velocity"``, ``"acceleration"``, ``"slope"``, ``"reaction"``.

        Returns
        -------
        Path
            The file: its first row names quantity, component, point and unit of every column, and
            numbers have all their digits.

        Raises
        ------
        InputError
            If an argument is invalid.
        """
        return export.write_csv(self, path, points, quantities)
