"""Commands on files of runs: description, continuation, plots, animations, conversion, reports."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ancfsparse import solve
from ancfsparse.cli.options import in_options
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_target
from ancfsparse.results import export, plotting
from ancfsparse.results.data.selected_columns import SelectedColumns
from ancfsparse.results.hdf5_reader import load, read_contents, read_outline

PLOT_SUFFIXES = ".pdf", ".png", ".svg"

FileArgument = Annotated[Path, typer.Argument(help="File that simulate(..., output=...) wrote.")]
ViewOption = Annotated[
    str | None,
    typer.Option(
        metavar="VIEW",
        help="A plane such as xz, or elevation and azimuth in degrees such as 20,-60.",
    ),
]


def info(file: FileArgument) -> None:
    """Describe the file of a run."""
    run, scene = read_contents(file)
    t, settings, stats = run.t, run.settings, run.stats
    typer.echo(f"{file}: {len(t)} states from t = {t[0]:.6g} s to {t[-1]:.6g} s")
    t_end = settings.get("t_end")
    if t_end is not None and t[-1] < t_end * (1.0 - 1e-9):
        typer.echo(f"  unfinished: t_end is {t_end:.6g} s")
    typer.echo(f"  {run.q.shape[1]} coordinates, {run.lam.shape[1]} multipliers")
    if isinstance(run.q, SelectedColumns):
        typer.echo(f"  {len(run.q.places)} saved coordinates, those of save_nodes")
    for name, values in (("settings", settings), ("scene", scene)):
        typer.echo(f"{name}:")
        for key, value in values.items():
            if value not in (None, ""):
                typer.echo(f"  {key}: {value}")
    typer.echo(
        f"cost: {stats.steps} steps, {stats.iterations} iterations, {stats.factorizations} "
        f"factorizations, {stats.march_seconds:.3g} s"
    )
    if stats.solver:
        typer.echo(f"solver: {stats.method}")


def resume(
    file: FileArgument,
    progress: Annotated[bool, typer.Option(help="Show a progress bar.")] = True,
) -> None:
    """Continue the run of a file from its last checkpoint, if it was killed or interrupted."""
    with in_options():
        run = solve.resume(file, progress=progress)
    typer.echo(repr(run))


def plot(
    file: FileArgument,
    picture: Annotated[Path, typer.Argument(help="Plot to write: .png, .svg or .pdf.")],
    time: Annotated[
        list[float] | None, typer.Option(help="Time [s]; may be repeated [default: six times].")
    ] = None,
    view: ViewOption = None,
) -> None:
    """Plot the shapes of a run at some times."""
    check_target("a plot", picture, PLOT_SUFFIXES)
    outline, t, q, _ = read_outline(file)
    plt = without_display()
    plotting.draw_shapes(outline, t, q, time or None, view=_view(view))
    plt.savefig(picture, dpi=150)
    plt.close()
    typer.echo(f"written: {picture}")


def animate(
    file: FileArgument,
    film: Annotated[Path, typer.Argument(help="Animation to write: .gif, or .mp4 with ffmpeg.")],
    seconds: Annotated[float | None, typer.Option(help="Duration [s].")] = None,
    fps: Annotated[int, typer.Option(help="Frames per second.")] = 25,
    dpi: Annotated[int, typer.Option(help="Pixels per inch; the width is about 6 inches.")] = 100,
    view: ViewOption = None,
    style: Annotated[str, typer.Option(help="lines, or solid: shaded tubes and bodies.")] = "lines",
) -> None:
    """Write an animation of a run."""
    outline, t, q, _ = read_outline(file)
    without_display()
    options: dict[str, Any] = {"seconds": seconds, "fps": fps, "dpi": dpi, "view": _view(view)}
    plotting.animate(outline, t, q, film, style=style, **options)
    typer.echo(f"written: {film}")


def convert(
    file: FileArgument,
    target: Annotated[Path, typer.Argument(help="File to write: .vtkhdf, or .glb for Blender.")],
    per_element: Annotated[int, typer.Option(help="Straight pieces per element of VTKHDF.")] = 4,
) -> None:
    """Convert a run to VTKHDF, with velocities and strains, without axial forces, or to glTF."""
    outline, t, q, v = read_outline(file)
    if target.suffix == ".glb":
        export.write_gltf(outline, t, q, target)
    else:
        export.write_vtk(outline, t, q, v, target, per_element=per_element)
    typer.echo(f"written: {target}")


def report(
    file: FileArgument,
    page: Annotated[
        Path | None, typer.Argument(help="Page to write [default: as the file, with .html].")
    ] = None,
) -> None:
    """Write a report of a run: one web page with the moving scene, graphs and tables."""
    run = load(file)
    typer.echo(f"written: {run.report(file.with_suffix('.html') if page is None else page)}")


def without_display() -> Any:
    """Load pyplot for files only."""
    import matplotlib as mpl

    mpl.use("Agg")
    import matplotlib.pyplot as plt

    return plt


def _view(text: str | None) -> str | tuple[float, float] | None:
    if text is None or "," not in text:
        return text
    try:
        elevation, azimuth = map(float, text.split(","))
    except ValueError:
        raise InputError(f"--view takes two angles in degrees such as 20,-60, got {text}") from None
    if not np.isfinite([elevation, azimuth]).all():
        raise InputError(f"--view takes two finite angles in degrees, got {text}")
    return elevation, azimuth
