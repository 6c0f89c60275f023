"""Parameter sweeps.

samples  points: grids and Latin hypercube samples
sweep    one run for each point, into one table
ledger   the file of finished points
forks    runs in forked processes
workers  runs on a Dask cluster
"""

from ancfsparse.sweeps.samples import grid, latin_hypercube
from ancfsparse.sweeps.sweep import sweep

__all__ = ["grid", "latin_hypercube", "sweep"]
