"""The watch over the energy where loads jump and where motions begin: one rule for all solvers."""

import itertools
import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from tests.beams import build_beam

SOLVERS = (ancf.Newton(), "auto", ancf.QuasiNewton("davidon"))


def pulled(modulus, dt, force, jump=0.02, element="thin"):
    """A hanging cable whose end a force pulls up, suddenly; and how to march it."""
    scene, rod = build_beam(
        element, (0, 0), (2, 0), 10, ancf.Rectangle(0.01, 0.01), ancf.Material(modulus, 4000.0),
        "pin",
    )  # fmt: skip
    scene.point_force(rod.end, lambda t: (0.0, force if t > jump else 0.0))
    return scene, rod, {"t_end": round(0.06 / dt) * dt, "dt": dt}


@pytest.mark.parametrize("solver", SOLVERS, ids=str)
@pytest.mark.parametrize(
    "integrator",
    [ancf.Newmark(0.05), ancf.HHT(0.05), ancf.HHT(0.3), ancf.GeneralizedAlpha(0.5)],
    ids=repr,
)
@pytest.mark.parametrize("dt", [5e-4, 2.5e-4])
def test_a_force_that_jumps_gives_what_it_gives(integrator, solver, dt):
    # Its step is hard for kept seeds, which are looked at then, and was for them alone a gain.
    scene, rod, times = pulled(1e8, dt, 100.0)
    run = ancf.simulate(scene, **times, integrator=integrator, solver=solver)
    scene, twin, times = pulled(1e8, dt, 100.0)
    free = ancf.simulate(scene, **times, integrator=integrator, max_energy_gain=math.inf)
    np.testing.assert_allclose(run.position(rod.end), free.position(twin.end), atol=1e-5)


def ends(solver, integrator, *place):
    """Whether a pulled cable is moved to the end of the run; None if a step failed."""
    scene, _, times = pulled(*place)
    try:
        ancf.simulate(scene, **times, integrator=integrator, solver=solver)
    except ancf.EnergyIncreaseError:
        return False
    except ancf.StepError:
        return None
    return True


def test_sudden_loads_stop_no_solver_where_newton_finishes():
    places = itertools.product(
        (1e6, 1e8, 1e10), (1e-4, 5e-4, 2e-3), (1.0, 10.0, 100.0, 1000.0), (0.02,), ("thin", "l2t2")
    )
    integrators = (
        ancf.GeneralizedAlpha(0.9), ancf.GeneralizedAlpha(0.5), ancf.Newmark(0.0),
        ancf.Newmark(0.05), ancf.HHT(0.05), ancf.HHT(0.3), ancf.EnergyMomentum(),
    )  # fmt: skip
    runs = list(itertools.product(places, integrators))
    assert len(runs) == 504
    false_alarms = [
        (place, integrator)
        for place, integrator in runs
        if ends("auto", integrator, *place) is False and ends(ancf.Newton(), integrator, *place)
    ]
    assert false_alarms == []


def thrown(steps, dt=3e-3):
    """A stiff bar shortened against its weight, which then swings; only its first step gains.

    Its stretching has h omega = 3.1, and keeps half of the acceleration at the start.
    """
    scene, _ = build_beam(
        "thin", (0, 0), (1, 0), 1, ancf.Rectangle(0.05, 0.05), ancf.Material(2.5e8, 1000.0), "pin",
        gravity=(9.81, -0.2),
        velocity=lambda x: np.outer(np.sin(0.5 * np.pi * x[:, 0]), (-0.02, 0.0)),
    )  # fmt: skip
    return {"scene": scene, "t_end": steps * dt, "dt": dt, "integrator": ancf.HHT(0.05)}


@pytest.mark.parametrize("solver", SOLVERS, ids=str)
def test_what_a_start_gains_is_judged_by_the_whole_motion(solver):
    # 4.4 % of what moves at first: over 0.6 s the bar comes to ten times that.
    energy = ancf.simulate(**thrown(200), solver=solver).energy
    gain = energy.total - energy.total[0]
    assert gain[1] > 0.02 * energy.kinetic[0]
    assert gain.max() < 0.01 * energy.kinetic.max()
    # Over 0.06 s it does not.
    gained = r"after step 1 .* had gained .* kinetic energy"
    with pytest.raises(ancf.EnergyIncreaseError, match=gained) as stop:
        ancf.simulate(**thrown(20), solver=solver)
    path = stop.value.trajectory
    assert path.stats.steps == stop.value.step == 20
    assert stop.value.when == 1
    energy = path.energy
    # Less noise.
    assert stop.value.gain == pytest.approx(energy.total[1] - energy.total[0], rel=1e-2)
    assert stop.value.gain > 0.01 * stop.value.exchanged


QUIET = np.zeros(61)
JUMP = np.repeat([0.0, 1.0], [3, 58])  # at the end of the third step
RAMP = np.arange(61.0)


