"""Mechanisms pass places where their constraints depend on one another, or say that they cannot."""

import itertools

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from ancfsparse.problems import andrews, bricard, four_bar, n_four_bar
from ancfsparse.scene.bodies.rigid_shapes import Rod
from ancfsparse.solve.initial_conditions.redundant_constraints import (
    count_near_dependent,
    find_redundant_constraints,
)
from ancfsparse.system import System

DEPENDENT = pytest.mark.filterwarnings("ignore::ancfsparse.RedundantConstraintsWarning")
B0 = {2: (0.328458112, 0.944518538), 40: (0.180512227, 0.983572741)}  # after 10 s, for n [m]


@pytest.mark.parametrize("n", B0)
@pytest.mark.parametrize("tolerance", ["default", 1e-12])
def test_four_bars_in_a_row(n, tolerance):
    """Through ten seconds and ten places of lost rank; b0 by the exact reduction (IFToMM A02)."""
    problem = n_four_bar(n)
    with pytest.warns(ancf.RedundantConstraintsWarning, match="constraints became dependent"):
        run = ancf.simulate(
            problem.scene, 10.0, 2e-3, integrator=ancf.EnergyMomentum(), tolerance=tolerance,
            solver=ancf.ModifiedNewton(),
        )  # fmt: skip
    energy = run.energy.total
    assert np.abs(energy - energy[0]).max() < 1e-4 * energy[0]
    np.testing.assert_allclose(
        run.position(problem.bodies["coupler 0"].origin)[-1], B0[n], atol=2e-4
    )
    softer = [event for event in run.stats.events if event.rung == "softer constraints"]
    assert 1 <= len(softer) <= 40
    # All uprights go on together: none of them turned back.
    angles = np.array([run.body(problem.bodies[f"upright {k}"]).angles for k in range(n + 1)])
    assert np.abs(angles - angles[0]).max() < 1e-3


@DEPENDENT
def test_a_dense_inverse_passes_with_less_help():
    """Secant pairs from before such a place: 0 to 2 steps with softer constraints, not 3 to 17."""
    problem = n_four_bar(2)
    run = ancf.simulate(problem.scene, 10.0, 2e-3, integrator=ancf.EnergyMomentum())
    assert "davidon" in run.stats.solver
    energy = run.energy.total
    assert np.abs(energy - energy[0]).max() < 1e-5 * energy[0]
    b0 = run.position(problem.bodies["coupler 0"].origin)[-1]
    np.testing.assert_allclose(b0, B0[2], atol=2e-4)
    assert len([event for event in run.stats.events if event.rung == "softer constraints"]) <= 2


@DEPENDENT
def test_other_schemes_pass_too():
    problem = n_four_bar(2)
    run = ancf.simulate(problem.scene, 10.0, 1e-3, integrator=ancf.GeneralizedAlpha(0.9))
    b0 = run.position(problem.bodies["coupler 0"].origin)[-1]
    np.testing.assert_allclose(b0, B0[2], atol=1e-3)


def exact_b0(n, t):
    """Return the end of the first upright: theta'' = k sin(theta), one coordinate (A02)."""
    k = 9.81 * ((n + 1) / 2 + n) / ((n + 1) / 3 + n)
    found = solve_ivp(
        lambda _, y: [y[1], k * np.sin(y[0])], (0.0, t[-1]), [0.0, 1.0],
        method="DOP853", rtol=1e-13, atol=1e-13, t_eval=t,
    )  # fmt: skip
    return np.stack([np.sin(found.y[0]), np.cos(found.y[0])], axis=1)


@pytest.mark.parametrize(
    ("n", "t_end", "accuracy"), [(1, 10.0, 1e-7), (5, 2.0, 1e-7), (2, 2.0, 1e-5)]
)
def test_estimated_errors_hold_past_such_a_place(n, t_end, accuracy):
    """They were up to 19 times too small in the first two, without a word."""
    problem = n_four_bar(n)
    with pytest.warns(
        ancf.RedundantConstraintsWarning, match="explicit methods lose their order"
    ) as seen:
        run = ancf.simulate(problem.scene, t_end, accuracy=accuracy)
    error = np.abs(problem.quantities(run)["b0"] - exact_b0(n, run.t)).max()
    assert error < run.stats.error < accuracy
    # The bars first lie in one line 0.70 to 0.72 s after the start.
    time = float(str(seen[0].message).split("t = ")[1].split(" s")[0])
    assert time == pytest.approx(0.71, abs=0.02)


