"""Solutions and what follows from them: positions, reactions, energies, plots and files.

A solution is stored or plotted by modules that are loaded on first use, so that a run does not wait
for HDF5 and matplotlib:

    data       statistics of a run, HDF5 format, tables of states in memory or in a file
    fields     energy balance, section and joint forces, motion of rigid bodies
    geometry   outlines of the bodies of a scene
    plotting   plots and films by matplotlib and PyVista
    export     files: HDF5, VTKHDF, CSV, tables, reports
    solutions  Trajectory, Equilibrium, Modes, ... as returned to the user
"""

from ancfsparse.results.data.run_statistics import Event, RunStats
from ancfsparse.results.solutions.equilibrium import Equilibrium
from ancfsparse.results.solutions.trajectory import Trajectory

__all__ = ["Equilibrium", "Event", "RunStats", "Trajectory"]
