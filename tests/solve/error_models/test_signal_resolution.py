"""Signals shorter than the steps: fixed steps warn, runs to an accuracy and plans follow them."""

import warnings

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError, UnresolvedSignalWarning
from ancfsparse.integrators.interface.time_grid import TimeGrid
from ancfsparse.solve.error_models.signal_resolution import MAX_IMPULSE_ERROR, impulse_error
from ancfsparse.system import System
from ancfsparse.system.used_signals import signals_of

T_END, DT = 0.1, 1e-3
# Impulse of each: 6e-4 N s, between two steps of 1 ms; those of the sines are of a half wave.
SHORT = {
    "pulse": ancf.Pulse(10.0, 0.05012, 0.05018),
    "trapezoid": ancf.Pulse(20.0, 0.05012, 0.05018, rise=3e-5),
    "spike": ancf.Table([0.0, 0.05012, 0.05015, 0.05018, 1.0], [0, 0, 20.0, 0, 0]),
    "smooth spike": ancf.Table([0.0501, 0.0503, 0.0505], [0, 3.0, 0], outside="hold", smooth=True),
    "two ramps": ancf.Ramp(10.0, 0.05015, 0.05012) - ancf.Ramp(10.0, 0.05018, 0.05015),
    "between others": ancf.Ramp(0.0, 0.1) + ancf.Pulse(10.0, 0.05012, 0.05018) + 0.0,
    "alias": ancf.Sine(10.0, 1000.0),
    "near alias": ancf.Sine(10.0, 999.0),
}
LONG = {
    "pulse": ancf.Pulse(1.0, 0.02, 0.03),
    "pulse of one step": ancf.Pulse(1.0, 0.02, 0.021),
    "sudden ramp": ancf.Ramp(1.0, 1e-9),
    "smooth ramp": ancf.Ramp(1.0, 0.02, 0.01, smooth=True),
    "sine": ancf.Sine(1.0, 100.0),
    "dense table": ancf.Table(np.linspace(0, 0.1, 5001), np.sin(np.linspace(0, 9, 5001))),
}


def particle(signal):
    """A rigid body of 2 kg, free in the plane, pushed along x."""
    scene = ancf.Scene(gravity=(0.0, 0.0))
    body = scene.add_body(ancf.Box(length=1.0, height=1.0, width=1.0), mass=2.0, position=(0, 0),
                          velocity=(0.0, 1.0))  # fmt: skip
    scene.point_force(body.at((0.0, 0.0)), along_x(signal))
    return scene, body.at((0.0, 0.0))


def along_x(signal):
    """A signal of vectors from one of numbers."""
    if isinstance(signal, ancf.Table):
        rows = np.stack([signal.values, 0.0 * signal.values], axis=1)
        return ancf.Table(signal.times, rows, signal.outside, signal.smooth)
    if isinstance(signal, ancf.Sine):
        return ancf.Sine((signal.amplitude, 0.0), signal.frequency, signal.phase)
    if isinstance(signal, ancf.Pulse):
        return ancf.Pulse((signal.value, 0.0), signal.start, signal.end, signal.rise)
    if isinstance(signal, ancf.Ramp):
        return ancf.Ramp((signal.value, 0.0), signal.end, signal.start, signal.smooth)
    constant = (signal.constant, 0.0)
    return sum(map(along_x, signal.parts[1:]), along_x(signal.parts[0])) + constant


def displacement(signal):
    """Displacement of the particle at the end, by fine quadrature between all times."""
    corners = [t for t in signal.time_scale.times if 0.0 < t < T_END]
    nodes = np.unique(np.concatenate([np.linspace(0.0, T_END, 4001), corners]))
    x, weights = np.polynomial.legendre.leggauss(6)
    half = 0.5 * np.diff(nodes)[:, None]
    times = 0.5 * (nodes[1:] + nodes[:-1])[:, None] + half * x
    return float((half * weights * signal(times) * (T_END - times)).sum()) / 2.0


