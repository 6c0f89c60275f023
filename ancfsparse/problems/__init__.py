"""Named scenes: in come the element, the mesh and a few numbers, out go the scene and its rod.

Tests, studies, the command line and the README share them, so that a name means one thing.
"""

from ancfsparse.problems.benchmarks import Problem, cantilever, elastica, pendulum, roll_up
from ancfsparse.problems.meshes import MOTIONS, Lattice, Net, chain, lattice, net, octet

__all__ = [
    "MOTIONS",
    "Lattice",
    "Net",
    "Problem",
    "cantilever",
    "chain",
    "elastica",
    "lattice",
    "net",
    "octet",
    "pendulum",
    "roll_up",
]
