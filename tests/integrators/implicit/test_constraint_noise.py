"""What a constraint that is not solved exactly does to its force: numerics of index-3 equations."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.integrators.implicit.time_integration import make_time_loop
from ancfsparse.nonlinear import Newton
from ancfsparse.nonlinear.iteration import Costs, make_inverse, make_iteration
from ancfsparse.nonlinear.loop_protocols import Tolerance
from ancfsparse.solve.initial_conditions.consistent_state import starting_state
from tests.integrators.points import on_circle


def multipliers(integrator, dt, delta, seed_of_noise=0):
    """Pulls of the rod over 1 s (k,) [N], its length off by -delta or delta in each step [m]."""
    point = on_circle(1.0, 4.0)
    offset = 0.0
    exact = point.residual

    def residual(*state):
        r, phi = exact(*state)
        return r, phi + offset

    seed = point.seed()
    start, _ = starting_state(point, seed, integrator, dt)
    point.residual = residual
    march = make_time_loop(point, dt, integrator, start, np.inf, 0.0, 0.0)
    march.prepare(np.zeros((1, 0)))
    scale = integrator.scale * dt**2
    loop = make_iteration(
        march, seed, make_inverse(Newton(), seed, None, np.ones(seed.n), 0.0), Newton(),
        Tolerance(False, scale * 1e-9, 1e-14, 0.0, 1e-16), Costs(1.0, 0.0, 1.0),
    )  # fmt: skip
    rng = np.random.default_rng(100 + seed_of_noise)
    out = [np.zeros((2, n)) for n in (2, 2, 2, 1)]
    found = []
    for _ in range(round(1.0 / dt)):
        offset = delta * rng.choice([-1.0, 1.0])
        taken, outcome = march.advance(loop, 1, np.zeros((1, 0)), 1, 0, *out)
        assert (taken, outcome) == (1, 0)
        found.append(out[3][1, 0])
    return np.array(found)


def shaken(integrator, dt, delta):
    """What noise of that size adds to the pulls, rms over the run and some noises [N]."""
    calm = multipliers(integrator, dt, 0.0)
    # Six noises of 100 steps, two of 1000.
    apart = [multipliers(integrator, dt, delta, k) - calm for k in range(6 if dt > 5e-3 else 2)]
    return np.sqrt(np.mean(np.square(apart)))


# The effect is proportional to the noise (tested below): one size is enough for short steps.
@pytest.mark.parametrize(
    ("dt", "ratio", "deltas"), [(1e-2, 30.0, (1e-6, 1e-8)), (1e-3, 500.0, (1e-8,))]
)
def test_the_trapezoidal_rule_piles_up_what_constraints_leave(dt, ratio, deltas):
    for delta in deltas:
        trapezoidal = shaken(ancf.Newmark(0.0), dt, delta)
        damped = shaken(ancf.GeneralizedAlpha(0.8), dt, delta)
        assert trapezoidal > ratio * damped
        # Damped, it stays at 1 / (1 - rho)^2 of what the position alone makes of the acceleration.
        raw = delta / (0.25 * dt**2)
        assert 25.0 * raw < damped < 75.0 * raw


@pytest.mark.parametrize("integrator", [ancf.Newmark(0.0), ancf.GeneralizedAlpha(0.8)], ids=repr)
def test_the_noise_of_a_force_is_that_of_its_constraint(integrator):
    sizes = [shaken(integrator, 1e-2, delta) for delta in (1e-6, 1e-7, 1e-8)]
    assert sizes[0] / sizes[1] == pytest.approx(10.0, rel=0.05)
    assert sizes[1] / sizes[2] == pytest.approx(10.0, rel=0.05)
