"""Named scenes: in come the element, the mesh and a few numbers, out go the scene and its rod.

Tests, studies, the command line and the README share them, so that a name means one thing.
"""

from ancfsparse.problems.benchmarks import Problem, cantilever, elastica, pendulum, roll_up
from ancfsparse.problems.meshes import MOTIONS, Net, chain, net

__all__ = [
    "MOTIONS",
    "Net",
    "Problem",
    "cantilever",
    "chain",
    "elastica",
    "net",
    "pendulum",
    "roll_up",
]
