"""Newmark, HHT and generalised-alpha on bodies of one point: what theory says they do."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.nonlinear import Newton, Outcome
from ancfsparse.solve.error_control.implicit_integration import ImplicitIntegration
from tests.integrators.points import Point, bar_by_hand, exact_circle, on_circle, orders

SECOND_ORDER = [ancf.Newmark(0.0), ancf.HHT(0.05), ancf.HHT(0.3), ancf.GeneralizedAlpha(0.9),
                ancf.GeneralizedAlpha(0.6)]  # fmt: skip


def radius_at_infinity(integrator):
    """Spectral radius of a step of v' = -omega^2 x for omega dt to infinity, where x1 = x0 = 0."""
    g, b = integrator.gamma, integrator.beta
    # In the limit the forces rule: a1 (1 - alpha_f) + alpha_f a0 is proportional to the positions.
    omega2 = 1e14
    m, f = integrator.alpha_m, integrator.alpha_f
    # Unknowns (x, v, b, a) at the new and old times, dt = 1, a = -omega^2 x.
    new = np.array(
        [
            [1.0, 0.0, -b, 0.0],
            [0.0, 1.0, -g, 0.0],
            [0.0, 0.0, 1.0 - m, -(1.0 - f)],
            [omega2, 0.0, 0.0, 1.0],
        ]
    )
    old = np.array(
        [[1.0, 1.0, 0.5 - b, 0.0], [0.0, 1.0, 1.0 - g, 0.0], [0.0, 0.0, -m, f], [0.0] * 4]
    )
    return np.abs(np.linalg.eigvals(np.linalg.solve(new, old))).max()


@pytest.mark.parametrize("rho", [0.0, 0.5, 0.8, 0.9, 1.0])
def test_generalized_alpha_leaves_rho_of_the_highest_frequencies(rho):
    # A defective double eigenvalue: rounding splits it by the root of its size.
    assert radius_at_infinity(ancf.GeneralizedAlpha(rho)) == pytest.approx(rho, abs=2e-3)


@pytest.mark.parametrize("alpha", [0.05, 0.3])
def test_hht_is_its_own_formula(alpha):
    hht = ancf.HHT(alpha)
    assert (hht.alpha_m, hht.alpha_f) == (0.0, alpha)
    assert hht.gamma == pytest.approx(0.5 + alpha, rel=1e-15)
    assert hht.beta == pytest.approx((1 + alpha) ** 2 / 4, rel=1e-15)
    assert radius_at_infinity(hht) == pytest.approx((1 - alpha) / (1 + alpha), abs=2e-3)


@pytest.mark.parametrize("integrator", SECOND_ORDER, ids=repr)
def test_the_velocity_constant_is_that_of_theory(integrator):
    expected = -(1.0 / 12.0 + integrator.shift**2 / 4.0)
    assert integrator.velocity_constant == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize(
    "make",
    [lambda: ancf.HHT(0.4), lambda: ancf.HHT(-0.1), lambda: ancf.GeneralizedAlpha(1.1),
     lambda: ancf.GeneralizedAlpha(math.nan), lambda: ancf.GeneralizedAlpha("0.9")],
)  # fmt: skip
def test_weights_out_of_range_are_refused(make):
    with pytest.raises(ancf.InputError, match=r"alpha|rho_inf"):
        make()


def test_a_thing_that_is_no_integrator_is_refused():
    scene = ancf.Scene((0.0, -9.81))
    scene.add_beam(
        "thin", (0, 0), (1, 0), 2, ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    )
    with pytest.raises(ancf.InputError, match=r"integrator must be Newmark\(alpha\)"):
        ancf.simulate(scene, 1e-3, 1e-3, integrator="hht")


def circle_errors(integrator, dt, corrected):
    """Errors on the pendulum of numerics: positions, multipliers of the first and last 20 steps."""
    n = round(1.0 / dt)
    q, _, _, lam, outcome = on_circle(1.0, 4.0).march(dt, n, integrator, corrected)
    assert outcome == Outcome.CONVERGED
    where, pull = exact_circle(1.0, 4.0, dt * np.arange(1, n + 1))
    off = np.abs(lam[:, 0] - pull)
    return np.abs(q - where).max(), off[:20].max(), off[-20:].max()


def circle_orders(integrator, corrected):
    """Errors of four lengths of step, each twice the next, in rows."""
    return np.array([circle_errors(integrator, dt, corrected) for dt in STEPS]).T


STEPS = (0.02, 0.01, 0.005, 0.0025)


