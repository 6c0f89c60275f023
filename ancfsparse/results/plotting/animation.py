"""Films of runs, as GIF or MP4."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image
from tqdm import tqdm

from ancfsparse.checks import check_count, check_flag, check_positive
from ancfsparse.errors import InputError
from ancfsparse.messages import format_value
from ancfsparse.results.data.hdf5_format import check_file_name
from ancfsparse.results.data.interpolation import Array
from ancfsparse.results.geometry.deformed_shape import read_rows
from ancfsparse.results.geometry.scene_outline import Outline
from ancfsparse.results.plotting.canvas import Canvas, trace_scene

# By default a film lasts as long as the motion, within these limits [s].
SHORTEST, LONGEST = 2.0, 10.0
# Most pictures of a film, and pixels per inch: an hour at 25 per second, and as fine as print.
MOST_PICTURES, MOST_DPI = 90_000, 1200
# Colours in a GIF, and the shades of each up to white.
SHADES = {"k": 32, "C0": 24, "C1": 16}


def animate(
    outline: Outline,
    t: Array,
    q: Array,
    path: str | Path,
    *,
    seconds: float | None = None,
    fps: int = 25,
    dpi: int = 100,
    view: str | tuple[float, float] | None = None,
    paths: Sequence[Array] = (),
    progress: bool = True,
) -> Path:
    """Write a film, as `Trajectory.animate` does.

    Parameters
    ----------
    outline : Outline
        What is drawn.
    t : ndarray, shape (k,)
        Times [s].
    q : table, shape (k, n)
        Coordinates.
    paths : sequence of ndarray, each of shape (k, dim)
        Points whose way is drawn [m].
    path, seconds, fps, dpi, view, progress
        As there.
    """
    target = check_file_name("a film", path)
    writer = _writer(target, check_count("fps", fps))
    if check_count("dpi", dpi, 10) > MOST_DPI:
        raise InputError(f"dpi must be at most {MOST_DPI}, got {format_value(dpi)}")
    check_flag("progress", progress)
    if not target.absolute().parent.is_dir():
        raise InputError(f"{target} cannot be written: there is no folder {target.parent}")
    lasts = float(t[-1] - t[0])
    if seconds is None:
        seconds = min(max(lasts, SHORTEST), LONGEST)
    n_frames = check_positive("seconds of a film", seconds, "s") * fps
    if n_frames > MOST_PICTURES:
        raise InputError(
            f"a film of {seconds:g} s with {fps:g} pictures per second has more than "
            f"{MOST_PICTURES} pictures: make it shorter, or take fewer per second"
        )
    n_frames = max(2, round(n_frames))
    rows = _rows(t, n_frames)
    distinct, place = np.unique(rows, return_inverse=True)
    states = trace_scene(outline, read_rows(q, distinct))
    canvas = Canvas(states, None, view, legend=False)
    digits = int(np.clip(np.ceil(-np.log10(np.diff(t[distinct]).max(initial=1e-9))), 0, 12))
    artists: list[Any] = []
    try:
        with writer.saving(canvas.figure, str(target), dpi):
            for k in tqdm(place, unit="picture", leave=False, disable=None if progress else True):
                for artist in artists:
                    artist.remove()
                artists = [*canvas.draw(k, "C0"), *canvas.draw_supports(k)]
                for points in paths:
                    artists += canvas.draw_path(points[: distinct[k] + 1])
                canvas.ax.set_title(f"t = {t[distinct[k]]:.{digits}f} s", fontsize="medium")
                writer.grab_frame()
    finally:
        plt.close(canvas.figure)
    return target


class _Gif(AbstractMovieWriter):
    """Write a GIF in few colours, which all of its pictures share, and which keep it small."""

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        """Begin."""
        super().setup(fig, outfile, dpi)
        self._pictures: list[Image.Image] = []
        self._palette = Image.new("P", (1, 1))
        colours = []
        for colour, count in SHADES.items():
            shades = np.linspace(0.0, 1.0, count)[:, None]
            colours.append(shades + (1.0 - shades) * to_rgb(colour))
        together = np.round(255.0 * np.concatenate(colours)).astype(np.uint8)
        self._palette.putpalette(together.tobytes())

    def grab_frame(self, **savefig_kwargs: Any) -> None:
        """Add a picture."""
        buffer = BytesIO()
        self.fig.savefig(buffer, format="rgba", dpi=self.dpi, **savefig_kwargs)
        whole = Image.frombytes("RGBA", self.frame_size, buffer.getvalue()).convert("RGB")
        self._pictures.append(whole.quantize(palette=self._palette, dither=Image.Dither.NONE))

    def finish(self) -> None:
        """Write the file."""
        first, *rest = self._pictures
        duration = round(1000.0 / self.fps)
        first.save(self.outfile, save_all=True, append_images=rest, duration=duration, loop=0)


def _writer(target: Path, fps: int) -> AbstractMovieWriter:
    """Return what writes a film, by the end of its name."""
    if target.suffix.lower() == ".gif":
        return _Gif(fps=fps)
    if target.suffix.lower() != ".mp4":
        raise InputError(f"a film is a .gif or an .mp4, got {format_value(str(target))}")
    if not FFMpegWriter.isAvailable():
        raise InputError(
            f"{target} needs the program ffmpeg, which is not installed here: install it, on "
            f"Debian with `apt install ffmpeg`, or write a GIF, {str(target.with_suffix('.gif'))!r}"
        )
    return FFMpegWriter(fps=fps)


def _rows(t: Array, n_frames: int) -> NDArray[np.intp]:
    """Return the saved states nearest to instants that are equally far apart."""
    instants = np.linspace(t[0], t[-1], n_frames)
    after = (
        np.clip(np.searchsorted(t, instants), 1, len(t) - 1)
        if len(t) > 1
        else np.zeros(n_frames, int)
    )
    return np.where(instants - t[after - 1] <= t[after] - instants, after - 1, after)
