"""Static equilibrium: residual, Newton's method, load stepping; loaded on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.statics.assemble import separate_bodies
    from ancfsparse.solve.statics.static_equilibrium import solve_static

__all__ = ["separate_bodies", "solve_static"]

__getattr__ = on_demand(
    __name__, {"assemble": "separate_bodies", "static_equilibrium": "solve_static"}
)
