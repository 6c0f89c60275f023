"""Choice of solver, factorization, memory and threads; deflation spaces are loaded on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.preparation.deflation_space import DeflationModes, sliding_points

__all__ = ["DeflationModes", "sliding_points"]

__getattr__ = on_demand(__name__, {"deflation_space": "DeflationModes sliding_points"})
