"""All named mechanisms, with the number that each is known by."""

from ancfsparse.integrators import GeneralizedAlpha
from ancfsparse.problems.flexible import (
    double_pendulum_bob,
    elastic_four_bar,
    elastic_slider_crank,
    moving_supports,
    spaghetti,
    spin_up,
)
from ancfsparse.problems.linkages import andrews, four_bar, n_four_bar, slider_crank
from ancfsparse.problems.mechanism import OWN, Case
from ancfsparse.problems.mechanisms import (
    bricard,
    dzhanibekov,
    heavy_top,
    planar_rod,
    spatial_pendulum,
)
from ancfsparse.problems.sliding import sliding_bead

EXUDYN = "Exudyn 1.13.6 on the same element, generalised-alpha 0.95, converged in the step"
DAMPED = GeneralizedAlpha(0.9)

MECHANISMS = {
    "planar_rod": Case(planar_rod, 1e-3, "end", 2.0, (0.9994654895, -0.0326915167), 1e-8, OWN),
    "spatial_pendulum": Case(
        spatial_pendulum, 1e-3, "centre", 2.0, (-0.4672929732, -0.1624837349, -0.1331777500), 1e-8
    ),
    "heavy_top": Case(
        heavy_top,
        1e-4,
        "centre",
        0.2,
        (0.605550561, 0.598957682, -0.523983027),
        1e-7,
        f"data of Exudyn's test heavyTop after Terze (2016); {OWN}",
        {"omega": ((0.0, 150.0, -4.61538), "rad/s")},
    ),
    "dzhanibekov": Case(
        dzhanibekov, 5e-3, "omega", 10.0, (0.003232663, -4.999998740, -0.002173719), 2e-7
    ),
    "four_bar": Case(four_bar, 1e-3, "A", 1.0, (0.4428171674, -0.8966119318), 1e-7),
    "slider_crank": Case(slider_crank, 1e-3, "slider", 1.0, (1.5171638197,), 1e-8),
    "n_four_bar": Case(
        n_four_bar,
        1e-3,
        "b0",
        10.0,
        (0.328458112, 0.944518538),
        1e-4,
        "IFToMM benchmark A02; exact reduction to one coordinate by DOP853 at rtol 1e-12",
        {"n": (2, "")},
    ),
    "andrews": Case(
        andrews,
        1.5e-5,
        "beta",
        0.03,
        (15.81077119629904,),
        1e-7,
        "IVP test set; own integration within 1.5e-9",
    ),
    "bricard": Case(
        bricard,
        2e-3,
        "p3",
        1.0,
        (0.510501461, -1.649167599, 0.140123115),
        1e-7,
        f"IFToMM benchmark A04; {OWN}",
    ),
    "spin_up": Case(
        spin_up,
        5e-3,
        "u2",
        7.5,
        (-0.55903,),
        5e-4,
        f"Kane and Simo's hub; {EXUDYN}",
        {"n_elements": (16, "")},
        DAMPED,
    ),
    "elastic_slider_crank": Case(
        elastic_slider_crank,
        4e-6,
        "deflection",
        0.010472,
        (0.005624,),
        4e-6,
        EXUDYN,
        {"n_elements": (16, "")},
        DAMPED,
    ),
    "double_pendulum_bob": Case(
        double_pendulum_bob,
        1e-3,
        "bob",
        1.0,
        (-1.247312, -1.562211),
        2e-5,
        EXUDYN,
        {"n_elements": (16, "")},
        DAMPED,
    ),
    "elastic_four_bar": Case(
        elastic_four_bar,
        1e-3,
        "middle",
        1.0,
        (-0.134816, 0.499006),
        5e-5,
        EXUDYN,
        {"n_elements": (16, "")},
        DAMPED,
    ),
    "spaghetti": Case(
        spaghetti,
        2e-3,
        "middle",
        5.0,
        (9.46372, 4.04320),
        1e-4,
        EXUDYN,
        {"n_elements": (32, "")},
        DAMPED,
    ),
    "moving_supports": Case(
        moving_supports,
        1e-3,
        "middle",
        0.5,
        (1.070639, -0.254363),
        2e-5,
        EXUDYN,
        {"n_elements": (16, "")},
        DAMPED,
    ),
    "sliding_bead": Case(
        sliding_bead,
        1e-3,
        "bead",
        0.5,
        (0.5995, -0.09880),
        3e-4,
        EXUDYN,
        {"n_elements": (32, "")},
        DAMPED,
    ),
}
"""Mechanisms by name."""
