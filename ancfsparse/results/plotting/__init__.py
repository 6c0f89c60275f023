"""Pictures and films of solutions by matplotlib and PyVista."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.results.plotting.animation import animate
    from ancfsparse.results.plotting.plot import (
        draw_shapes,
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
    "draw_shapes",
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
        "animate": "animation",
        "draw_shapes": "plot",
        "nearest_rows": "plot",
        "outline_for": "plot",
        "plot_equilibrium": "plot",
        "plot_load_path": "plot",
        "plot_mode": "plot",
        "plot_motion": "plot",
        "render": "rendering",
    },
)
