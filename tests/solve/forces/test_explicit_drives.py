"""Supports that move as prescribed, under explicit integrators."""

from __future__ import annotations

import math
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

import ancfsparse as ancf
from tests.solve.forces import carriers
from tests.solve.forces.carriers import MOVE

pendulum = partial(carriers.pendulum, youngs_modulus=1e5)
T_END = 0.36
NEWTON = ancf.Newton()
SECTION = ancf.Rectangle(0.01, 0.01)
METHODS = [
    (ancf.CentralDifference(), (400, 800, 1600)),
    (ancf.RungeKuttaNystrom(4), (250, 500, 1000)),
    (ancf.RungeKuttaNystrom(8), (30, 45, 60)),
    (ancf.DormandPrince(), (40, 60, 80)),
]


def extrapolated(scene, node, steps):
    """Return where a point comes to by the trapezoidal rule and Richardson, and its error [m]."""
    ends = []
    for n in (steps, 2 * steps, 4 * steps):
        options = {"integrator": ancf.Newmark(0.0), "solver": NEWTON, "save_every": n}
        ends.append(ancf.simulate(scene, T_END, T_END / n, **options).position(node)[-1])
    coarse, fine = ((4.0 * two - one) / 3.0 for one, two in pairwise(ends))
    return fine, np.linalg.norm(fine - coarse)


@pytest.mark.parametrize(("integrator", "counts"), METHODS, ids=lambda x: repr(x))
def test_driven_motions_converge_with_the_order_of_the_method(integrator, counts):
    scene, beam = pendulum()
    fine = ancf.simulate(scene, T_END, T_END / 2000, integrator=ancf.RungeKuttaNystrom(8))
    apart, left = [], []
    for n in counts:
        run = ancf.simulate(scene, T_END, T_END / n, integrator=integrator)
        np.testing.assert_allclose(run.position(beam.start), MOVE(run.t), atol=1e-15)
        np.testing.assert_allclose(run.velocity(beam.start), MOVE.rate(run.t), atol=1e-14)
        np.testing.assert_allclose(run.acceleration(beam.start), MOVE.rate(run.t, 2), atol=1e-12)
        apart.append(np.linalg.norm(run.position(beam.end)[-1] - fine.position(beam.end)[-1]))
        energy, work = run.energy, run.last.memory["watch"]["work"]
        assert work > 1.0
        left.append(abs(energy.total[-1] - energy.total[0] - work))
    ratios = [math.log(fine / coarse) for coarse, fine in pairwise(counts)]
    for errors in (apart, left):
        found = [math.log(a / b) / r for (a, b), r in zip(pairwise(errors), ratios, strict=True)]
        assert found[-1] > integrator.order - 0.5
    assert apart[-1] < 1e-5


def test_the_limit_of_explicit_and_implicit_steps_is_one():
    scene, beam = pendulum()
    run = ancf.simulate(scene, T_END, T_END / 500, integrator=ancf.RungeKuttaNystrom(8))
    expected, error = extrapolated(scene, beam.end, 400)
    assert error < 3e-7
    assert np.linalg.norm(run.position(beam.end)[-1] - expected) < 3.0 * error
    led, other = pendulum(as_constraint=True)
    options = {"integrator": ancf.HHT(0.0), "solver": NEWTON, "save_every": 3600}
    fine = ancf.simulate(led, T_END, 1e-4, **options)
    force, known = run.reaction(beam.start)[-1], fine.reaction(other.start)[-1]
    assert np.linalg.norm(force - known) < 1e-3 * np.linalg.norm(known)


def test_damping_and_multipliers_on_a_driven_node_are_followed():
    scene, beam = pendulum(damping=1e-3)
    swing = scene.add_beam("thin", (0, -1), (1, -1), 3, SECTION, ancf.Material(1e5, 4000.0))
    scene.distance(beam.start, swing.start)
    method, ends, left = ancf.DormandPrince(), [], []
    for n in (200, 400):
        run = ancf.simulate(scene, T_END, T_END / n, integrator=method)
        ends.append(run.position(swing.end)[-1])
        energy, work = run.energy, run.last.memory["watch"]["work"]
        left.append(energy.total[-1] - energy.total[0] - work)
        distance = np.linalg.norm(run.position(swing.start) - run.position(beam.start), axis=1)
        np.testing.assert_allclose(distance, 1.0, atol=1e-9)
    assert np.linalg.norm(ends[1] - ends[0]) < 1e-9
    options = {"integrator": ancf.GeneralizedAlpha(0.9), "solver": NEWTON}
    steps = [ancf.simulate(scene, T_END, T_END / n, **options) for n in (1000, 2000)]
    coarse, fine = (run.position(swing.end)[-1] for run in steps)
    error = np.linalg.norm(fine - coarse) / 3.0
    assert np.linalg.norm(ends[1] - (4.0 * fine - coarse) / 3.0) < error
    # Damping takes the rest.
    lost = run.energy.dissipated[-1]
    assert lost > 1e-4
    assert left[1] == pytest.approx(-lost, rel=1e-3)


@pytest.mark.parametrize(("integrator", "_"), METHODS, ids=lambda x: repr(x))
def test_a_driven_explicit_run_goes_on_bit_for_bit(integrator, _):
    scene, _ = pendulum()
    options = {"integrator": integrator}
    whole = ancf.simulate(scene, 0.4, 1e-3, **options)
    first = ancf.simulate(scene, 0.212, 1e-3, **options)
    second = ancf.simulate(scene, 0.4, 1e-3, start=first.last, **options)
    for name in ("t", "q", "v", "a", "lam"):
        np.testing.assert_array_equal(getattr(second, name), getattr(whole, name)[212:])
    memories = [each.last.memory["watch"]["work"] for each in (second, whole)]
    assert memories[0] == memories[1]


def test_loads_and_drives_share_their_rows():
    scene, beam = pendulum()
    scene.point_force(beam.end, lambda t: (0.0, math.sin(20.0 * t)))
    run = ancf.simulate(scene, T_END, T_END / 500, integrator=ancf.RungeKuttaNystrom(4))
    expected, error = extrapolated(scene, beam.end, 400)
    assert np.linalg.norm(run.position(beam.end)[-1] - expected) < 3.0 * error + 1e-8


@pytest.mark.parametrize(
    ("integrator", "name"),
    [
        ("auto", "RungeKuttaNystrom"),
        (ancf.RungeKuttaNystrom(4), "RungeKuttaNystrom"),
        (ancf.DormandPrince(), "DormandPrince"),
    ],
)
def test_an_accuracy_is_met_with_a_drive(integrator, name):
    scene, beam = pendulum()
    run = ancf.simulate(scene, T_END, accuracy=1e-7, integrator=integrator)
    fine = ancf.simulate(scene, T_END, T_END / 2000, integrator=ancf.RungeKuttaNystrom(8))
    apart = np.linalg.norm(run.position(beam.end)[-1] - fine.position(beam.end)[-1])
    assert apart < 1.5e-7
    assert name in run.stats.solver


@pytest.mark.parametrize("integrator", [ancf.CentralDifference(), ancf.DormandPrince()])
def test_drives_by_multipliers_are_those_by_numbering(integrator):
    ends = []
    for as_constraint in (True, False):
        scene, rod = pendulum(as_constraint=as_constraint)
        run = ancf.simulate(scene, 0.1, 1e-4, integrator=integrator)
        ends.append(run.position(rod.end)[-1])
        off = run.energy.total - run.energy.work
        assert np.ptp(off) < 1e-5 * np.max(run.energy.kinetic)
    np.testing.assert_allclose(*ends, rtol=0, atol=1e-8)