@pytest.mark.parametrize("integrator", SECOND_ORDER, ids=repr)
def test_corrected_starts_make_multipliers_second_order(integrator):
    q, first, last = circle_orders(integrator, True)
    assert np.abs(orders(q) - 2.0).max() < 0.2
    assert np.abs(orders(last) - 2.0)[1:].max() < 0.35
    assert first[1] < 0.1  # of pulls of 10 to 30 N
    assert orders(first).min() > 1.5


def test_the_trapezoidal_rule_without_correction_never_gets_its_multipliers_right():
    q, _, last = circle_orders(ancf.Newmark(0.0), False)
    assert np.abs(orders(q) - 2.0).max() < 0.1  # positions never reveal it
    assert 50.0 < last.min() <= last.max() < 90.0
    assert np.abs(orders(last)).max() < 0.1


def test_generalized_alpha_without_correction_starts_with_first_order_multipliers():
    _, first, _ = circle_orders(ancf.GeneralizedAlpha(0.9), False)
    assert np.abs(orders(first) - 1.0).max() < 0.12


def alternating_errors(integrator, dt, corrected=True):
    """Largest error of the multiplier where steps of dt and dt / 2 alternate, five at a time."""
    point = on_circle(1.0, 4.0)
    task = SimpleNamespace(
        system=point,
        t=np.array([0.0, 1.0]),
        length=1.0,
        spans=[(0.0, 1.0)],
        max_energy_gain=math.inf,
    )
    run = ImplicitIntegration(task, integrator, Newton(), [round(1.0 / dt)], 1e-12 / dt**2)
    buffer = [np.empty((2, n)) for n in (2, 2, 2, 1)]
    t, lam = [0.0], []
    while t[-1] < 1.0 - 1e-9:
        _, outcome = run.time_loop.advance(run.iteration, 1, np.zeros((1, 0)), 1, 0, *buffer)
        assert outcome == Outcome.CONVERGED
        t.append(t[-1] + run.dt)
        lam.append(buffer[3][1, 0])
        if len(lam) % 5:
            continue
        length = dt if run.dt < dt else dt / 2
        if corrected:
            run.change(length, t[-1])
        else:
            run.time_loop.change_step(length, integrator, 0.0, 0.0)
            run.dt = length
    return np.abs(np.array(lam) - exact_circle(1.0, 4.0, np.array(t[1:]))[1]).max()


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.6), ancf.HHT(0.1)], ids=repr)
def test_corrected_changes_of_the_step_keep_multipliers_second_order(integrator):
    plain = [alternating_errors(integrator, dt, False) for dt in STEPS]
    corrected = [alternating_errors(integrator, dt) for dt in STEPS]
    assert np.abs(orders(plain)[1:] - 1.0).max() < 0.15
    # The rate of the acceleration is a mean over some steps, which lags behind at the coarse end.
    assert orders(corrected)[1:].min() > 1.6
    assert orders(corrected)[-1] > 1.75
    assert (np.array(corrected) < np.array(plain) / 3).all()


def test_the_trapezoidal_rule_diverges_on_changing_steps():
    plain = [alternating_errors(ancf.Newmark(0.0), dt, False) for dt in STEPS[:3]]
    assert orders(plain).max() < -0.9  # the error doubles when steps are halved, or worse


def swing_errors(integrator, steps, alter=None):
    """P2: from horizontal at rest for 2 s."""
    out = []
    for n in steps:
        q, _, _, lam, outcome = on_circle(math.pi / 2, 0.0).march(
            2.0 / n, n, integrator, start=alter
        )
        assert outcome == Outcome.CONVERGED
        where, pull = exact_circle(math.pi / 2, 0.0, 2.0 / n * np.arange(1, n + 1))
        out.append((np.abs(q - where).max(), np.abs(lam[-20:, 0] - pull[-20:]).max()))
    return np.array(out).T


def test_newmark_with_damping_is_first_order_and_hht_second():
    steps = (200, 400, 800, 1600)
    newmark, _ = swing_errors(ancf.Newmark(0.05), steps)
    hht, _ = swing_errors(ancf.HHT(0.05), steps)
    assert np.abs(orders(newmark) - 1.0).max() < 0.15
    assert np.abs(orders(hht) - 2.0).max() < 0.1
    assert newmark[-1] > 20.0 * hht[-1]


def pushed(along):
    """A start with 1e-3 m/s across the constraint."""

    def alter(start):
        return type(start)(start.q, start.v + 1e-3 * along, *(
            getattr(start, name) for name in ("a", "b", "lam", "amplitudes")))  # fmt: skip

    return alter


