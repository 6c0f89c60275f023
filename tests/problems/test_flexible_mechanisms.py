"""Mechanisms of cables agree with Exudyn 1.13.6, which computed these numbers on the same element.

Its tolerance is what its last two halvings of the step left, or its mesh.
"""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import (
    double_pendulum_bob,
    elastic_four_bar,
    elastic_slider_crank,
    moving_supports,
    sliding_bead,
    spaghetti,
    spin_up,
)
from ancfsparse.system import System

REFERENCES = {
    double_pendulum_bob: (
        {
            0.5: {"hinge": (0.606758, -0.793606), "bob": (1.520832, -1.230192)},
            1.0: {"hinge": (-0.754918, -0.659495), "bob": (-1.247312, -1.562211)},
        },
        2e-5,
    ),
    elastic_four_bar: (
        {
            0.5: {"middle": (1.229302, 0.973725), "B": (1.437986, 1.951951)},
            1.0: {"middle": (-0.134816, 0.499006), "B": (0.717634, 1.020199)},
            2.0: {"middle": (-0.140638, 0.509136), "B": (0.717813, 1.020598)},
        },
        5e-5,
    ),
    moving_supports: (
        {
            0.25: {"middle": (1.018778, -0.359483)},
            0.5: {"middle": (1.070639, -0.254363)},
            1.0: {"middle": (1.066856, -0.273626)},
        },
        2e-5,
    ),
    sliding_bead: (
        {
            0.25: {"bead": (0.52439, -0.03514)},
            0.5: {"bead": (0.5995, -0.09880), "middle": (0.99904, -0.10603)},
        },
        3e-4,
    ),
    spaghetti: (
        {
            2.5: {"a": (1.40507, 0.60846), "middle": (5.18622, 3.85563), "b": (8.06812, 7.95037)},
            5.0: {"a": (12.44472, 8.06499), "middle": (9.46372, 4.0432), "b": (6.81114, -0.20908)},
        },
        1e-4,
    ),
}


def momenta_of(scene, run):
    """Return momentum (k, 2) and angular momentum about the origin (k, 1) of a planar scene."""
    system = System(scene)
    q, v = run.q, run.v
    moved = np.array([system.assembly.inertia(each) for each in v])
    linear, angular = np.zeros((len(q), 2)), np.zeros((len(q), 1))
    for places, kind in zip(system.places, system.kinds, strict=True):
        for name in kind.vectors:
            x, y = places[:, kind.columns(name)].T
            angular[:, 0] += (q[:, x] * moved[:, y] - q[:, y] * moved[:, x]).sum(axis=1)
            if name == "r":
                linear += np.stack([moved[:, x].sum(axis=1), moved[:, y].sum(axis=1)], axis=1)
    return linear, angular


def run_of(problem, t_end, dt, **options):
    start = ancf.solve_static(problem.scene) if problem.settles else None
    return ancf.simulate(problem.scene, t_end, dt, start=start, **options)


# At 10 s the errors of the spaghetti have grown.
END = {"a": (19.91459, 8.78429), "middle": (18.72321, 3.92831), "b": (16.49188, -0.54390)}


@pytest.mark.parametrize(
    ("make", "dt", "references", "tolerance"),
    [
        *((make, 5e-4, *row) for make, row in REFERENCES.items()),
        (spaghetti, 1e-3, {10.0: END}, 3e-4),
    ],
)
def test_positions(make, dt, references, tolerance):
    problem = make()
    run = run_of(problem, max(references), dt)
    found = problem.quantities(run)
    for time, values in references.items():
        at = round(time / dt)
        for name, value in values.items():
            np.testing.assert_allclose(found[name][at], value, rtol=0.0, atol=tolerance)


def test_spaghetti_keeps_energy_and_momentum_in_free_flight():
    problem = spaghetti(16)
    run = run_of(problem, 5.0, 5e-3, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    free = run.t > 2.7501
    energy = run.energy.total[free]
    assert np.ptp(energy) < 1e-9 * energy[0]
    for each in momenta_of(problem.scene, run):
        assert np.ptp(each[free], axis=0).max() < 1e-9 * np.abs(each[free]).max()


def test_pull_of_moving_supports():
    """Statics: 4.946068 and 4.316400 N, -0.4036411 m; then the pull at the moving end."""
    problem = moving_supports()
    rope, rest = problem.bodies["rope"], ancf.solve_static(problem.scene)
    np.testing.assert_allclose(rest.reaction(rope.end), (4.946068, 4.316400), atol=2e-5)
    np.testing.assert_allclose(rest.position(rope.at(1.1)), (1.0, -0.4036411), atol=1e-6)
    run = ancf.simulate(problem.scene, 0.5, 5e-4, start=rest)
    pull = problem.quantities(run)["pull"]
    np.testing.assert_allclose(pull[500], (8.331, 4.125), rtol=0.01)
    np.testing.assert_allclose(pull[1000], (5.333, 2.584), rtol=0.01)


def test_deflection_of_the_connecting_rod():
    """Over a quarter, a half and three quarters of a turn, and the extremes of two turns."""
    problem = elastic_slider_crank()
    turn = 2.0 * np.pi / 150.0
    found = problem.quantities(run_of(problem, 2.0 * turn, turn / 12000))
    deflection, angle = found["deflection"], found["crank_angle"]
    np.testing.assert_allclose(
        deflection[[3000, 6000, 9000]], (0.005624, 0.003030, -0.007591), rtol=0.0, atol=4e-6
    )
    largest, least = int(np.argmax(deflection)), int(np.argmin(deflection))
    assert deflection[largest] == pytest.approx(0.0153895, abs=4e-6)
    assert deflection[least] == pytest.approx(-0.015529, abs=4e-6)
    np.testing.assert_allclose(angle[[largest, least]], (46.8, 671.4), rtol=0.0, atol=0.2)


def test_spin_up():
    """The lag, the shortening, and the stretch in steady rotation, tan(a L) / a - L."""
    problem = spin_up(16)
    run = run_of(problem, 20.0, 5e-3)
    found = problem.quantities(run)
    u1, u2 = found["u1"], found["u2"]
    assert u2.min() == pytest.approx(-0.57378, abs=5e-4)
    assert run.t[np.argmin(u2)] == pytest.approx(6.76, abs=0.02)
    assert u1.min() == pytest.approx(-0.01882, abs=2e-5)
    np.testing.assert_allclose(u2[[1000, 1500]], (-0.46844, -0.55903), rtol=0.0, atol=5e-4)
    a = 6.0 * np.sqrt(1.2 / 2.8e7)
    stretch = np.tan(10.0 * a) / a - 10.0
    assert stretch == pytest.approx(5.143175e-4, rel=1e-6)
    assert u1[run.t >= 15.0].mean() == pytest.approx(stretch, rel=0.01)
    assert np.ptp(u2[run.t >= 15.0]) / 2.0 == pytest.approx(3.64e-3, rel=0.02)
