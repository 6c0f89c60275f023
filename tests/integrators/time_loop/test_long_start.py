"""Start values where steps are long beside what they march, and steps with several solutions."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear import Attempt, Outcome
from ancfsparse.solve.initial_conditions.consistent_accelerations import initial_jerk
from ancfsparse.solve.initial_conditions.consistent_state import starting_state
from tests.integrators.points import Point, bar_by_hand

LENGTH, MASS = 3.0443, 10.0


def bar(stiffness=1e10, stretch=1.0, velocity=(0.0, 7.72)):
    """A mass point on a bar of Green's strain along x."""
    return Point((stretch * LENGTH, 0.0), velocity, MASS, 0.0, None, stiffness, LENGTH)


@pytest.mark.parametrize("stiffness", [1e6, 1e10])
def test_the_rate_of_the_start_acceleration_is_exact_however_stiff_the_bar(stiffness):
    point = bar(stiffness, 1.01, (1.0, 7.0))
    seed = point.seed()
    seed.factor(point.matrix(1.0, 0.0, point.q0, np.zeros(0), None))
    a = -point.force(point.q0) / MASS
    # Rate of the force EA e / L q: EA (e / L + q q^T / L^3) v, with e = (1.01^2 - 1) / 2.
    rate = stiffness * 1.01**2 / LENGTH * np.array([1.0, 0.0])
    rate += stiffness * (1.01**2 - 1.0) / 2.0 / LENGTH * point.v0
    for dt in (0.1, 1e-3):
        jerk = initial_jerk(point, seed, point.v0, a, np.zeros(0), dt)
        np.testing.assert_allclose(jerk, -rate / MASS, rtol=1e-6, atol=1e-8 * stiffness)


@pytest.mark.parametrize("integrator", [ancf.Newmark(), ancf.GeneralizedAlpha(0.5)], ids=repr)
def test_the_march_starts_with_what_its_step_can_follow(integrator):
    # Along the bar a mode of angular frequency omega keeps 1 - (1 - 1/(1 + scale omega^2))^2.
    point, dt = bar(1e8, 1.0 + 1e-4, (0.0, 0.0)), 1e-3
    start, a = starting_state(point, point.seed(), integrator, dt)
    assert a[0] == pytest.approx(-point.force(point.q0)[0] / MASS, rel=1e-12)
    # Stiffness along the bar: EA (e + (1 + 1e-4)^2) / L.
    stretch = (1.0 + 1e-4) ** 2
    omega2 = 1e8 / LENGTH * ((stretch - 1.0) / 2.0 + stretch) / MASS
    left = 1.0 / (1.0 + integrator.scale * dt**2 * omega2)
    assert left < 0.8
    assert start.a[0] == pytest.approx((1.0 - (1.0 - left) ** 2) * a[0], rel=1e-9)
    assert start.b[0] == pytest.approx(start.a[0], rel=1e-9)  # at rest nothing changes


@pytest.mark.parametrize("integrator", [ancf.Newmark(), ancf.GeneralizedAlpha(0.0)], ids=repr)
@pytest.mark.parametrize("dt", [1e-4, 1e-2])
def test_a_bar_that_turns_starts_with_the_acceleration_towards_the_pin(integrator, dt):
    # The solution of (M + scale K) a = -scale Q''[v, v], Q'' = EA v^2 / L^2 and K = EA / L along
    # the bar, keeps the part 1 - 1/(1 + scale omega^2) of v^2 / L, and the filter as much of that.
    point = bar(1e8)
    start, a = starting_state(point, point.seed(), integrator, dt)
    assert not a.any()  # there is no stress
    left = 1.0 / (1.0 + integrator.scale * dt**2 * 1e8 / (LENGTH * MASS))
    towards = -((1.0 - left) ** 2) * 7.72**2 / LENGTH
    np.testing.assert_allclose(start.a, [towards, 0.0], rtol=1e-6, atol=1e-9)


class Rope(Point):
    """A point on a spring without compression."""

    def force(self, q):
        return super().force(q) if q @ q > self.length**2 else np.zeros(2)


