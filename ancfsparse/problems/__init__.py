"""Named scenes, as functions of the element, the mesh and a few numbers.

They are shared by tests, benchmarks, the command line and the README.
"""

from ancfsparse.problems.belts import belt_drive, belt_drive_pechstein, serpentine, timing_belt
from ancfsparse.problems.benchmarks import Problem, cantilever, elastica, pendulum, roll_up
from ancfsparse.problems.contacts import bristle, capstan, hair, knot
from ancfsparse.problems.flexible import (
    double_pendulum_bob,
    elastic_four_bar,
    elastic_slider_crank,
    moving_supports,
    sliding_bead,
    spaghetti,
    spin_up,
)
from ancfsparse.problems.machines import bend, crane, robot_arm, spring_antenna
from ancfsparse.problems.mechanism import Mechanism
from ancfsparse.problems.mechanisms import (
    andrews,
    bricard,
    dzhanibekov,
    four_bar,
    heavy_top,
    n_four_bar,
    planar_rod,
    slider_crank,
    spatial_pendulum,
)
from ancfsparse.problems.meshes import MOTIONS, Lattice, Net, chain, lattice, net, octet
from ancfsparse.problems.obstacles import (
    cable_drop,
    cantilever_on_cylinders,
    chain_over_pulley,
    net_on_sphere,
    pile,
    sliding_block,
)
from ancfsparse.problems.ropes import cable_car, catenary, hanging_net, mooring

__all__ = [
    "MOTIONS",
    "Lattice",
    "Mechanism",
    "Net",
    "Problem",
    "andrews",
    "belt_drive",
    "belt_drive_pechstein",
    "bend",
    "bricard",
    "bristle",
    "cable_car",
    "cable_drop",
    "cantilever",
    "cantilever_on_cylinders",
    "capstan",
    "catenary",
    "chain",
    "chain_over_pulley",
    "crane",
    "double_pendulum_bob",
    "dzhanibekov",
    "elastic_four_bar",
    "elastic_slider_crank",
    "elastica",
    "four_bar",
    "hair",
    "hanging_net",
    "heavy_top",
    "knot",
    "lattice",
    "mooring",
    "moving_supports",
    "n_four_bar",
    "net",
    "net_on_sphere",
    "octet",
    "pendulum",
    "pile",
    "planar_rod",
    "robot_arm",
    "roll_up",
    "serpentine",
    "slider_crank",
    "sliding_bead",
    "sliding_block",
    "spaghetti",
    "spatial_pendulum",
    "spin_up",
    "spring_antenna",
    "timing_belt",
]
