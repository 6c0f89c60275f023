"""Results of runs: positions, reactions, energies and counts, from saved states and their system.

Pictures are in `ancfsparse.results.plotting.line_plots` (`snapshots`, `edge_lines`, `centre_line`,
`differences`), apart, so that a run does not wait for matplotlib.
"""

from ancfsparse.results.data.run_statistics import Event, RunStats
from ancfsparse.results.fields.energy_balance import Energy
from ancfsparse.results.solutions.equilibrium import Equilibrium
from ancfsparse.results.solutions.trajectory import Trajectory

__all__ = [
    "Energy",
    "Equilibrium",
    "Event",
    "RunStats",
    "System",
    "Trajectory",
]