@pytest.mark.parametrize("along", [-1.0, 1.0])
def test_a_force_that_sets_in_adds_no_acceleration_to_the_start(along):
    # Its second difference is the force after some millionth of a second over the square of that.
    rope = Rope((LENGTH, 0.0), (along, 7.72), MASS, 0.0, None, 1e8, LENGTH)
    start, _ = starting_state(rope, rope.seed(), ancf.Newmark(), 1e-2)
    assert not start.a.any()


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.5), ancf.HHT(0.3)], ids=repr)
@pytest.mark.parametrize("dt", [0.01, 0.1])
def test_steps_of_a_stiff_bar_are_roots_of_a_cubic(integrator, dt):
    n = round(1.0 / dt)
    start, _ = starting_state(bar(), bar().seed(), integrator, dt)
    expected, _ = bar_by_hand(bar(), integrator, dt, n, start.a, start.b)
    q, *_, outcome = bar().march(dt, n, integrator)
    assert outcome == Outcome.CONVERGED
    np.testing.assert_allclose(q, expected, rtol=0, atol=1e-7)


def turned_over(begin):
    """A predictor that lies beyond the pin, in equations that hold no acceleration of the start."""
    known = begin.q + STEP * begin.v
    beyond = -(1.0 + 1.05 * LENGTH / np.linalg.norm(known)) * known
    a = beyond / (ASYMPTOTIC.scale * STEP**2)
    return type(begin)(begin.q, begin.v, a, 0.0 * a, begin.lam, begin.amplitudes)


ASYMPTOTIC, STEP = ancf.GeneralizedAlpha(0.0), 0.05  # with alpha_f = 0


def test_a_solution_that_gains_energy_is_refused_for_one_that_does_not():
    # The bar turned over is a root of the cubic equation too, and Newton finds the nearer one.
    lost = bar()
    q, v, *_ = lost.march(STEP, 1, ASYMPTOTIC, start=turned_over)
    assert q[0, 0] < -0.9 * LENGTH
    assert lost.energy(q, v)[0] > 10.0 * lost.energy(lost.q0[None], lost.v0[None])[0]
    point = bar()
    q, *_, outcome = point.march(STEP, 1, ASYMPTOTIC, start=turned_over, largest_gain=0.01)
    assert outcome == Outcome.CONVERGED
    assert [event[:3] for event in point.loop.events] == [
        (1, Attempt.COASTING, Outcome.GAINED_ENERGY)
    ]
    assert point.loop.counts["recoveries_newton"] == 1
    calm, *_ = bar().march(STEP, 1, ASYMPTOTIC)
    np.testing.assert_allclose(q, calm, rtol=0, atol=1e-9)


def pushed(begin):
    """An acceleration at the start along the velocity, which gives every solution energy."""
    return type(begin)(begin.q, begin.v, begin.a, 5.0 * begin.v, begin.lam, begin.amplitudes)


def test_of_solutions_that_all_gain_energy_the_one_that_gains_least_is_kept():
    both = [
        bar().march(STEP, 1, ASYMPTOTIC, start=start)[:2]
        for start in (pushed, lambda begin: pushed(turned_over(begin)))
    ]
    point = bar()
    before = point.energy(point.q0[None], point.v0[None])[0]
    little, much = (point.energy(q, v)[0] / before - 1.0 for q, v in both)
    assert 0.1 < little < 0.01 * much
    # Newton finds the one that gains much, other start and descent the other; both gain too much.
    q, v, _, _, outcome = point.march(
        STEP, 1, ASYMPTOTIC, start=lambda begin: pushed(turned_over(begin)), largest_gain=0.01
    )
    assert outcome == Outcome.CONVERGED  # in the first steps a gain stops no run
    assert [event[:3] for event in point.loop.events] == [
        (1, Attempt.COASTING, Outcome.GAINED_ENERGY),
        (1, Attempt.DESCENT, Outcome.GAINED_ENERGY),
    ]
    np.testing.assert_allclose(q, both[0][0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(v, both[0][1], rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("stiffness", "solver"),
    [
        (1e6, ancf.Newton()),  # recognised by its matrices
        (1e4, ancf.QuasiNewton("broyden", 10, seed_frame="fixed")),  # and by its residuals
    ],
    ids=str,
)
def test_a_step_that_only_gains_is_not_taken(stiffness, solver):
    # No energy may be gained at all.
    point = bar(stiffness, 1.1)
    q, v, _, _, outcome = point.march(0.1, 50, ancf.Newmark(), largest_gain=1e-9, solver=solver)
    assert outcome == Outcome.WOULD_GAIN
    state = point.marched.state
    kept = (q[-1], v[-1]) if len(q) else (point.q0, point.v0)
    np.testing.assert_array_equal(state[0], kept[0])
    np.testing.assert_allclose(state[1], kept[1], rtol=1e-12, atol=1e-12)
    gain, exchanged = point.marched.refused_gain
    assert gain > 1e-9 * exchanged
