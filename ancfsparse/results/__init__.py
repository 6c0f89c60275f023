"""Results of runs: positions, reactions, energies and counts, from saved states and their system.

Pictures are in `ancfsparse.results.plots` (`snapshots`, `edge_lines`, `centre_line`,
`differences`), apart, so that a run does not wait for matplotlib.
"""

from ancfsparse.results.energy import Energy
from ancfsparse.results.equilibrium import Equilibrium
from ancfsparse.results.source import SolvedSystem
from ancfsparse.results.stats import Event, RunStats
from ancfsparse.results.trajectory import Trajectory

__all__ = [
    "Energy",
    "Equilibrium",
    "Event",
    "RunStats",
    "SolvedSystem",
    "Trajectory",
]
