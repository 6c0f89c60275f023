"""Solutions as returned to the user: motions, equilibria, vibration modes, buckling loads."""

from typing import TYPE_CHECKING

from ancfsparse.on_demand import on_demand

if TYPE_CHECKING:
    from ancfsparse.results.solutions.assembly import Assembly
    from ancfsparse.results.solutions.buckling import Buckling
    from ancfsparse.results.solutions.complex_modes import ComplexModes
    from ancfsparse.results.solutions.load_path import LoadPath
    from ancfsparse.results.solutions.modes import Modes

__all__ = ["Assembly", "Buckling", "ComplexModes", "LoadPath", "Modes"]

__getattr__ = on_demand(
    __name__,
    {
        "assembly": "Assembly",
        "buckling": "Buckling",
        "complex_modes": "ComplexModes",
        "load_path": "LoadPath",
        "modes": "Modes",
    },
)
