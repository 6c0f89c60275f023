"""Motions with forces of the caller's against formulas, and what happens where these fail."""

import ctypes as ct
import math

import numpy as np
import pytest
import scipy
from scipy.integrate import solve_ivp

import ancfsparse as ancf
from tests.solve.forces.carriers import carrier, oscillator

FORCE_TYPE = ct.CFUNCTYPE(
    ct.c_int,
    ct.c_ssize_t,
    *[ct.POINTER(ct.c_double)] * 2,
    ct.c_double,
    ct.POINTER(ct.c_double),
    ct.c_void_p,
)


def drag(q, v, t):
    return -0.8 * np.linalg.norm(v, axis=1)[:, None] * v


@FORCE_TYPE
def drag_in_c(n, q, v, t, force, data):
    for k in range(n):
        speed = math.hypot(v[2 * k], v[2 * k + 1])
        for d in range(2):
            force[2 * k + d] = -0.8 * speed * v[2 * k + d]
    return 0


@pytest.mark.parametrize(
    "integrator", [ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum(), ancf.DormandPrince()]
)
@pytest.mark.parametrize("function", [drag, scipy.LowLevelCallable(drag_in_c)])
def test_drag_slows_a_bar_as_the_formula_says(function, integrator):
    """m dv/dt = -2 b v^2 on two points: v = v0 / (1 + 2 b v0 t / m)."""
    scene, beam = carrier(1, 0.5, mass=4.0, stiffness=1e6, velocity=(10.0, 0.0))
    scene.force([beam.start, beam.end], function)
    run = ancf.simulate(scene, 1.0, 5e-4, integrator=integrator)
    expected = 10.0 / (1.0 + 2.0 * 0.8 * 10.0 / 4.0)
    along = run.system.places[0][:, 0]
    # The ends of the bar tremble, since the drag comes at once; its momentum does not.
    assert run.system.assembly.inertia(run.v[-1])[along].sum() / 4.0 == pytest.approx(
        expected, rel=1e-5
    )
    assert run.position(beam.start)[-1, 0] == pytest.approx(2.5 * math.log(5.0), rel=1e-5)
    assert run.energy.drift < 1e-4
    assert run.energy.work[-1] == pytest.approx(0.5 * 4.0 * (expected**2 - 100.0), rel=1e-4)


def test_an_accuracy_holds_for_springs_and_forces():
    scene, beam = oscillator(0.02, 400.0)
    scene.force(beam.start, lambda q, v, t: np.array([[0.1 * math.sin(5.0 * t), 0.0]]))
    run = ancf.simulate(scene, 1.0, accuracy=1e-6)
    omega, f = 10.0, 0.1 / 4.0
    forced = f / (omega**2 - 25.0)
    expected = forced * np.sin(5.0 * run.t) + (0.02 - 5.0 * forced) / omega * np.sin(omega * run.t)
    assert np.abs(run.position(beam.start)[:, 0] - expected).max() < 3e-6
    assert run.stats.error <= 1e-6


def test_only_dormand_prince_takes_a_force_of_the_velocities():
    scene, beam = carrier(1, 0.5, mass=4.0, stiffness=1e6)
    scene.force(beam.start, drag)
    with pytest.raises(ancf.InputError, match="depends on velocities: take DormandPrince"):
        ancf.simulate(scene, 0.1, 1e-5, integrator=ancf.CentralDifference())


def test_a_force_that_is_known_only_along_the_motion_is_not_tried_elsewhere():
    """To plan steps the loads of later times are tried out in the reference shape; not this one."""

    def function(q, v, t):
        assert abs(q[0, 0] - 0.5 - t) < 1e-3, "this force is known near the motion alone"
        return 0.0 * q

    scene, beam = carrier(1, 0.5, mass=4.0, stiffness=1e3, velocity=(1.0, 0.0))
    scene.force(beam.end, function)
    run = ancf.simulate(scene, 0.1, accuracy=1e-5)
    assert run.position(beam.end)[-1, 0] == pytest.approx(0.6, abs=1e-5)


def late(what):
    """A function that goes wrong at t = 0.05 s."""

    def function(q, v, t):
        return what(q) if t > 0.0499 else 0.0 * q

    return function


def broken(q):
    raise KeyError("pressure")


@pytest.mark.parametrize("integrator", [ancf.GeneralizedAlpha(0.9), ancf.DormandPrince()])
@pytest.mark.parametrize(
    ("what", "message"),
    [
        (broken, "KeyError: 'pressure'"),
        (lambda q: q * np.nan, "returned nan N along x at point 0"),
        (lambda q: q[0], r"returned shape \(2,\)"),
    ],
)
def test_a_force_that_fails_names_itself_and_keeps_the_motion(integrator, what, message):
    scene, beam = carrier(1, 0.5, mass=4.0, stiffness=1e3, velocity=(1.0, 0.0))
    scene.force(beam.end, late(what))
    with pytest.raises(ancf.LoadError, match=message) as caught:
        ancf.simulate(scene, 0.1, 1e-3, integrator=integrator, max_energy_gain=np.inf)
    text = str(caught.value)
    assert "the force on beam 0" in text
    assert "step 50" in text
    assert caught.value.time == pytest.approx(0.05, abs=1e-3)
    assert len(caught.value.trajectory.t) == 50
    assert caught.value.trajectory.position(beam.end)[-1, 0] == pytest.approx(0.549, abs=1e-9)


