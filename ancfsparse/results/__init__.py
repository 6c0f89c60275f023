"""What a run leaves: in come saved states and the system that produced them.

Out go positions, reactions, energies and counts by the names a person used in the scene.
Pictures are in `ancfsparse.results.plots`, apart, so that a run does not wait for matplotlib.
"""

from .energy import Energy
from .equilibrium import Equilibrium
from .source import SolvedSystem
from .stats import RunStats
from .trajectory import Trajectory

__all__ = [
    "Energy",
    "Equilibrium",
    "RunStats",
    "SolvedSystem",
    "Trajectory",
]