def oscillator(scheme, h, x, v, loads):
    """March x'' = f - x by the weights alone, with loads f before and after each step.

    Gives gains of energy, motions, and the largest energy exchanged so far, step by step.
    """
    force = loads[0]
    a = force - x
    b = a + scheme.shift * (loads[1] - force - h * v) / (1.0 + scheme.beta * h * h)
    m, g = (1.0 - scheme.alpha_f) / (1.0 - scheme.alpha_m), scheme.gamma
    start, work, largest, rows = 0.5 * (v * v + x * x), 0.0, 0.5 * v * v, []
    for load in loads[1:]:
        known = (scheme.alpha_f * a - scheme.alpha_m * b) / (1.0 - scheme.alpha_m)
        away = x + h * v + h * h * ((0.5 - scheme.beta) * b + scheme.beta * known)
        new = (away + h * h * scheme.beta * m * load) / (1.0 + h * h * scheme.beta * m)
        a = load - new
        v, b = v + h * ((1.0 - g) * b + g * (known + m * a)), known + m * a
        work += 0.5 * (force + load) * (new - x)
        largest = max(largest, 0.5 * v * v, abs(0.5 * new * new - start), abs(work))
        rows.append((0.5 * (v * v + new * new) - start - work, abs(new - x), largest))
        x, force = new, load
    return np.array(rows).T


@pytest.mark.parametrize(
    "scheme",
    [ancf.Newmark(0.05), ancf.Newmark(0.3), ancf.HHT(0.05), ancf.HHT(0.3),
     *[ancf.GeneralizedAlpha(rho) for rho in (0.0, 0.2, 0.5, 0.8, 0.9)]],
    ids=repr,
)  # fmt: skip
def test_the_share_of_a_jump_covers_what_the_scheme_makes_of_it(scheme):
    # From motions of any phase and size; 2 % of what is exchanged stands for the watch's 1 %.
    worst, rest = -math.inf, 0.0
    for h, size in itertools.product((0.01, 0.1, 0.3, 1, 3, 10, 100), (0, 0.1, 1, 10)):
        for phase in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False):
            x, v = size * np.cos(phase), size * np.sin(phase)
            gain, moved, exchanged = oscillator(scheme, h, x, v, JUMP)
            quiet, _, least = oscillator(scheme, h, x, v, QUIET)
            if (quiet > 0.01 * least + 1e-30).any():
                continue  # a start that gains without any load
            unsure = np.sqrt(np.cumsum((0.5 ** np.arange(58) * moved[2:]) ** 2))
            over = gain[2:] - scheme.jump_share * unsure
            worst = max(worst, float((over - 0.02 * exchanged[2:]).max()))
            if size == 0:
                rest = max(rest, float((gain[2:] / unsure).max()))
    assert worst <= 0.0
    # And it is what Newmark's alpha needs from rest, and no more than four times what others need.
    needed, slack = (1.0, 0.25) if scheme.shift == 0 else (0.25, 2.0)
    assert rest == pytest.approx(needed * scheme.jump_share, rel=slack)
    assert rest > 0.0


SECOND_ORDER = [ancf.HHT(0.05), ancf.HHT(0.3)] + [
    ancf.GeneralizedAlpha(rho) for rho in (0.0, 0.2, 0.5, 0.8, 0.9)
]


@pytest.mark.parametrize("scheme", SECOND_ORDER, ids=repr)
def test_what_is_allowed_for_a_ramp_from_the_start_is_needed_and_suffices(scheme):
    # It covers what a start without stress gains at any speed and frequency, beside 2 % of what is
    # exchanged.
    share = scheme.first_jump * scheme.jump_share
    assert share <= 0.5 * scheme.jump_share
    speeds = np.append(0.0, np.logspace(-2.0, 2.0, 17))
    for h, v in itertools.product((0.01, 0.1, 0.3, 1, 3, 10, 100), [*-speeds, *speeds]):
        gain, moved, exchanged = oscillator(scheme, h, 0.0, v, RAMP)
        quiet, _, least = oscillator(scheme, h, 0.0, v, QUIET)
        if (quiet <= 0.01 * least + 1e-30).all():
            assert (gain <= share * abs(moved[0]) + 0.02 * exchanged).all(), (h, v)
    # What falls slowly against a growing load needs all of it.
    gain, moved, _ = oscillator(scheme, 1e-3, 0.0, 0.0, 1.0 - 0.01 * RAMP)
    assert gain[0] == pytest.approx(share * 0.01 * moved[0], rel=0.02)


