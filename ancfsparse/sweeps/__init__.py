"""Many independent runs: points, workers, the file of results."""

from ancfsparse.sweeps.samples import grid, latin_hypercube
from ancfsparse.sweeps.sweep import sweep

__all__ = ["grid", "latin_hypercube", "sweep"]
