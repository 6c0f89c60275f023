"""Animations of motions, as GIF or MP4."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from io import BytesIO
from itertools import groupby
from pathlib import Path
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.animation import AbstractMovieWriter, FFMpegWriter
from matplotlib.colors import to_rgb
from numpy.typing import NDArray
from PIL import Image
from tqdm import tqdm

from ancfsparse.array_types import Vector
from ancfsparse.checks import check_choice, check_count, check_flag, check_positive
from ancfsparse.errors import InputError
from ancfsparse.file_names import check_target
from ancfsparse.messages import format_value
from ancfsparse.results.geometry.deformed_shape import read_rows
from ancfsparse.results.geometry.scene_outline import Outline
from ancfsparse.results.plotting.canvas import Canvas
from ancfsparse.results.plotting.colours import Colours
from ancfsparse.results.plotting.shaded_scene import ShadedScene
from ancfsparse.results.plotting.traced_scene import trace_scene

MIN_DURATION = 2.0  # s, by default
MAX_DURATION = 10.0  # s, by default
MAX_FRAMES = 90_000  # frames, an hour at 25 frames per second
MAX_DPI = 1200  # pixels per inch
STYLES = "lines", "solid"
SHADES = {"k": 32, "C0": 24, "C1": 16}
"""Colours of a GIF of lines, and number of shades of each up to white."""
MAX_TINT = 246  # smallest component of a colour of surfaces, above which it becomes white
N_SAMPLES = 8  # frames that determine the palette of a GIF of surfaces


def animate(
    outline: Outline,
    t: Vector,
    q: Vector,
    path: str | Path,
    *,
    seconds: float | None = None,
    fps: int = 25,
    dpi: int = 100,
    view: str | tuple[float, float] | None = None,
    style: str = "lines",
    colours: Callable[[NDArray[np.intp]], Colours] | None = None,
    paths: Sequence[Vector] = (),
    progress: bool = True,
) -> Path:
    """Write an animation of coordinates q (k, n) at times t (k,) [s]; see `Trajectory.animate`.

    `colours` evaluates a quantity in some states, and `paths` are the positions (k, dim) of the
    traced points [m].
    """
    target = check_target("an animation", path, (".gif", ".mp4"))
    is_solid = check_choice("style", style, STYLES) == "solid"
    if colours is not None and not is_solid:
        raise InputError("colour is for style='solid': give both")
    writer = _writer(target, check_count("fps", fps), is_solid)
    if check_count("dpi", dpi, 10) > MAX_DPI:
        raise InputError(f"dpi must be at most {MAX_DPI}, got {format_value(dpi)}")
    check_flag("progress", progress)
    duration = float(t[-1] - t[0])
    if seconds is None:
        seconds = min(max(duration, MIN_DURATION), MAX_DURATION)
    n_frames = check_positive("seconds of an animation", seconds, "s") * fps
    if n_frames > MAX_FRAMES:
        raise InputError(
            f"an animation of {seconds:g} s with {fps:g} frames per second has more than "
            f"{MAX_FRAMES} frames: make it shorter, or reduce fps"
        )
    n_frames = max(2, round(n_frames))
    rows = _rows(t, n_frames)
    distinct, place = np.unique(rows, return_inverse=True)
    values = read_rows(q, distinct)
    states = trace_scene(outline, values, t[distinct])
    canvas: Canvas | ShadedScene
    if is_solid:
        canvas = ShadedScene(states, values, view, colours and colours(distinct))
    else:
        canvas = Canvas(states, None, view, legend=False)
    digits = int(np.clip(np.ceil(-np.log10(np.diff(t[distinct]).max(initial=1e-9))), 0, 12))
    artists: list[Any] = []
    try:
        with writer.saving(canvas.figure, str(target), dpi):
            frames = tqdm(place, unit="frame", leave=False, disable=None if progress else True)
            for k, alike in groupby(frames):
                for artist in artists:
                    artist.remove()
                artists = canvas.draw_state(k)
                for points in paths:
                    artists += canvas.draw_path(points[: distinct[k] + 1])
                canvas.set_title(f"t = {t[distinct[k]]:.{digits}f} s")
                for _ in alike:
                    writer.grab_frame()
    finally:
        plt.close(canvas.figure)
    return target


class _Gif(AbstractMovieWriter):
    """Write a small GIF with a common palette, of few colours for lines."""

    def __init__(self, fps: int, is_solid: bool) -> None:
        super().__init__(fps=fps)
        self._is_solid = is_solid

    def setup(self, fig: Any, outfile: Any, dpi: float | None = None) -> None:
        """Create the palette."""
        super().setup(fig, outfile, dpi)
        self._frames: list[Image.Image] = []
        self._palette = Image.new("P", (1, 1))
        colours = []
        for colour, count in SHADES.items():
            shades = np.linspace(0.0, 1.0, count)[:, None]
            colours.append(shades + (1.0 - shades) * to_rgb(colour))
        palette = np.round(255.0 * np.concatenate(colours)).astype(np.uint8)
        self._palette.putpalette(palette.tobytes())

    def grab_frame(self, **savefig_kwargs: Any) -> None:
        """Add a frame, the last one again if the figure has not changed."""
        if self._frames and not self.fig.stale:
            self._frames.append(self._frames[-1])
            return
        buffer = BytesIO()
        self.fig.savefig(buffer, format="rgba", dpi=self.dpi, **savefig_kwargs)
        self.fig.stale = False
        frame = Image.frombytes("RGBA", self.frame_size, buffer.getvalue()).convert("RGB")
        # Surfaces determine their palette at the end.
        self._frames.append(frame if self._is_solid else self._quantize(frame))

    def _quantize(self, frame: Image.Image) -> Image.Image:
        return frame.quantize(palette=self._palette, dither=Image.Dither.NONE)

    def finish(self) -> None:
        """Write the file."""
        if self._is_solid:
            samples = self._frames[:: max(1, len(self._frames) // N_SAMPLES)]
            width, height = self.frame_size
            strip = Image.new("RGB", (width, height * len(samples)))
            for k, frame in enumerate(samples):
                strip.paste(frame, (0, height * k))
            colours = np.array(strip.quantize(256).getpalette(), np.uint8).reshape(-1, 3)
            colours[colours.min(axis=1) > MAX_TINT] = 255  # else the background is not white
            self._palette.putpalette(colours.tobytes())
            self._frames = [self._quantize(frame) for frame in self._frames]
        first, *rest = self._frames
        duration = round(1000.0 / self.fps)
        first.save(self.outfile, save_all=True, append_images=rest, duration=duration, loop=0)


def _writer(target: Path, fps: int, is_solid: bool) -> AbstractMovieWriter:
    """Return the writer for the suffix of a file name."""
    if target.suffix.lower() == ".gif":
        return _Gif(fps, is_solid)
    if not FFMpegWriter.isAvailable():
        raise InputError(
            f"{target} needs the program ffmpeg, which is not installed here: install it, on "
            f"Debian with `apt install ffmpeg`, or write a GIF, {str(target.with_suffix('.gif'))!r}"
        )
    return FFMpegWriter(fps=fps)


def _rows(t: Vector, n_frames: int) -> NDArray[np.intp]:
    """Return the saved states nearest to equally spaced times."""
    times = np.linspace(t[0], t[-1], n_frames)
    after = (
        np.clip(np.searchsorted(t, times), 1, len(t) - 1) if len(t) > 1 else np.zeros(n_frames, int)
    )
    return np.where(times - t[after - 1] <= t[after] - times, after - 1, after)
