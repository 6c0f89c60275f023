"""All named mechanisms with their reference values."""

from functools import partial

from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.problems.belts import belt_drive, belt_drive_pechstein, serpentine, timing_belt
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
from ancfsparse.problems.mechanism import OWN_REFERENCE, Case
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
from ancfsparse.problems.obstacles import (
    cable_drop,
    cantilever_on_cylinders,
    chain_over_pulley,
    net_on_sphere,
    pile,
    sliding_block,
)
from ancfsparse.problems.ropes import cable_car, catenary, hanging_net, mooring

EXUDYN = "Exudyn 1.13.6 on the same element, generalised-alpha 0.95, converged in the step"
REISSNER_ROD = "rod of Reissner as a boundary value problem, by SciPy"
DAMPED = GeneralizedAlpha(0.9)  # for stiff elements

elastic = partial(Case, source=EXUDYN, integrator=DAMPED)
CASES = (
    Case(planar_rod, 1e-3, "end", 2.0, (0.9994654895, -0.0326915167), 1e-8),
    Case(
        spatial_pendulum, 1e-3, "centre", 2.0, (-0.4672929732, -0.1624837349, -0.1331777500), 1e-8
    ),
    Case(
        heavy_top, 1e-4, "centre", 0.2, (0.605550561, 0.598957682, -0.523983027), 1e-7,
        f"data of Exudyn's test heavyTop after Terze (2016); {OWN_REFERENCE}",
    ),
    Case(dzhanibekov, 5e-3, "omega", 10.0, (0.003232663, -4.999998740, -0.002173719), 2e-7),
    Case(four_bar, 1e-3, "A", 1.0, (0.4428171674, -0.8966119318), 1e-7),
    Case(slider_crank, 1e-3, "slider", 1.0, (1.5171638197,), 1e-8),
    Case(
        n_four_bar, 1e-3, "b0", 10.0, (0.328458112, 0.944518538), 1e-4,
        "IFToMM benchmark A02; exact reduction to one coordinate by DOP853 at rtol 1e-12",
    ),
    Case(
        andrews, 1.5e-5, "beta", 0.03, (15.81077119629904,), 1e-7,
        "IVP test set; own integration within 1.5e-9",
    ),
    Case(
        bricard, 2e-3, "p3", 1.0, (0.510501461, -1.649167599, 0.140123115), 1e-7,
        f"IFToMM benchmark A04; {OWN_REFERENCE}",
    ),
    elastic(
        spin_up, 5e-3, "u2", 7.5, (-0.55903,), 5e-4, source=f"Kane and Simo's hub; {EXUDYN}"
    ),
    elastic(elastic_slider_crank, 4e-6, "deflection", 0.010472, (0.005624,), 4e-6),
    elastic(double_pendulum_bob, 1e-3, "bob", 1.0, (-1.247312, -1.562211), 2e-5),
    elastic(elastic_four_bar, 1e-3, "middle", 1.0, (-0.134816, 0.499006), 5e-5),
    elastic(spaghetti, 2e-3, "middle", 5.0, (9.46372, 4.04320), 1e-4),
    elastic(moving_supports, 1e-3, "middle", 0.5, (1.070639, -0.254363), 2e-5),
    elastic(sliding_bead, 1e-3, "bead", 0.5, (0.5995, -0.09880), 3e-4),
    elastic(
        bend, 1e-2, "tip", 0.0, (-23.5605819, -13.6046324, 53.4754780), 5e-3,
        source=f"{REISSNER_ROD}; Bathe and Bolourchi (1979) have 23.5, 13.4, 53.4",
    ),
    elastic(spring_antenna, 1e-3, "height", 0.0, (0.1007484,), 2e-4, source=REISSNER_ROD),
    elastic(robot_arm, 1e-3, "pull", 0.0, (-1.03702898, 3.11648679), 1e-6, source=REISSNER_ROD),
    Case(
        crane, 2e-3, "load", 8.0, (7.04540005, 6.56250984), 2e-6,
        "pendulum of changing length, by DOP853 at rtol 1e-12",
    ),
    elastic(
        catenary, 1e-3, "pull", 0.0, (-37.11463411, 32.21687518), 2e-3,
        source="elastic catenary (Irvine, Cable Structures, 1981)",
    ),
    elastic(
        hanging_net, 1e-3, "middle", 0.0, (2.0, 2.0, -1.76733224), 1e-7,
        source="energy of a truss of bars, minimised by Newton's method",
    ),
    elastic(
        cable_car, 2e-3, "carriage", 0.0, (2.9136011, -2.0541525), 2e-3, source=REISSNER_ROD
    ),
    Case(
        mooring, 2e-2, "fairlead", 0.0, (52430.9,), 60.0,
        "elastic catenary that lies on the seabed in part", GeneralizedAlpha(0.5),
    ),
    Case(
        capstan, 1e-3, "t2", 0.3, (25.66332,), 0.02, "T exp(mu phi) of Euler and Eytelwein",
        GeneralizedAlpha(0.5),
    ),
    Case(
        bristle, 1e-3, "t2", 0.55, (25.66332,), 0.005, "T exp(mu phi) of Euler and Eytelwein",
        GeneralizedAlpha(0.5),
    ),
    Case(
        belt_drive, 1e-4, "tight", 0.3, (251.2362,), 1.2,
        "creep of a belt by Euler and Eytelwein, with centrifugal force", GeneralizedAlpha(0.5),
        {"load": "N m"},
    ),
    Case(
        belt_drive_pechstein, 1e-3, "w2", 2.45, (11.308,), 0.01,
        "creep of a belt by Euler and Eytelwein: 663.2 N, 186.9 N and 11.308 rad/s",
        GeneralizedAlpha(0.5),
    ),
    Case(
        timing_belt, 2e-4, "ratio", 0.3, (2.0,), 2e-3, "ratio of radii", GeneralizedAlpha(0.5),
        {"load": "N m"},
    ),
    Case(
        serpentine, 1e-4, "spans", 0.3, (133.61, 133.61, 200.28, 250.28, 250.28), 2.5,
        "moments of pulleys and arm, and the length of the belt without stress",
        GeneralizedAlpha(0.5), {"alternator": "N m", "pump": "N m"},
    ),
    Case(
        cable_drop, 5e-4, "height", 0.5, (0.3970704,), 5e-6,
        "fall, impact on the pressure p(e) and rebound of a mass, by DOP853 at rtol 1e-12",
    ),
    Case(
        sliding_block, 1e-2, "distance", 1.5, (1.5291692,), 1e-6,
        "v^2 / (2 mu g) of Coulomb is 1.5290520; the integral of regularised friction",
    ),
    Case(
        chain_over_pulley, 1e-3, "force", 0.23, (3.0006029,), 0.03,
        "momentum of an inextensible chain; lift-off after Brun et al. (arXiv 1605.03714)",
        GeneralizedAlpha(0.5),
    ),
    Case(
        net_on_sphere, 4e-3, "force", 2.0, (5.1282856,), 2e-3, "weight of the net",
        GeneralizedAlpha(0.5),
    ),
    Case(
        pile, 2e-3, "force", 0.3, (6.164023,), 1e-4, "weight of the cables", GeneralizedAlpha(0.5)
    ),
    Case(
        knot, 2e-3, "tension", 6.0, (0.8474,), 0.01,
        "own run of twice as many elements; the law of loose knots has 0.50",
        GeneralizedAlpha(0.5),
    ),
    Case(
        hair, 1e-3, "combed", 0.9, (0.012956,), 5e-5, "own run of half the steps",
        GeneralizedAlpha(0.5),
    ),
    elastic(
        cantilever_on_cylinders, 1e-3, "tip", 0.0, (1.8905202, -0.4825640), 2e-4,
        source="rod of Reissner that touches hard cylinders at two points, by shooting; "
        "Exudyn's test has -0.48427 with 8 cables of 4 straight segments and a soft contact",
    ),
)  # fmt: skip
MECHANISMS = {case.make.__name__: case for case in CASES}
"""Mechanisms by name."""
