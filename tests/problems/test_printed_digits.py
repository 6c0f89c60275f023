"""Rigid benchmarks to the digits that two independent formulations print, by an explicit method.

Natural coordinates, and minimal coordinates or Euler's equations, by DOP853 at rtol 1e-12, agree to
1e-8 in all of these; the squeezer has the published values of the IVP test set, the row of four-bar
linkages is IFToMM's A02, Bricard's mechanism A04.
"""

import warnings

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import ancfsparse as ancf
from ancfsparse.problems import (
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
from ancfsparse.problems.mechanism import GRAVITY, upper_intersection
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System

# Scene, step [s], tolerance, and by time [s] the printed values of quantities.
PRINTED = {
    "planar_rod": (
        planar_rod, 2e-3, 1e-8,
        {
            0.5: {"end": (-0.0902292086, -0.9959210259)},
            1.0: {"end": (-0.9999665881, -0.0081745177)},
            2.0: {"end": (0.9994654895, -0.0326915167)},
        },
    ),
    "spatial_pendulum": (
        spatial_pendulum, 2e-3, 1e-8,
        {
            0.5: {"centre": (-0.3588445982, -0.1132165865, -0.3477248322)},
            2.0: {"centre": (-0.4672929732, -0.1624837349, -0.1331777500)},
        },
    ),
    "heavy_top nutating": (
        heavy_top, 5e-4, 1e-8,
        {
            0.2: {"centre": (0.605550561, 0.598957682, -0.523983027)},
            1.0: {"centre": (0.173343964, 0.640088592, -0.748490791)},
        },
    ),
    "heavy_top with cusps": (
        lambda: heavy_top((0.0, 150.0, 0.0)), 5e-4, 1e-8,
        {1.0: {"centre": (-0.986874176, -0.161483504, -0.001561870)}},
    ),
    "dzhanibekov": (
        dzhanibekov, 1e-2, 1e-7,
        {10.0: {"omega": (0.003232663, -4.999998740, -0.002173719)}},
    ),
    "four_bar": (
        four_bar, 2e-3, 1e-8,
        {
            0.5: {"A": (-0.5090881878, 0.8607143644), "B": (1.2594844273, 1.7946045640)},
            1.0: {"A": (0.4428171674, -0.8966119318), "B": (0.7454853091, 1.0803534184)},
            5.0: {"A": (0.667903517, 0.744247870)},
        },
    ),
    "slider_crank": (
        slider_crank, 2e-3, 1e-8,
        {
            0.5: {"pin": (0.9837273619, 0.1796676859), "slider": 2.9756408949},
            1.0: {"slider": 1.5171638197},
            5.0: {"slider": 1.158692438},
        },
    ),
    "n_four_bar 2": (n_four_bar, 2e-2, 1e-8, {10.0: {"b0": (0.328458112, 0.944518538)}}),
    "andrews": (
        andrews, 2e-5, 1e-7,
        {
            0.03: {
                "beta": 15.81077119629904,
                "theta": -15.75637105984298,
                "gamma": 0.04082224013073,
                "phi": -0.53473011632269,
                "delta": 0.52440996588053,
                "omega": 0.53473011632269,
                "epsilon": 1.04808074104226,
            }
        },
    ),
    "bricard": (
        bricard, 5e-3, 1e-7,
        {
            0.5: {"p3": (0.968283679, -1.224625159, 0.750146609)},
            1.0: {"p3": (0.510501461, -1.649167599, 0.140123115)},
            5.0: {"p3": (0.9999999976, -1.0000672576, 0.9999327399)},
        },
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", PRINTED)
def test_all_printed_positions(name):
    make, dt, tolerance, printed = PRINTED[name]
    problem = make()
    found = problem.quantities(exactly(problem, max(printed), dt))
    for time, values in printed.items():
        at = round(time / dt)
        for quantity, value in values.items():
            np.testing.assert_allclose(found[quantity][at], value, rtol=0.0, atol=tolerance)


def exactly(problem, t_end, dt):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ancf.RedundantConstraintsWarning)
        return ancf.simulate(problem.scene, t_end, dt, integrator=ancf.DormandPrince())


def root(t, x, near):
    """Return where a spline through values is zero next to a time."""
    roots = CubicSpline(t, x).roots(extrapolate=False)
    return roots[np.argmin(np.abs(roots - near))]


def test_the_rod_at_the_bottom_and_after_a_period():
    """4 sqrt(2 L / 3 g) K(sin 45 deg); sqrt(3 g / L) and 5/2 m g at the bottom."""
    period, problem = 1.9333348544, planar_rod()
    rod = problem.bodies["rod"]
    run = exactly(problem, period, period / 1000)
    np.testing.assert_allclose(run.position(rod.end)[-1], (1.0, 0.0), atol=1e-8)
    motion = run.body(rod)
    assert motion.angular_velocity[250] == pytest.approx(-np.sqrt(3.0 * GRAVITY), rel=1e-8)
    np.testing.assert_allclose(run.reaction(rod.origin)[250], (0.0, 2.5 * GRAVITY), atol=1e-6)


def test_the_energy_of_the_spatial_pendulum_and_the_top():
    problem = spatial_pendulum()
    run = exactly(problem, 2.0, 2e-3)
    motion = run.body(problem.bodies["box"])
    energy = motion.kinetic_energy + 2.0 * GRAVITY * motion.centre[:, 2]
    np.testing.assert_allclose(energy, 5.0543333333, rtol=0.0, atol=1e-9)
    run = exactly(heavy_top(), 0.2, 5e-4)
    np.testing.assert_allclose(run.energy.total, 5435.69679087, rtol=0.0, atol=1e-6)
    spin = run.body(run.system.bodies[0])
    np.testing.assert_allclose(spin.angular_velocity_in_body[:, 1], 150.0, rtol=1e-11)


@pytest.mark.parametrize(
    ("tilt", "rate"), [(60.0, 3.105309341), (60.0, 6.418500183), (90.0, 2.0928)]
)
def test_steady_precession(tilt, rate):
    """(A - C) cos(theta) W^2 - C n W + m g l = 0: slow, fast and level; the tilt stays."""
    up = np.radians(90.0 - tilt)
    turn = np.array([[1, 0, 0], [0, np.cos(up), -np.sin(up)], [0, np.sin(up), np.cos(up)]])
    if tilt == 90.0:
        rate = 15.0 * GRAVITY / (0.46875 * 150.0)  # 2.0928, which the page has to five digits
        assert rate == pytest.approx(2.0928, abs=5e-5)
    omega = rate * np.array([0.0, 0.0, 1.0]) + 150.0 * turn[:, 1]
    off = []
    for dt in (2e-4, 1e-4):
        scene = ancf.Scene((0.0, 0.0, -GRAVITY))
        disc = scene.add_body(
            inertia=(0.234375, 0.46875, 0.234375), mass=15.0, centre=(0, 1, 0),
            position=(0, 0, 0), orientation=turn, angular_velocity=omega,
        )  # fmt: skip
        scene.pin(disc.origin)
        run = ancf.simulate(
            scene, 0.2, dt, integrator=ancf.EnergyMomentum(), tolerance=1e-12, save_every=10
        )
        height = run.body(disc).centre[:, 2]
        off.append(np.abs(np.arcsin(height) - up).max())
    assert off[1] < 1e-6
    assert 3.8 < off[0] / off[1] < 4.2


def test_flips_of_the_top_to_the_digits_of_elliptic_functions():
    run = exactly(dzhanibekov(), 17.0, 5e-3)
    motion = run.body(run.system.bodies[0])
    spin = motion.angular_velocity_in_body[:, 1]
    assert root(run.t, spin, 5.5) == pytest.approx(5.520889721, abs=1e-7)
    assert root(run.t, spin, 16.5) == pytest.approx(16.562669171, abs=1e-5)
    np.testing.assert_allclose(motion.kinetic_energy, 37.500001, rtol=1e-10)
    np.testing.assert_allclose(
        motion.angular_momentum, [[0.002, 15.0, 0.0]] * len(run.t), atol=1e-9
    )


def test_the_four_bar_linkage_closes():
    """B where the crank stands at 180 and at 90 degrees."""
    closed = upper_intersection(np.array([-1.0, 0.0]), 2.0, np.array([3.0, 0.0]), 2.5)
    np.testing.assert_allclose(closed, (0.71875, 1.0226917607), atol=1e-10)
    run = exactly(four_bar(), 2e-3, 2e-3)
    b = run.position(run.system.bodies[1].end)[0]
    np.testing.assert_allclose(b, (1.6623437256, 2.1120311767), atol=1e-10)


@pytest.mark.parametrize(
    ("n", "level", "turn"), [(2, 0.714355529, 1.942514923), (40, 0.721581025, 1.965601929)]
)
def test_when_a_row_of_linkages_turns_over(n, level, turn):
    run = exactly(n_four_bar(n), 2.0, 1e-2)
    angle = run.body(run.system.bodies[0]).angles - 0.5 * np.pi
    assert root(run.t, angle + 0.5 * np.pi, level) == pytest.approx(level, abs=1e-7)
    assert root(run.t, angle + 2.0 * np.pi, turn) == pytest.approx(turn, abs=1e-6)


def test_a_row_of_forty_linkages_to_all_digits():
    """Ten passages of singular places, where how close a stage comes decides on the digits."""
    errors = []
    for steps in (250, 320, 400):
        run = exactly(n_four_bar(40), 10.0, 10.0 / steps)
        place = run.position(run.system.bodies[41].origin)[-1]
        errors.append(np.abs(place - (0.180512227, 0.983572741)).max())
    assert np.median(errors) < 1e-8
    assert max(errors) < 1e-7


def test_a_row_of_a_thousand_linkages_at_linear_cost():
    """Work of a factorisation and corrections a step, for 40 and for 1000."""
    work, steps = [], []
    for n in (40, 1000):
        problem = n_four_bar(n)
        system = System(problem.scene)
        seed = SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
        work.append(seed.factor_flops / n)
        run = ancf.simulate(problem.scene, 0.05, 1e-3, solver=ancf.ModifiedNewton())
        steps.append(run.stats.iterations / run.stats.steps)
    assert work[1] < 1.2 * work[0]
    assert steps[1] < 1.2 * steps[0]


@pytest.mark.parametrize(
    ("make", "quantity", "t_end", "dt"),
    [
        (heavy_top, "centre", 0.2, 4e-4),
        (four_bar, "A", 1.0, 4e-3),
        (slider_crank, "slider", 1.0, 4e-3),
        (n_four_bar, "b0", 0.6, 4e-3),
        (andrews, "beta", 0.015, 3e-5),
    ],
    ids=["heavy_top", "four_bar", "slider_crank", "n_four_bar", "andrews"],
)
def test_the_energy_momentum_method_is_of_second_order(make, quantity, t_end, dt):
    def end(step, integrator, **options):
        problem = make()
        run = ancf.simulate(problem.scene, t_end, step, integrator=integrator, **options)
        return problem.quantities(run)[quantity][-1]

    exact = end(0.25 * dt, ancf.DormandPrince())
    off = [
        np.max(np.abs(end(step, ancf.EnergyMomentum(), tolerance=1e-12) - exact))
        for step in (dt, 0.5 * dt)
    ]
    assert 3.7 < off[0] / off[1] < 4.3
