"""Runs to a given accuracy, against the same mesh solved with steps too short to count."""

import math
from functools import cache

import numpy as np
import pytest

import ancfsparse as ancf
from tests.beams import build_beam
from tests.solve.error_control.accuracy_problems import (
    MATERIAL,
    SCENES,
    SECTION,
    T_END,
    TIMES,
    cost,
    distance,
    fixed,
    positions,
    swing,
)


@pytest.fixture(scope="module", params=SCENES, ids=lambda make: make.__name__)
def case(request):
    coarse, fine = (fixed(request.param(), dt)[0] for dt in (2.5e-5, 1.25e-5))
    exact = (4 * fine - coarse) / 3
    assert np.abs(fine - exact).max() < 1.5e-7  # and what is extrapolated is far closer
    return request.param, exact


ACCURACIES = 1e-3, 1e-4, 1e-5, 1e-6, 1e-7


@cache
def run_to(make, accuracy):
    return ancf.simulate(make(), T_END, accuracy=accuracy)


@pytest.mark.parametrize("accuracy", ACCURACIES)
def test_the_accuracy_is_met(case, accuracy):
    make, exact = case
    run = run_to(make, accuracy)
    error = distance(positions(run), exact)
    assert len(run.t) == TIMES + 1
    assert run.stats.error <= accuracy
    assert error <= 1.5 * accuracy
    assert error < max(2.5 * run.stats.error, 3e-8)  # what it says is right, as far as is known
    assert 2 <= run.stats.runs <= 8


@pytest.mark.parametrize("frame", ["fixed", "rotating", "auto"])
def test_seeds_in_any_frame_meet_the_accuracy(case, frame):
    make, exact = case
    run = ancf.simulate(make(), T_END, accuracy=1e-4, solver=ancf.ModifiedNewton(seed_frame=frame))
    assert distance(positions(run), exact) <= 1e-4


@pytest.mark.parametrize("accuracy", [1e-4, 1e-6])
def test_an_integrator_that_is_named_is_taken(case, accuracy):
    make, exact = case
    named = [ancf.GeneralizedAlpha(0.8), ancf.HHT(0.1)]
    if make is not swing:
        named += [ancf.CentralDifference(), ancf.RungeKuttaNystrom(4), ancf.RungeKuttaNystrom(8)]
    for integrator in named:
        run = ancf.simulate(make(), T_END, accuracy=accuracy, integrator=integrator)
        assert run.stats.solver.startswith(repr(integrator))
        assert distance(positions(run), exact) <= 1.5 * accuracy


def fixed_runs(make):
    """Motions by fixed steps of methods of the package, and their counts."""
    explicit = [ancf.CentralDifference(), ancf.RungeKuttaNystrom(4), ancf.RungeKuttaNystrom(8)]
    for integrator in explicit if make is not swing else []:
        limit = ancf.stable_step(make(), integrator)
        for finer in (1.05, 1.5, 2.1):
            dt = T_END / TIMES / math.ceil(T_END / TIMES * finer / limit)
            yield fixed(make(), dt, "default", integrator=integrator, max_energy_gain=math.inf)
    # Where multipliers are to be small a fixed tolerance may cost less, so both are tried there.
    for tolerance in ("default", 1e-4) if make is swing else ("default",):
        for dt in (5e-3, 2.5e-3, 1e-3, 5e-4, 2.5e-4, 1e-4, 5e-5, 2.5e-5):
            yield fixed(make(), dt, tolerance, max_energy_gain=math.inf)


def test_its_cost_is_a_small_multiple_of_the_cheapest_way_in_the_package(case):
    make, exact = case
    swept = [(distance(found, exact), cost(stats)) for found, stats in fixed_runs(make)]
    ratios = []
    for accuracy in ACCURACIES:
        run = run_to(make, accuracy)
        least = min((spent for error, spent in swept if error <= accuracy), default=math.inf)
        ratios.append(cost(run.stats) / least)
    # Up to 2.4 where nothing is missed.  A run that misses the accuracy narrowly asks for another
    # one; and under loads that set in smoothly nothing foretells the error, and a pilot is needed.
    assert np.median(ratios) < (3.5 if make.__name__ == "spin_up" else 3.05)
    assert max(ratios) < 4.5


def test_the_other_options_go_together_with_an_accuracy(tmp_path):
    def scene():
        wet = ancf.Material(1e8, 4000.0, axial_damping=1e-4, bending_damping=1e-3)
        scene, rod = build_beam("thin", (0, 0), (2, 0), 6, SECTION, wet, "pin")
        return scene, rod

    first, rod = scene()
    exact = ancf.simulate(first, 0.4, 2e-5, save_every=100).position(rod.end)
    for solver in ("auto", ancf.ModifiedNewton(), ancf.QuasiNewton("broyden", memory=5)):
        body, rod = scene()
        run = ancf.simulate(
            body, 0.4, accuracy=1e-5, solver=solver, save_nodes=[rod.end],
            output=tmp_path / "run.h5",
        )  # fmt: skip
        assert np.abs(run.position(rod.end) - exact).max() < 2e-5
        assert run.stats.error <= 1e-5


def thin_cable():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    material = ancf.Material(4e7, 1500.0)
    cable = scene.add_beam("thin", (0, 0, 0), (1.3, 0, 0), 9, ancf.Circle(0.008), material)
    scene.pin(cable.start)
    scene.point_force(cable.end, lambda t: (0.3 * math.sin(9 * t), 0.2 * math.cos(5 * t), 0.1))
    return scene


def test_a_thin_cable_takes_an_explicit_method_of_high_order():
    exact = ancf.simulate(
        thin_cable(), 1.0, 1.0 / 6000, save_every=30, integrator=ancf.RungeKuttaNystrom(8)
    )
    for accuracy, forces in ((1e-4, 24_000), (1e-6, 24_000), (1e-8, 110_000)):
        run = ancf.simulate(thin_cable(), 1.0, accuracy=accuracy)
        assert run.stats.solver.startswith(("RungeKuttaNystrom", "CentralDifference"))
        assert distance(positions(run), positions(exact)) <= accuracy
        assert cost(run.stats) < forces


@pytest.mark.parametrize("integrator", ["auto", ancf.GeneralizedAlpha(0.9)])
def test_slopes_may_move_where_no_node_can(integrator):
    scene, _ = build_beam("thin", (0, 0), (1, 0), 1, SECTION, MATERIAL, "pin", "pin")
    run = ancf.simulate(scene, 0.1, accuracy=1e-5, integrator=integrator)
    exact = ancf.simulate(scene, 0.1, 1e-5, save_every=50, integrator=ancf.CentralDifference())
    assert np.abs(exact.q - exact.q[0]).max() > 0.01
    assert np.abs(run.q - exact.q).max() < 1e-3
