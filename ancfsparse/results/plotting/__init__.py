"""Pictures and films of solutions by matplotlib and PyVista."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.results.plotting.animation import animate as animate
    from ancfsparse.results.plotting.plot import (
        colours_of as colours_of,
        draw_shapes as draw_shapes,
        nearest_row as nearest_row,
        nearest_rows as nearest_rows,
        outline_for as outline_for,
        plot_equilibrium as plot_equilibrium,
        plot_load_path as plot_load_path,
        plot_mode as plot_mode,
        plot_motion as plot_motion,
    )
    from ancfsparse.results.plotting.rendering import render as render

__getattr__ = on_demand(
    __name__,
    {
        "animation": "animate",
        "plot": "colours_of draw_shapes nearest_row nearest_rows outline_for plot_equilibrium "
        "plot_load_path plot_mode plot_motion",
        "rendering": "render",
    },
)
