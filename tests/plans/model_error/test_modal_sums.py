"""Plans that sum modes where motions are small, beside motions on fine meshes."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.plans.quantities.tolerances import check_goals
from ancfsparse.plans.selection import method_selection
from ancfsparse.plans.trial_runs.load_resolution import steps_resolving_loads
from ancfsparse.plans.trial_runs.solution_methods import ModalSum, SolutionMethod
from ancfsparse.system import System
from tests.beams import build_beam
from tests.plans.comparison import (
    DAMPED,
    distance_from_shorter_steps,
    largest_distance,
)

THIN, SOFT = ancf.Circle(0.004), ancf.Material(1e9, 1000)


def let_go(force, element="thin", n=8):
    """A cantilever under a sudden force."""
    scene, rod = build_beam(element, (0, 0), (1, 0), n, THIN, SOFT, "clamp", gravity=(0.0, 0.0))
    scene.point_force(rod.end, (0.0, -force))
    return scene, rod.end


def held(force, element="thin", n=8):
    """The same, clamped at both ends: what bends it stretches it."""
    scene, rod = build_beam(
        element, (0, 0), (1, 0), n, THIN, SOFT, "clamp", "clamp", gravity=(0.0, 0.0)
    )
    scene.point_force(rod.at(0.5), (0.0, -force))
    return scene, rod.at(0.5)


def thrown(speed, element="thin", n=8):
    """A cantilever whose points begin with speeds that grow along it."""

    def velocity(r):
        return speed * r[:, :1] ** 2 * np.array([[0.0, 1.0]])

    scene, rod = build_beam(
        element, (0, 0), (1, 0), n, THIN, SOFT, "clamp", gravity=(0.0, 0.0), velocity=velocity
    )
    return scene, rod.end


def off(run, point, made, size):
    """Return how far a run is from the motion of 16 elements in steps of 1 ms."""
    division = round(run.t[1] / 1e-3)
    fine = made(size, "thin", 16)
    return distance_from_shorter_steps(run, point, *fine, division, integrator=ancf.Newmark())


@pytest.mark.parametrize("time", [2.0, 10.0])
@pytest.mark.parametrize(("made", "size"), [(let_go, 1e-3), (held, 1e-3), (thrown, 0.1)])
def test_what_a_sum_of_modes_leaves_out(made, size, time):
    scene, point = made(size)
    method = ModalSum(8)
    run = method.solve(scene, time, 400)
    truth = off(run, point, made, size)
    error_model = sum(method.neglected(run, ancf.position(point)).values())
    assert truth / 1.1 <= error_model <= 10.0 * truth


@pytest.mark.parametrize(("made", "size", "time"), [(let_go, 2e-5, 60.0), (thrown, 5e-3, 120.0)])
def test_small_motions_are_sums_of_modes(made, size, time):
    scene, point = made(size, "auto", "auto")
    plan = ancf.plan(scene, time, ancf.position(point), "1 %")
    assert isinstance(plan.integrator, ModalSum)
    assert "the motion is small" in str(plan)
    run = plan.run(verify=True)
    asked = plan.predictions[0].tolerance
    assert off(run, point, made, size) <= asked
    assert run.measured[0] <= asked


def test_large_motions_are_marched():
    scene, point = let_go(0.01, "auto", "auto")
    plan = ancf.plan(scene, 2.0, ancf.position(point), "3 %")
    assert plan.integrator == DAMPED


def test_what_modes_do_not_have_is_marched():
    def fits(scene, quantity, start=None):
        return ModalSum.fit(System(scene), 60.0, check_goals([quantity], "3 %"), start) is not None

    scene, point = let_go(1e-4)
    assert fits(scene, ancf.position(point))
    assert not fits(scene, ancf.reaction(point))
    loaded, point = let_go(1e-4)  # it rests where the load has moved it to
    assert not fits(loaded, ancf.position(point), "equilibrium")
    driven, point = let_go(1e-4)
    driven.drive(point, (1.0, 0.01))
    assert not fits(driven, ancf.position(point))
    still, point = let_go(0.0)
    assert not fits(still, ancf.position(point))
    falling, rod = build_beam("thin", (0, 0), (1, 0), 4, THIN, SOFT, "pin")
    assert not fits(falling, ancf.position(rod.end))


def test_modes_that_are_left_out_are_counted():
    scene, _ = let_go(1e-4)
    rod = scene.beams[0]
    point = rod.at(0.3)
    scene.point_force(point, (0.0, 1e-4))
    full = ModalSum(12).solve(scene, 10.0, 400)
    for n in (1, 4, 8):
        method = ModalSum(n)
        run = method.solve(scene, 10.0, 400)
        truth = largest_distance(run.position(point), full.position(point))
        assert 0.5 * truth <= method.neglected(run, ancf.position(point))["modes"] <= 4.0 * truth


def hanging(element, n):
    """A cable that hangs at its pins and is plucked slowly, eight times as fast as shown."""
    made = ancf.Circle(0.01), ancf.Material(1e8, 1000)
    scene, cable = build_beam(element, (0, 0), (1, 0), n, *made, "pin", "pin", length=1.2)
    point = cable.at(0.6)
    scene.point_force(point, lambda t: (0.0, 2e-3 * np.sin(4.0 * t) ** 2))
    return scene, point


def taut(element, n):
    """A taut line that is clamped, sags by its weight, and is pushed beside its middle."""
    scene, line = build_beam(element, (0, 0), (1, 0), n, THIN, SOFT, "clamp", "clamp", tension=20.0)
    point = line.at(0.4 * line.length)
    scene.point_force(point, lambda t: (0.0, 2e-3 * np.sin(20.0 * t) ** 2))
    return scene, point


def far_from_steps(run, point, made, n, dt):
    """Return how far a run is from the motion of n elements in short steps."""
    division = -(-round(run.t[-1] / dt) // (len(run.t) - 1))
    given = {"integrator": ancf.Newmark(), "start": "equilibrium"}
    return distance_from_shorter_steps(run, point, *made("thin", n), division, **given)


@pytest.mark.parametrize(("made", "time", "dt"), [(hanging, 5.0, 5e-4), (taut, 1.0, 5e-5)])
def test_sums_of_modes_about_an_equilibrium(made, time, dt):
    scene, point = made("thin", 8)
    method = ModalSum(16, start="equilibrium")
    run = method.solve(scene, time, 512)
    size = largest_distance(run.position(point), run.position(point)[0])
    left = sum(method.neglected(run, ancf.position(point)).values())
    truth = far_from_steps(run, point, made, 8, dt)
    assert truth <= 0.01 * size
    assert left >= 0.5 * truth - 0.002 * size  # what steps err by
    assert left <= 0.02 * size


def test_a_small_motion_about_an_equilibrium_is_planned_as_a_sum_of_its_modes(monkeypatch):
    """Where time integration has no plan; it takes less work here."""
    select = method_selection.select_model

    def fail_with_steps(trials, *arguments):
        if not isinstance(trials.integrator, SolutionMethod):
            raise ancf.PlanError("position", 1e-3, 2e-3, "m", 4, 1.5)
        return select(trials, *arguments)

    monkeypatch.setattr(method_selection, "select_model", fail_with_steps)
    scene, point = hanging("auto", "auto")
    plan = ancf.plan(scene, 20.0, ancf.position(point), "2 %", start="equilibrium")
    assert isinstance(plan.integrator, ModalSum)
    assert "sum of modes about the equilibrium at which it starts" in str(plan)
    run = plan.run()
    assert far_from_steps(run, point, hanging, 24, 1e-3) <= plan.predictions[0].tolerance


def test_the_pace_of_loads_is_followed():
    """Steps of a whole period see a load that rests."""
    scene, point = let_go(0.0)
    assert steps_resolving_loads(System(scene), 8.0, 100) == 100
    scene.point_force(point, lambda t: (0.0, np.sin(2.0 * np.pi * 25.0 * t)))
    steps = steps_resolving_loads(System(scene), 8.0, 100)
    assert 6 * 25 * 8 <= steps <= 4 * 6 * 25 * 8
    struck, point = let_go(0.0)
    struck.point_force(point, ancf.Pulse((0.0, 1.0), 1.0, 1.05))
    assert 4 * 8.0 / 0.05 <= steps_resolving_loads(System(struck), 8.0, 100) <= 32 * 8.0 / 0.05


def test_trial_runs_do_not_mistake_a_fast_load_for_a_slow_one():
    """A load of 12.7 Hz on a cantilever of 1.4 Hz: steps of 50 ms see one of 7.3 Hz."""

    def build_model(element, n):
        made = ancf.Circle(0.01), ancf.Material(1e9, 1000)
        scene, rod = build_beam(element, (0, 0), (1, 0), n, *made, "clamp", gravity=(0.0, 0.0))
        scene.point_force(rod.end, lambda t: (0.0, -0.01 * np.sin(40.0 * t) ** 2))
        return scene, rod.end

    scene, end = build_model("auto", "auto")
    plan = ancf.plan(scene, 5.0, ancf.position(end), "5 %", integrator=DAMPED)
    run = plan.run()
    division = -(-10000 // (len(run.t) - 1))
    apart = distance_from_shorter_steps(run, end, *build_model("thin", 16), division)
    assert plan.steps >= 400
    assert apart <= plan.predictions[0].tolerance


def test_a_taut_line_pushed_at_a_point_is_a_sum_of_modes():
    """Ten seconds of a line of 63 Hz under 3 Hz, beside the series of a stiff string."""
    tension, frequency, force, at, t_end = 200.0, 3.0, 0.05, 0.3, 10.0
    scene = ancf.Scene((0.0, 0.0))
    section, material = ancf.Circle(0.004), ancf.Material(2e9, 1000.0)
    line = scene.add_beam("thin", (0, 0), (1, 0), "auto", section, material, tension=tension)
    scene.pin(line.start)
    scene.pin(line.end)
    point = line.at(at)
    scene.point_force(point, ancf.Sine((0.0, force), frequency=frequency))
    plan = ancf.plan(scene, t_end, ancf.position(point), "3 %")
    assert isinstance(plan.integrator, ModalSum)
    assert plan.is_met
    run = plan.run()
    area, inertia = section.area, section.inertia_z
    mass = 1000.0 * area / (1.0 + tension / (2e9 * area))
    k = np.pi * np.arange(1, 200)
    omega = k * np.sqrt((tension + 2e9 * inertia * k**2) / mass)
    push = 2.0 * np.pi * frequency
    shape = 2.0 * force * np.sin(k * at) ** 2 / (mass * (omega**2 - push**2))
    t = run.t[:, None]
    exact = (np.sin(push * t) - push / omega * np.sin(omega * t)) @ shape
    off = np.abs(run.position(point)[:, 1] - exact).max()
    assert off <= plan.predictions[0].tolerance


def test_vibrations_drift_where_the_mean_displacement_changes_the_stiffness():
    """Differences after 6 s that do not grow belong to the modes left out, or to the steps."""
    scene, point = hanging("thin", 8)
    method = ModalSum(16, start="equilibrium")
    run = method.solve(scene, 40.0, 4096)
    dt = 40.0 / 4096 / 20
    fine = ancf.simulate(scene, 40.0, dt, save_every=20, integrator=ancf.Newmark(),
                         start="equilibrium")  # fmt: skip
    distances = np.linalg.norm(run.position(point) - fine.position(point), axis=1)
    grown = distances.max() - distances[:600].max()
    left = method.neglected(run, ancf.position(point))["nonlinearity"]
    assert 0.5 * grown <= left <= 4.0 * grown
