"""Choice of solver, factorization, memory and threads; deflation spaces are loaded on first use."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.solve.preparation.deflation_space import CoarseModes, slides_of

__all__ = ["CoarseModes", "slides_of"]

__getattr__ = on_demand(
    __name__, {"CoarseModes": "deflation_space", "slides_of": "deflation_space"}
)
