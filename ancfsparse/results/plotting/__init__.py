"""Pictures and films of solutions by matplotlib and PyVista."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.results.plotting.animation import animate
    from ancfsparse.results.plotting.plot import (
        colours_of,
        draw_shapes,
        nearest_row,
        nearest_rows,
        outline_for,
        plot_equilibrium,
        plot_load_path,
        plot_mode,
        plot_motion,
    )
    from ancfsparse.results.plotting.rendering import render

__all__ = [
    "animate",
    "colours_of",
    "draw_shapes",
    "nearest_row",
    "nearest_rows",
    "outline_for",
    "plot_equilibrium",
    "plot_load_path",
    "plot_mode",
    "plot_motion",
    "render",
]

__getattr__ = on_demand(
    __name__,
    {
        "animation": "animate",
        "plot": "colours_of draw_shapes nearest_row nearest_rows outline_for plot_equilibrium "
        "plot_load_path plot_mode plot_motion",
        "rendering": "render",
    },
)