def test_a_c_function_that_returns_a_status_ends_the_run():
    @FORCE_TYPE
    def stuck(n, q, v, t, force, data):
        force[0] = force[1] = 0.0
        return 3 if t > 0.0499 else 0

    scene, beam = carrier(1, 0.5, mass=4.0, stiffness=1e3, velocity=(1.0, 0.0))
    scene.force(beam.end, scipy.LowLevelCallable(stuck))
    with pytest.raises(ancf.LoadError, match="it returned 3; that was in step 50"):
        ancf.simulate(scene, 0.1, 1e-3)


def test_a_force_law_that_fails_names_its_spring_and_the_elongation():
    def limited(e):
        if e > 0.05:
            raise ValueError("the cable breaks")
        return 10.0 * e

    scene, beam = carrier(1, 0.5, mass=4.0, stiffness=1e3, velocity=(1.0, 0.0))
    scene.spring(beam.start, (-1.0, 0.0), stiffness=limited)
    with pytest.raises(ancf.LoadError, match=r"force law of the spring .* the cable breaks") as e:
        ancf.simulate(scene, 0.1, 1e-3)
    assert "an elongation of 0.05" in str(e.value)
    assert 49 <= len(e.value.trajectory.t) <= 52


def test_an_interruption_inside_a_force_is_one_of_the_run():
    def interrupted(q):
        raise KeyboardInterrupt

    scene, beam = carrier(1, 0.5, mass=4.0, stiffness=1e3, velocity=(1.0, 0.0))
    scene.force(beam.end, late(interrupted))
    with pytest.raises(KeyboardInterrupt) as caught:
        ancf.simulate(scene, 0.1, 1e-3)
    assert len(caught.value.trajectory.t) == 50


@pytest.mark.parametrize(
    ("coupled", "size", "dt", "most"),
    [(True, size, dt, 1.12) for size in (1.0, 4.0, 16.0) for dt in (1e-3, 5e-3, 0.02)]
    + [(False, 4.0, 1e-3, 1.5)],
)
def test_a_follower_force_costs_few_iterations_more(coupled, size, dt, most):
    """A thrust along the end of a beam, against one that keeps its direction."""
    counts = []
    for follows in (False, True):
        scene = ancf.Scene(gravity=(0.0, 0.0))
        section, material = ancf.Rectangle(0.02, 0.02), ancf.Material(1e8, 1000.0)
        beam = scene.add_beam("l2t2", (0, 0), (1, 0), 8, section, material)
        scene.clamp(beam.start)

        def thrust(q, v, t, follows=follows):
            along = (q[1] - q[0]) / np.linalg.norm(q[1] - q[0]) if follows else np.array([1.0, 0.0])
            return np.array([[0.0, 0.0], np.array([0.0, 1.0]) - size * along])

        scene.force([beam.node(7), beam.end], thrust, coupled=coupled)
        run = ancf.simulate(scene, 0.5, dt)
        assert np.abs(run.position(beam.end)[-1, 1]) > 1e-3
        counts.append(run.stats.residual_evaluations)
    assert counts[1] < most * counts[0]


@pytest.mark.parametrize("law", ["stiffening spring", "drag"])
def test_a_first_motion_in_steps_too_long_may_overflow_a_function(law):
    """It led to elongations of 1e112 m, where the run to an accuracy ended."""

    def pull(e):
        return 400.0 * e + 5e4 * e**3

    scene = ancf.Scene((0.0, 0.0, -9.81))
    velocity = (0.0, 0.7, 0.0) if law != "drag" else (20.0, 0.0, 30.0)
    body = scene.add_body(ancf.Sphere(0.1), position=(1, 0, 0), mass=1.0, velocity=velocity)
    if law == "drag":
        scene.force(body.origin, drag)
    else:
        scene.spring(body.origin, (0, 0, 0), stiffness=pull, length=1.0)
    with np.errstate(over="ignore", invalid="ignore"):
        run = ancf.simulate(scene, 2.0, accuracy=1e-6)

    def rates(_, y):
        x, v = y[:3], y[3:]
        stretched = np.linalg.norm(x)
        spring = -pull(stretched - 1.0) * x / stretched
        force = drag(None, v[None], 0.0)[0] if law == "drag" else spring
        return np.concatenate([v, force + np.array([0.0, 0.0, -9.81])])

    options = {"t_eval": run.t, "method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    exact = solve_ivp(rates, (0.0, 2.0), [1.0, 0.0, 0.0, *velocity], **options).y[:3].T
    assert np.linalg.norm(run.position(body.origin) - exact, axis=1).max() < 1e-6


def test_a_function_that_always_fails_ends_a_run_to_an_accuracy_with_its_error():
    """Shorter steps do not help it: what it raised is the cause, and states before are kept."""

    def push(x, v, t):
        if t > 1.0:
            raise ArithmeticError("no more thrust")
        return np.zeros_like(x)

    scene = ancf.Scene((0.0, -9.81))
    body = scene.add_body(ancf.Rod(1.0), position=(0, 0), mass=1.0)
    scene.pin(body.origin)
    scene.force(body.end, push)
    with pytest.raises(ancf.LoadError, match="no more thrust") as caught:
        ancf.simulate(scene, 2.0, accuracy=1e-6)
    assert 0.5 < caught.value.trajectory.t[-1] <= 1.0