@pytest.mark.parametrize("name", SHORT)
def test_fixed_steps_say_which_signal_they_miss(name):
    scene, _ = particle(SHORT[name])
    with pytest.warns(UnresolvedSignalWarning, match=r"dt = 0\.001 s does not resolve") as caught:
        ancf.simulate(scene, T_END, DT)
    text = str(caught[0].message)
    assert len(caught) == 1
    assert "of the force on body 0" in text
    assert "take dt = " in text
    assert caught[0].filename == __file__


@pytest.mark.parametrize("name", LONG)
def test_resolved_signals_give_no_warning(name):
    scene, point = particle(LONG[name])
    run = ancf.simulate(scene, T_END, DT)
    # A jump has its effect up to half a step later.
    off = 0.5 * DT * abs(run.velocity(point)[:, 0]).max()
    assert run.position(point)[-1, 0] == pytest.approx(displacement(LONG[name]), rel=0.04, abs=off)


@pytest.mark.parametrize("seed", range(20))
def test_the_reported_error_is_that_of_the_velocity(seed):
    random = np.random.default_rng(seed)
    begin, length = random.uniform(0.02, 0.05), DT * 10 ** random.uniform(-2.0, 1.0)
    rise = 0.5 * length * random.choice([0.0, random.uniform()])
    pulse = ancf.Pulse(1.0, begin, begin + length, rise)
    scene, point = particle(pulse)
    error = impulse_error(signals_of(System(scene))[0], TimeGrid(0.0, DT), 100)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        run = ancf.simulate(scene, T_END, DT, integrator=ancf.Newmark(0.0))
    reached = 2.0 * run.velocity(point)[-1, 0] / (length - rise) - 1.0
    assert error >= abs(reached) - 1e-7
    if rise == 0.0:
        assert error == pytest.approx(abs(reached), abs=1e-7)
    assert bool(caught) == (error > MAX_IMPULSE_ERROR)


@pytest.mark.parametrize("name", SHORT | LONG)
@pytest.mark.parametrize("integrator", ["auto", ancf.GeneralizedAlpha(0.9), ancf.DormandPrince()])
def test_runs_to_an_accuracy_follow_every_signal(name, integrator):
    signal = (SHORT | LONG)[name]
    scene, point = particle(signal)
    run = ancf.simulate(scene, T_END, accuracy=1e-7, integrator=integrator)
    assert run.position(point)[-1, 0] == pytest.approx(displacement(signal), abs=1e-7)


@pytest.mark.parametrize(
    "angle",
    [
        ancf.Table([0.0501, 0.0503, 0.0505], [0, 0.01, 0], outside="hold", smooth=True),
        ancf.Ramp(0.01, 0.0509, 0.0501, smooth=True),
    ],
)
@pytest.mark.parametrize("driven", ["beam", "body"])
def test_driven_joints_follow_signals_too(driven, angle):
    scene = ancf.Scene(gravity=(0.0, 0.0))
    if driven == "body":
        box = ancf.Box(length=1.0, height=1.0, width=1.0)
        point = scene.add_body(box, mass=2.0, position=(0, 0)).at((0.0, 0.0))
    else:
        section, material = ancf.Circle(0.01), ancf.Material(1e7, 1000.0)
        point = scene.add_beam("thin", (0, 0), (1, 0), 2, section, material).start
    scene.drive_joint(scene.pin(point), angle, of="angle")
    with pytest.warns(UnresolvedSignalWarning, match=f"of the angle of .*{driven} 0"):
        ancf.simulate(scene, T_END, DT, max_energy_gain=np.inf)


@pytest.mark.parametrize(
    "motion", [ancf.Ramp((0.01, 0.0), 0.0509, 0.0501, smooth=True), ancf.Sine((1e-4, 0.0), 1000.0)]
)
def test_drives_of_points_follow_signals_too(motion):
    section, material = ancf.Circle(0.01), ancf.Material(1e7, 1000.0)
    scene = ancf.Scene(gravity=(0.0, 0.0))
    speed = motion.rate(0.0)
    rod = scene.add_beam("thin", (0, 0), (1, 0), 2, section, material, velocity=speed)
    scene.drive(rod.start, motion)
    with pytest.warns(UnresolvedSignalWarning, match="of the position of the drive at beam 0"):
        ancf.simulate(scene, T_END, DT, max_energy_gain=np.inf)


