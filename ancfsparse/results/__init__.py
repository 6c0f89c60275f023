"""What a run leaves: in come saved states and the system that produced them.

Out go positions, reactions, energies and counts by the names a person used in the scene.
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