@pytest.mark.slow
def test_an_error_that_is_not_known_is_refused_with_the_reason():
    """Errors of 1e-7 m were claimed, and were 7.7e-6 m."""
    problem = n_four_bar(2)
    with (
        pytest.warns(ancf.RedundantConstraintsWarning, match="explicit methods lose their order"),
        pytest.raises((ancf.AccuracyError, ancf.InstabilityError)),
    ):
        ancf.simulate(problem.scene, 4.0, accuracy=1e-7)


def test_motions_without_such_a_place_are_believed(recwarn):
    """Linkages that turn over, and one with a repeated constraint."""
    ancf.simulate(four_bar().scene, 2.0, accuracy=1e-6)
    ancf.simulate(andrews().scene, 0.03, accuracy=1e-6)
    assert not recwarn.list
    ancf.simulate(bricard().scene, 1.0, accuracy=1e-6)
    assert len(recwarn.list) == 1
    assert "repeat others at the start" in str(recwarn.list[0].message)


def test_a_place_out_of_reach_is_refused():
    """Two bars of 1 m whose end is driven to 2.2 m: softer constraints must not pass that."""
    scene = ancf.Scene((0.0, 0.0))
    height = float(np.sqrt(1.0 - 0.75**2))
    angle = float(np.arctan2(height, 0.75))
    lower = scene.add_body(Rod(1.0), mass=1.0, position=(0, 0), orientation=angle)
    upper = scene.add_body(Rod(1.0), mass=1.0, position=(1.5, 0), orientation=np.pi - angle)
    scene.pin(lower.origin)
    scene.connect(lower.end, upper.end)
    start = (1.5, 0.0)
    scene.drive(upper.origin, ancf.Ramp((0.7, 0.0), 1.0, smooth=True) + start)
    with pytest.raises(ancf.StepError) as failure:
        ancf.simulate(scene, 1.0, 1e-3)
    reached = failure.value.trajectory.position(upper.origin)[-1, 0]
    assert 1.9 < reached < 2.001


def zigzag_of_bars(n, doubled=()):
    """Return bars that hang on one another, and which of them two equal rods hold together."""
    scene = ancf.Scene((0.0, -9.81))
    rise = np.sqrt(0.5)
    places = [(rise * k, rise * (k % 2)) for k in range(n)]
    angles = [0.25 * np.pi * (-1) ** k for k in range(n)]
    bars = [
        scene.add_body(Rod(1.0), mass=1.0, position=place, orientation=angle)
        for place, angle in zip(places, angles, strict=True)
    ]
    scene.pin(bars[0].origin)
    for one, other in itertools.pairwise(bars):
        scene.connect(one.end, other.origin)
    for k in doubled:
        for _ in range(2):
            scene.distance(bars[k].at(0.25), bars[k + 1].at(0.5))
    return scene


def test_repeats_are_named_however_many_constraints_there_are():
    """A rod that repeats another, among 780 equations."""
    system = System(zigzag_of_bars(260, doubled=(123,)))
    number, found = find_redundant_constraints(system, system.q0)
    assert number == len(found) == 1
    labels = system.constraints.labels
    (row, of), *_ = found
    assert "distance" in labels[row]
    assert "distance" in labels[of[0]]
    assert find_redundant_constraints(
        System(zigzag_of_bars(260)), System(zigzag_of_bars(260)).q0
    ) == (0, [])


def test_many_repeats_are_counted():
    system = System(zigzag_of_bars(200, doubled=range(0, 198, 3)))
    number, found = find_redundant_constraints(system, system.q0)
    assert number == 66
    assert 3 <= len(found) <= 66


def test_lost_rank_is_seen():
    """At the start of a four-bar linkage in a line, and not when it is upright."""
    system = System(n_four_bar(5).scene)
    assert count_near_dependent(system, system.q0, 0.1) == 0
    q = system.q0.copy()
    for body, places in zip(system.scene.bodies, system.places, strict=True):
        position, axis = (places[0, body.kind.columns(name)] for name in body.kind.vectors)
        q[axis] = (1.0, 0.0)
        if body.name.startswith("coupler"):
            q[position] = body.positions[0] + np.array([1.0, -1.0])
    assert count_near_dependent(system, q, 0.1) == 5
