"""The command ``ancfsparse demo``: films of named scenes."""

from __future__ import annotations

import time
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer

from ancfsparse.checks import check_choice
from ancfsparse.cli.files import without_display
from ancfsparse.cli.options import in_options
from ancfsparse.file_names import check_target
from ancfsparse.problems.named import MECHANISMS
from ancfsparse.solve import simulate, solve_static


@dataclass(frozen=True)
class Film:
    """A film of a named mechanism.

    Attributes
    ----------
    trade : str
        Who builds such things.
    t_end, dt : float
        Duration of the motion, and time step [s].
    save_every : int
        Steps between saved states.
    options : dict
        Options of `Trajectory.animate`.
    keys : dict
        Arguments of the mechanism that differ from their defaults.
    """

    trade: str
    t_end: float
    dt: float
    save_every: int
    options: dict[str, Any]
    keys: dict[str, Any]


FILMS = {
    "net_on_sphere": Film("nets", 2.0, 4e-3, 5, {"colour": "N", "view": (18, -60)}, {}),
    "cable_car": Film("cables", 8.0, 4e-3, 20, {"colour": "N"}, {}),
    "serpentine": Film("belts", 0.3, 2e-4, 10, {"colour": "N"}, {"alternator": 2.0, "pump": 3.0}),
    "mooring": Film("moorings", 20.0, 2e-2, 5, {"colour": "N", "view": (14, -60)}, {}),
    "robot_arm": Film("hoses", 3.0, 2e-3, 10, {"colour": "strain"}, {}),
    "spring_antenna": Film("flexible mechanisms", 0.4, 1e-3, 2, {"view": (12, -60)}, {}),
    "hair": Film("fibres", 1.6, 1e-3, 20, {"view": (22, -60)}, {}),
    "knot": Film("ropes", 16.0, 2e-3, 100, {"colour": "strain", "view": (65, -90)}, {"mu": 0.1}),
    "double_pendulum_bob": Film("tethers", 2.0, 1e-3, 10, {"colour": "N"}, {}),
}  # fmt: skip
"""Films by the names of their scenes; the first is the default."""
FIRST = next(iter(FILMS))
SECONDS = 3.0  # s, of a film


def demo(
    scene: Annotated[str, typer.Argument(help=", ".join(FILMS) + ".")] = FIRST,
    film: Annotated[
        Path | None,
        typer.Argument(help="Film to write: .gif, or .mp4 with ffmpeg [default: SCENE.gif]."),
    ] = None,
    fps: Annotated[int, typer.Option(help="Frames per second.")] = 20,
    dpi: Annotated[int, typer.Option(help="Pixels per inch; the width is 6.4 inches.")] = 100,
) -> None:
    """Compute the motion of a named scene, and write a film of it, within a minute."""
    case = MECHANISMS[check_choice("scene", scene, FILMS)]
    shot = FILMS[scene]
    target = check_target("a film", film or Path(f"{scene}.gif"), (".gif", ".mp4"))
    summary = (case.make.__doc__ or "").partition(".\n")[0]
    typer.echo(f"{scene}: {' '.join(summary.removeprefix('Return ').split())}")
    mechanism = case.make(**shot.keys)
    start = solve_static(mechanism.scene) if mechanism.settles else None
    begin = time.perf_counter()
    run = simulate(
        mechanism.scene, shot.t_end, shot.dt, start=start, integrator=case.integrator,
        save_every=shot.save_every,
    )  # fmt: skip
    elapsed = time.perf_counter() - begin
    typer.echo(
        f"  {run.stats.steps} steps of {shot.dt:g} s with {run.q.shape[1]} coordinates in "
        f"{elapsed:.2g} s: {elapsed / shot.t_end:.2g} s per second of motion"
    )
    row = int(np.argmin(np.abs(run.t - case.time)))
    values = np.atleast_1d(mechanism.quantities(run, [row])[case.quantity][0])
    typer.echo(
        f"  {case.quantity} at {run.t[row]:g} s: {_format_values(values)} in SI units\n"
        f"  reference: {_format_values(case.value)} ({case.source})"
    )
    without_display()
    with in_options():
        begin = time.perf_counter()
        run.animate(target, style="solid", seconds=SECONDS, fps=fps, dpi=dpi, **shot.options)
    typer.echo(f"written: {target}, in {time.perf_counter() - begin:.2g} s")
    others = [name for name in FILMS if name != scene]
    typer.echo(
        f"next: ancfsparse demo {others[0]}      (also {', '.join(others[1:])})\n"
        f"      ancfsparse new {scene}.toml --problem {scene}      the scene as text, to change\n"
        f"      ancfsparse run {scene}.toml -o {scene}.h5\n"
        f"      ancfsparse report {scene}.h5      a page that plays the motion in a browser"
    )


def _format_values(values: Iterable[float]) -> str:
    return ", ".join(f"{value:.5g}" for value in values)