@pytest.mark.parametrize("scheme", [ancf.Newmark(0.05), ancf.Newmark(0.3)], ids=repr)
def test_a_ramp_is_as_a_jump_to_a_start_that_does_not_know_its_rate(scheme):
    assert scheme.first_jump == 1.0
    gain, moved, _ = oscillator(scheme, 0.01, 0.0, 0.0, 1.0 + 0.01 * RAMP)
    allowed = scheme.jump_share * 0.01 * moved[0]
    assert gain[0] == pytest.approx(allowed * (1.0 - 0.5 * scheme.alpha), rel=0.02)


@pytest.mark.parametrize("scheme", [ancf.Newmark(0.0), ancf.GeneralizedAlpha(1.0)], ids=repr)
def test_the_trapezoidal_rule_needs_no_allowance(scheme):
    assert scheme.jump_share == 0.0
    gain, *_ = oscillator(scheme, 0.3, 0.5, 0.2, JUMP)
    assert np.abs(gain).max() < 1e-14
    assert ancf.EnergyMomentum().jump_share == 0.0


def light(load):
    """A beam without weight, with a load across its free end."""
    scene, rod = build_beam(
        "thin", (0, 0), (1, 0), 4, ancf.Rectangle(0.02, 0.02), ancf.Material(1e7, 2000.0), "pin",
        gravity=(0.0, 0.0),
    )  # fmt: skip
    scene.point_force(rod.end, lambda t: (0.0, load(t)))
    return scene, rod


def unsure(load, dt, steps):
    """Work [J] that is unsure at the end of a march by HHT(0.3) under a load."""
    scene, _ = light(load)
    system = System(scene)
    march, iteration, *_ = prepare_implicit(system, dt, ancf.HHT(0.3), "auto", "default", math.inf)
    n, m = system.n_all, system.n_multipliers
    loads = system.loads.amplitudes(dt * np.arange(1.0, steps + 1))
    march.advance(iteration, steps, loads, steps, 0, *(np.empty((2, k)) for k in (n, n, n, m)))
    return march.unsure_work


def test_a_smooth_load_is_no_licence():
    # Third order in the step, and hardly more after a hundred periods than after ten.
    def sine(t):
        return math.sin(2.0 * math.pi * t / 0.1)

    coarse, fine = (unsure(sine, 0.1 / n, 10 * n) for n in (50, 100))
    assert fine < 0.2 * coarse
    assert unsure(sine, 0.1 / 50, 5000) < 4.0 * coarse
    # A load that jumps as often is a hundred times as unsure.
    jumps = unsure(lambda t: math.copysign(1.0, sine(t + 1e-9)), 0.1 / 50, 500)
    assert jumps > 100.0 * coarse


@pytest.mark.parametrize("load", [lambda t: 3.0, lambda t: 3.0 + 7.0 * t], ids=["constant", "ramp"])
def test_a_load_that_does_not_bend_is_sure(load):
    # The start of a ramp is forgotten after 20 halvings.
    assert unsure(load, 1e-3, 100) == pytest.approx(unsure(load, 1e-3, 30), rel=1e-9, abs=1e-30)


def test_a_first_step_is_unsure_by_the_change_of_the_load_along_its_way():
    def load(t):
        return 3.0 - 7.0 * t

    dt, scheme = 1e-2, ancf.HHT(0.3)
    scene, rod = light(load)
    moved = np.diff(ancf.simulate(scene, dt, dt, integrator=scheme).position(rod.end), axis=0)[0]
    expected = 0.5 * scheme.alpha**2 * abs(load(dt) - load(0.0)) * abs(moved[1])
    assert unsure(load, dt, 1) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize(
    ("solver", "integrator", "stiffness", "dt", "calm"),
    [
        (ancf.Newton(), ancf.Newmark(), 1e10, 1e-3, 62),
        (ancf.Newton(), ancf.GeneralizedAlpha(0.5), 1e10, 0.05, 70),
        (ancf.ModifiedNewton(), ancf.GeneralizedAlpha(0.5), 1e6, 0.05, 68),
    ],
    ids=repr,
)
def test_a_load_that_jumps_is_solved_for_whatever_contraction_calm_steps_had(
    solver, integrator, stiffness, dt, calm
):
    # Vibrations along a straight beam are linear, and corrections exact; those across it are not.
    def end(tolerance):
        scene = ancf.Scene((0.0, 0.0))
        section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(stiffness, 4000.0)
        rod = scene.add_beam("thin", (0, 0), (1, 0), 6, section, material, strain="biot")
        scene.clamp(rod.start)
        size = 1e-7 * stiffness
        scene.point_force(
            rod.end,
            lambda t: (size * math.sin(2.9 * t / dt), size * (t > (calm + 0.5) * dt)),
        )
        options = {"integrator": integrator, "solver": solver, "tolerance": tolerance}
        return ancf.simulate(scene, (calm + 1) * dt, dt, **options).q[-2:]

    before, after = end(1e-12)
    step = np.abs(after - before).max()
    np.testing.assert_allclose(end("default")[1], after, rtol=0, atol=1e-4 * step)
