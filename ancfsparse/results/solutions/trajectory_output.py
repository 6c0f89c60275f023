"""Plots, animations and files of a trajectory; the modules that write them load on first use."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from numpy.typing import ArrayLike

from ancfsparse.array_types import Vector
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results import export, plotting
from ancfsparse.results.data.run_statistics import RunStats
from ancfsparse.results.solutions.solution import Solution
from ancfsparse.scene import Beam, Body, Point, check_point

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.axes import Axes

    from ancfsparse.results.fields.energy_balance import Energy


class TrajectoryOutput(Solution):
    """Plots, animations and files of a `Trajectory`."""

    t: Vector
    v: Vector
    a: Vector
    lam: Vector
    internal: Vector
    stats: RunStats
    settings: Mapping[str, Any]

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
        colour: str | None = None,
    ) -> Axes:
        """Plot shapes at some times, or a quantity, into axes of matplotlib.

        Parameters
        ----------
        what : str, optional
            ``"shape"``; ``"energy"``; of a point, over time, ``"position"``, ``"velocity"``,
            ``"acceleration"``, ``"slope"`` or ``"reaction"``; ``"N"``, ``"Q"``, ``"M"``, ``"T"``,
            ``"strain"``, ``"curvature"``, or the magnitude of ``"pressure"`` or ``"friction"`` of
            all contacts, over time at a point or along a beam at some times.
        of : Beam, Mesh, RigidBody or Point, optional
            Body or point, such as ``rod`` or ``rod.end``; by default all bodies.
        times : array_like, optional
            Times [s] of shapes and of quantities along a beam, rounded to those of saved states.
            By default six, from the first to the last; with a `colour` the last.  ``"range"`` plots
            the minimum, mean and maximum over all saved states along a beam.
        ax : Axes, optional
            Axes to plot into; by default those of a new figure.
        view : str or (float, float), optional
            For shapes in space: a plane such as ``"xz"``, or elevation and azimuth of the viewpoint
            [degrees].  By default the plane of a planar motion, else perspective.
        colour : str, optional
            Colour the elements of shapes by ``"N"``, ``"strain"``, ``"pressure"`` or
            ``"friction"``.

        Returns
        -------
        Axes
            The axes; ``run.plot().figure.savefig("run.png")`` writes a file.

        Raises
        ------
        InputError
            If an argument is invalid.

        Notes
        -----
        A rigid body is represented by the edges of its shape.  A body without shape is represented
        by lines from its centre of mass to its joints, and along its axes, with the lengths of the
        box of equal mass and inertia.  Point masses are dots.  Forces are arrows with their
        direction at t = 0, of one length; those that are zero then, follow the body or are
        functions of the motion are crosses.  Lines to anchors that are farther away than ten times
        the extent of the bodies are cut.  Drums and balls are shown in full unless bodies would
        become smaller than a third of the picture, half-spaces where they are near the bodies.  The
        radius of a turning drum shows its rotation since t = 0.
        """
        return plotting.plot_motion(self, what, of, times=times, ax=ax, view=view, colour=colour)

    def animate(
        self,
        path: str | Path,
        *,
        of: Body | None = None,
        seconds: float | None = None,
        fps: int = 25,
        dpi: int = 100,
        view: str | tuple[float, float] | None = None,
        style: str = "lines",
        colour: str | None = None,
        trace: Sequence[Point] = (),
        progress: bool = True,
    ) -> Path:
        """Write an animation of the motion.

        Parameters
        ----------
        path : str or Path
            File name, such as ``"run.gif"`` or ``"run.mp4"``; the latter needs the program ffmpeg.
            An existing file is replaced.
        of : Beam, Mesh or RigidBody, optional
            Body; by default all.
        seconds : float, optional
            Duration of the animation [s]; by default that of the motion, but at least 2 and at most
            10.
        fps : int, optional
            Frames per second; each shows the saved state nearest in time.
        dpi : int, optional
            Pixels per inch; a frame is about 6.4 inches wide.
        view
            As in `plot`.
        style : str, optional
            ``"lines"`` in axes with scales, or ``"solid"``: shaded tubes, bodies, balls and drums.
            Tubes have the area of their section, but at least a radius of 0.3 % of the picture.
        colour : str, optional
            Colour the tubes of ``style="solid"`` as in `plot`.
        trace : sequence of Point, optional
            Points whose paths are drawn, such as ``[rod.end]``.
        progress : bool, optional
            Show a progress bar, on a terminal only.

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
        outline = plotting.outline_for(self.system, of)
        return plotting.animate(
            outline, self.t, self.q, path, seconds=seconds, fps=fps, dpi=dpi, view=view,
            style=style, colours=plotting.colours_of(self, colour, outline), paths=paths,
            progress=progress,
        )  # fmt: skip

    def render(
        self,
        path: str | Path,
        *,
        time: float | None = None,
        of: Body | None = None,
        view: tuple[float, float] | None = None,
        size: tuple[int, int] = (1000, 750),
        colour: str | None = None,
    ) -> Path:
        """Render one state with sections in true size, by PyVista, without a display.

        Parameters
        ----------
        path : str or Path
            File name, such as ``"run.png"``.  An existing file is replaced.
        time : float, optional
            Time [s]; the nearest saved state is rendered.  By default the last.
        of : Beam, Mesh or RigidBody, optional
            Body; by default all.
        view : (float, float), optional
            Elevation and azimuth of the viewpoint in a spatial scene [degrees].
        size : (int, int), optional
            Width and height in pixels.
        colour
            As in `plot`.

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
        Sections are drawn as circles of equal area; thin rods and the lines of bodies without shape
        have a visible thickness.
        """
        row = plotting.nearest_row(self.t, self.t[-1] if time is None else time)
        return plotting.render(self, row, path, of=of, view=view, size=size, colour=colour)

    def report(
        self,
        path: str | Path,
        *,
        points: Sequence[Point] | None = None,
        lines: Sequence[Beam] | None = None,
    ) -> Path:
        """Write a report: one web page with the moving scene, graphs and tables.

        The page is a single file and does not load others.  It has the moving scene, with tubes in
        true size coloured by axial force [N], strain [-] or curvature [1/m], and arrows for loads
        at points and forces of joints [N]; histories at points
        and ranges along beams; energies [J], the solver and the reasons for its selection, events,
        settings and versions.

        Parameters
        ----------
        path : str or Path
            File name, such as ``"run.html"``.  An existing file is replaced.
        points : sequence of Point, optional
            Points whose position [m] and axial force [N] are plotted over time; by default the
            ends of the first four beams or the origins of rigid bodies.
        lines : sequence of Beam, optional
            Beams along which the ranges of axial force [N] and bending moment [N m] are plotted;
            by default the first four.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If an argument is invalid, the run saved only some points, or the file cannot be
            written.

        Notes
        -----
        The scene has up to 501 of the saved states, fewer for large scenes.  Its coordinates are
        rounded to 1 / 65535 of their range.  A browser without WebGL shows a message in place of
        the scene, and all graphs and tables.
        """
        return export.write_report(self, path, points, lines)

    def _repr_html_(self) -> str | None:
        """Return the moving scene for a notebook."""
        return export.show_run(self)

    def to_vtk(self, path: str | Path, *, per_element: int = 4, progress: bool = True) -> Path:
        """Write all states as a VTKHDF file with time steps.

        Every element is a polyline.  Its points have ``Velocity`` [m/s], ``Strain`` of the axis [-]
        and ``Radius`` [m], the radius of the circle of equal area for a tube filter; every element
        has its ``AxialForce`` [N] and the number of its ``Body``.  The edges of rigid bodies are
        lines with zero strain and radius and an axial force of NaN; their numbers follow those of
        beams and meshes.  Values are in single precision.

        Parameters
        ----------
        path : str or Path
            File name, such as ``"run.vtkhdf"``.  An existing file is replaced.
        per_element : int, optional
            Straight pieces per element.
        progress : bool, optional
            Show a progress bar, on a terminal only.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If an argument is invalid, or the run saved only some points.
        """
        return export.write_motion(self, path, per_element, progress)

    def to_gltf(self, path: str | Path) -> Path:
        """Write the moving scene as a glTF file with animation, for Blender and browsers.

        Parameters
        ----------
        path : str or Path
            File name, such as ``"run.glb"``.  An existing file is replaced.

        Returns
        -------
        Path
            The file.

        Raises
        ------
        InputError
            If an argument is invalid, the run saved only some points, or pygltflib is not
            installed.

        Notes
        -----
        Up to 501 of the saved states are the frames of the animation, whose time [s] begins at
        zero.  Coordinates are in metres and single precision, with the direction opposite to
        gravity upwards, y in the format.  Beams and meshes are tubes with the area of their
        section around the exact axis: each element is a skin with four joints.  Rigid bodies,
        ropes and springs are nodes that move.  Obstacles do not turn.
        """
        outline = plotting.outline_for(self.system, None)
        return export.write_gltf(outline, self.t, self.q, path)

    def to_csv(
        self, path: str | Path, points: Sequence[Point], quantities: Sequence[str] = ("position",)
    ) -> Path:
        """Write the motion of points as a CSV file with one row for every saved state.

        Parameters
        ----------
        path : str or Path
            File name, such as ``"run.csv"``.  An existing file is replaced.
        points : sequence of Point
            Points, such as ``[rod.end]``.
        quantities : sequence of str, optional
            Any of ``"position"``, ``"velocity"``, ``"acceleration"``, ``"slope"``, ``"reaction"``.

        Returns
        -------
        Path
            The file.  Its first row gives quantity, component, point and unit of every column;
            values have all digits.

        Raises
        ------
        InputError
            If an argument is invalid.
        """
        return export.write_csv(self, path, points, quantities)

    def to_pandas(
        self, points: Sequence[Point] | None = None, quantities: Sequence[str] = ("position",)
    ) -> pd.DataFrame:
        """Return the history of points as a data frame of pandas.

        Parameters
        ----------
        points : sequence of Point, optional
            Points, such as ``[rod.end]``; by default the end of each beam and the origin of each
            rigid body.
        quantities : sequence of str, optional
            Any quantities of `Trajectory.history`.

        Returns
        -------
        pandas.DataFrame
            One row for each saved state, with its time [s] as index.  The columns have the levels
            quantity, point and component; ``frame.attrs["units"]`` has the SI unit of each
            quantity.

        Raises
        ------
        InputError
            If an argument is invalid, or pandas is not installed.
        """
        return export.make_frame(self, points, quantities)

    def to_xarray(
        self, quantities: Sequence[str] = ("position", "velocity", "strain", "N")
    ) -> xr.Dataset:
        """Return the run as a dataset of xarray.

        Parameters
        ----------
        quantities : sequence of str, optional
            ``"position"`` [m], ``"velocity"`` [m/s] and ``"acceleration"`` [m/s2] of nodes, and the
            quantities of `Trajectory.range` in the middle of elements.

        Returns
        -------
        xarray.Dataset
            ``"energy"`` [J] by time and form, and for each body a variable with its name and the
            quantity, such as ``"body 0 position"``, by time, node or element, and component.  A
            rigid body has the motion of its origin.  Each variable has its SI unit in
            ``attrs["units"]``, the dataset has the settings of the run in ``attrs``.

        Raises
        ------
        InputError
            If an argument is invalid, the run saved only some points, or xarray is not installed.
        """
        return export.make_dataset(self, quantities)