def test_the_trapezoidal_rule_multiplies_a_velocity_across_the_constraint():
    across = pushed(np.array([1.0, 0.0]))  # the pendulum starts at (1, 0)
    found = {
        integrator: swing_errors(integrator, (200,), across)[1][0]
        for integrator in (ancf.Newmark(0.0), ancf.Newmark(0.05), ancf.HHT(0.1),
                           ancf.GeneralizedAlpha(0.8))
    }  # fmt: skip
    assert found[ancf.Newmark(0.0)] > 1e2
    for integrator in list(found)[1:]:
        assert found[integrator] < 1.0


def truss(stiffness):
    """A bar of Green's strain with half its mass at the tip, thrown across (Kuhl and Crisfield)."""
    length, mass = 3.0443, 6.57 * 3.0443 / 2.0
    return Point((length, 0.0), (0.0, 7.72), mass, gravity=0.0, stiffness=stiffness, length=length)


def truss_run(stiffness, dt, integrator, t_end=10.0):
    """Largest and last energy over the first, and the outcome."""
    point = truss(stiffness)
    q, v, _, _, outcome = point.march(dt, round(t_end / dt), integrator)
    energy = point.energy(q, v) / point.energy(point.q0[None], point.v0[None])[0]
    return energy.max(), energy[-1], outcome


def test_the_trapezoidal_rule_breaks_down_on_the_stiff_truss_but_with_small_steps():
    for dt in (0.01, 0.05, 0.1):
        largest, _, outcome = truss_run(1e10, dt, ancf.Newmark(0.0))
        assert outcome == Outcome.CONVERGED
        assert largest > 10.0
    largest, last, outcome = truss_run(1e10, 0.005, ancf.Newmark(0.0))
    assert outcome == Outcome.CONVERGED
    assert largest < 1.0 + 1e-3
    assert last == pytest.approx(1.0, abs=1e-3)


def by_hand(stiffness, dt, integrator, is_corrected=True, t_end=10.0):
    """Last energy over the first, from the true start or the acceleration towards the pin."""
    point, start = truss(stiffness), np.zeros(2)
    if is_corrected:
        left = 1.0 / (1.0 + integrator.scale * dt**2 * stiffness / (point.length * point.mass))
        start[0] = -((1.0 - left) ** 2) * point.v0[1] ** 2 / point.length
    q, v = bar_by_hand(point, integrator, dt, round(t_end / dt), start, start)
    return point.energy(q, v)[-1] / point.energy(point.q0[None], point.v0[None])[0]


# What is left of the energy after 10 s from the true start values, whose first steps have a pull of
# nothing and of twice the mean in turn.
LEFT = {0.005: 0.9999, 0.01: 0.9995, 0.05: 0.984, 0.1: 0.931}


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.5), ancf.HHT(0.3)], ids=repr)
@pytest.mark.parametrize("dt", LEFT)
@pytest.mark.parametrize("stiffness", [1e6, 1e10])
def test_strong_damping_never_gains_energy_on_the_truss(stiffness, dt, integrator):
    largest, last, outcome = truss_run(stiffness, dt, integrator)
    assert outcome == Outcome.CONVERGED
    assert largest <= 1.0 + 1e-4
    assert by_hand(stiffness, dt, integrator, False) == pytest.approx(LEFT[dt], abs=1e-3)
    assert last == pytest.approx(by_hand(stiffness, dt, integrator), abs=1e-5)
    assert 1.0 - last < 0.6 * (1.0 - LEFT[dt]) or dt < 0.05


def test_a_little_damping_is_no_proof_against_gaining_energy():
    point = truss(1e10)
    *_, outcome = point.march(0.1, 100, ancf.HHT(0.05), largest_gain=0.05)
    assert outcome == Outcome.GAINED_ENERGY


def test_newmark_loses_more_energy_than_hht():
    # 6.1 % against 0.004 % in ten seconds; 0.04 % from the true start values.
    newmark, hht = ancf.Newmark(0.05), ancf.HHT(0.05)
    for integrator, lost in ((newmark, 0.061), (hht, 4e-5)):
        _, last, _ = truss_run(1e10, 0.01, integrator)
        assert 1.0 - last == pytest.approx(1.0 - by_hand(1e10, 0.01, integrator), rel=1e-3)
        assert 1.0 - last == pytest.approx(lost, rel=0.1)
    assert 1.0 - by_hand(1e10, 0.01, hht, False) == pytest.approx(4e-4, rel=0.1)