def test_ropes_follow_signals_too():
    """A rope was drawn in and paid out between two steps, and the end was 2.7 mm off."""
    length = 2.0**0.5 + ancf.Pulse(-0.5, 0.05012, 0.05018, rise=2e-5)
    scene = ancf.Scene(gravity=(0.0, -9.81))
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    rod = scene.add_beam("thin", (0, 0), (1, 0), 4, section, material)
    scene.pin(rod.start)
    scene.rope([(2.0, 1.0), rod.end], stiffness=1e3, length=length)
    with pytest.warns(UnresolvedSignalWarning, match="Pulse.* of the rope over .*beam 0 at s = 1"):
        coarse = ancf.simulate(scene, T_END, DT)
    ends = [
        run.position(rod.end)[-1]
        for run in (
            coarse,
            ancf.simulate(scene, T_END, 2e-6),
            ancf.simulate(scene, T_END, accuracy=1e-6),
        )
    ]
    assert np.abs(ends[0] - ends[1]).max() > 1e-3
    np.testing.assert_allclose(ends[2], ends[1], rtol=0.0, atol=1e-5)


def cantilever(signal, *mesh):
    """A soft cantilever with a force at its end."""
    scene = ancf.Scene(gravity=(0.0, 0.0))
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4000.0)
    element, n = mesh or ("auto", "auto")
    rod = scene.add_beam(element, (0, 0), (1, 0), n, section, material)
    scene.clamp(rod.start)
    scene.point_force(rod.end, signal)
    return scene, rod


@pytest.mark.parametrize(
    "signal",
    [
        ancf.Ramp((0.0, 1.0), 0.02002, 0.02),
        ancf.Pulse((0.0, 3.0), 0.02, 0.02002, rise=5e-6),
        ancf.Table([0.02, 0.02001, 0.02002], [(0, 0), (0, 3), (0, 0)], "hold", smooth=True),
    ],
)
def test_explicit_steps_resolve_a_short_signal_at_rest(signal):
    scene, rod = cantilever(signal, "thin", 4)
    runs = [
        ancf.simulate(scene, 0.05, accuracy=1e-6, integrator=integrator)
        for integrator in (ancf.CentralDifference(), ancf.GeneralizedAlpha(0.9))
    ]
    one, other = (run.position(rod.end) for run in runs)
    assert np.abs(one[-1] - (1.0, 0.0)).max() > 1e-5
    np.testing.assert_allclose(one, other, atol=2e-6)


@pytest.mark.parametrize(
    "signal",
    [
        ancf.Ramp((0.0, 30.0), 0.05015, 0.05012) - ancf.Ramp((0.0, 30.0), 0.05018, 0.05015),
        ancf.Sine((0.0, 3.0), 999.0),
    ],
)
@pytest.mark.parametrize(
    "integrator",
    [
        None,
        ancf.CentralDifference(),
        ancf.RungeKuttaNystrom(4),
        ancf.RungeKuttaNystrom(8),
        ancf.DormandPrince(),
    ],
)
def test_steps_shorten_until_they_balance_energy(signal, integrator):
    """Runs stopped, as energy is sampled at steps, and work is that of the trapezoidal rule."""
    scene, rod = cantilever(signal, "thin", 16)
    found = ancf.simulate(scene, T_END, accuracy=1e-6, integrator=integrator or "auto")
    method = {"integrator": ancf.RungeKuttaNystrom(8), "max_energy_gain": np.inf}
    exact = ancf.simulate(scene, T_END, accuracy=1e-8, **method)
    np.testing.assert_allclose(
        found.position(rod.end)[-1], exact.position(rod.end)[-1], rtol=0.0, atol=1e-6
    )
    assert found.stats.steps < 1e5


@pytest.mark.filterwarnings("ignore::ancfsparse.PlanChangedWarning")
@pytest.mark.parametrize(
    "signal",
    [
        ancf.Pulse((0.0, 30.0), 0.05012, 0.05018),
        ancf.Ramp((0.0, 30.0), 0.05015, 0.05012) - ancf.Ramp((0.0, 30.0), 0.05018, 0.05015),
        ancf.Sine((0.0, 3.0), 999.0),
    ],
)
def test_plans_have_steps_that_see_a_signal(signal):
    scene, rod = cantilever(signal)
    plan = ancf.plan(scene, T_END, ancf.position(rod.end), "10 %")
    assert T_END / plan.steps < signal.time_scale.shortest
    run = plan.run()
    if isinstance(signal, ancf.Sine):  # 16 elements have other frequencies near that of the force
        fine, exact = cantilever(signal, "thick", 200)
        end = ancf.modal_response(ancf.modes(fine, 40), T_END, T_END / 20000)
    else:
        fine, exact = cantilever(signal, "thin", 16)
        method = {"accuracy": 1e-6, "integrator": ancf.RungeKuttaNystrom(8)}
        end = ancf.simulate(fine, T_END, **method)
    end = end.position(exact.end)[-1]
    reached = run.position(run.system.scene.bodies[0].end)[-1]
    assert np.linalg.norm(reached - end) <= plan.predictions[0].tolerance


def test_plans_refuse_a_pulse_that_takes_too_many_steps():
    scene, rod = cantilever(ancf.Pulse((0.0, 1e3), 0.050121, 0.050122))
    with pytest.raises(InputError, match=r"changes within 1e-06 s.*use simulate with an accuracy"):
        ancf.plan(scene, T_END, ancf.position(rod.end), 1e-2)


@pytest.mark.parametrize("signal", [SHORT["pulse"], SHORT["alias"], SHORT["two ramps"]])
def test_equilibria_and_sums_of_modes_say_what_they_miss(signal):
    scene, _ = cantilever(along_x(signal), "thin", 4)
    with pytest.warns(UnresolvedSignalWarning):
        ancf.quasi_static(scene, T_END, DT)
    with pytest.warns(UnresolvedSignalWarning):
        ancf.modal_response(ancf.modes(scene, 2), T_END, DT)


def pulsed(length):
    scene, point = particle(ancf.Pulse(1.0, 0.0501, 0.0501 + length))
    return scene, point


def test_sweeps_say_which_points_miss_a_signal():
    pytest.importorskip("pandas")
    points = ancf.grid(length=[1e-4, 0.02])
    quantities = {"x": lambda run, point: run.position(point)[-1, 0]}
    with pytest.warns(UnresolvedSignalWarning) as caught:
        ancf.sweep(pulsed, points, quantities, T_END, workers=1, dt=DT)
    assert len(caught) == 1
    table = ancf.sweep(pulsed, points, quantities, T_END, workers=1, accuracy=1e-7)
    exact = [displacement(ancf.Pulse(1.0, 0.0501, 0.0501 + length)) for length in (1e-4, 0.02)]
    np.testing.assert_allclose(table["x"].to_numpy(), exact, atol=1e-7)


@pytest.mark.parametrize(
    "signal",
    [ancf.Pulse(1.0, 0.01, 0.01 + 1e-6), ancf.Pulse(1.0, 7.0, 7.0 + 1e-6), ancf.Ramp(1.0, 5.0)],
)
def test_times_outside_a_run_do_not_matter(signal):
    scene, point = particle(signal)
    begin = ancf.simulate(scene, 0.05, accuracy=1e-7).last
    fixed = ancf.simulate(scene, T_END, DT, start=begin)
    exact = ancf.simulate(scene, T_END, accuracy=1e-7, start=begin)
    assert fixed.position(point)[-1] == pytest.approx(exact.position(point)[-1], abs=1e-6)
    assert exact.stats.steps < 1000


def test_a_run_that_ends_in_the_first_steps_of_a_ramp_gives_no_warning():
    scene, _ = particle(ancf.Ramp(1.0, 0.005, smooth=True))
    for n in (1, 2, 3):
        ancf.simulate(scene, n * DT, DT)
