"""Steps gain no energy in an impact: those of Newmark's family are repeated without memory."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from tests.solve.contact.test_contact_motion import FLOOR, LINE_MASS, MATERIAL, SECTION, level

NEWMARKS = [
    *(ancf.Newmark(0.0), ancf.Newmark(0.1), ancf.HHT(0.1)),
    *(ancf.GeneralizedAlpha(0.9), ancf.GeneralizedAlpha(0.5), ancf.GeneralizedAlpha(0.0)),
]


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9])
@pytest.mark.parametrize("integrator", [*NEWMARKS, ancf.EnergyMomentum()], ids=repr)
def test_a_body_that_begins_close_to_the_floor_returns_no_more_energy(integrator, stiffness, dt):
    """It touches in the first step, or in the second one; up to 9 times as much came back."""
    for share in (0.1, 0.4, 0.9, 1.3):  # of the way of a step
        height, speed = 3.0 * dt * share, 3.0
        scene, rod, _ = level(height, stiffness, velocity=(0.0, -speed))
        steps = max(12, round(0.02 / dt) if stiffness < 1e6 else 0)
        run = ancf.simulate(scene, steps * dt, dt, integrator=integrator, tolerance=1e-10)
        y, v = run.position(rod.at(0.5))[:, 1] - 0.005, run.velocity(rod.at(0.5))[:, 1]
        returned = (0.5 * v**2 + 9.81 * y)[3:].max() / (0.5 * speed**2 + 9.81 * height)
        assert returned < 1.0001


EXPLICIT = [
    *(ancf.CentralDifference(), ancf.DormandPrince()),
    *(ancf.RungeKuttaNystrom(4), ancf.RungeKuttaNystrom(8)),
]


def returned_energy(height, stiffness, dt, integrator):
    """Return the energy of a level rebound over that of the fall, and the run."""
    scene, rod, _ = level(height, stiffness)
    fall = math.sqrt(2.0 * height / 9.81)
    run = ancf.simulate(scene, round(1.8 * fall / dt) * dt, dt, integrator=integrator)
    y, v = run.position(rod.at(0.5))[:, 1] - 0.005, run.velocity(rod.at(0.5))[:, 1]
    return (0.5 * v**2 + 9.81 * y)[run.t > fall + 0.02].max() / (9.81 * height), run


@pytest.mark.parametrize("integrator", EXPLICIT, ids=repr)
def test_explicit_steps_gain_no_energy_in_impacts(integrator):
    """From several phases; up to 1.01 of the energy came back, or the run was stopped."""
    for share, least in ((0.05, 0.999), (0.2, 0.99), (0.4, 0.97), (1.5, 0.3)):
        stiffness = 1e6 if share < 0.4 else 1e8 if share > 1.0 else 1e7
        dt = share / math.sqrt(stiffness / LINE_MASS)
        for height in (0.5, 0.507, 0.52):
            if share == 1.5 and isinstance(integrator, ancf.DormandPrince) and height != 0.507:
                continue  # it gains 1 % until the largest penetration, which stops the run
            returned, _ = returned_energy(height, stiffness, dt, integrator)
            assert least < returned < 1.0001


@pytest.mark.parametrize("integrator", EXPLICIT, ids=repr)
@pytest.mark.parametrize(("stiffness", "largest"), [(1e5, 0.09), (1e9, 0.4)])
def test_explicit_steps_gain_no_energy_in_soft_and_stiff_impacts(stiffness, largest, integrator):
    """They begin just above the floor, since a fall takes a million steps with 1e9 N/m2."""
    period = 2.0 * math.pi / math.sqrt(stiffness / LINE_MASS)
    for share in (0.05, 0.2 * largest, largest):
        least = 1.0 - 0.2 * share**2 - 1e-4
        dt = share / math.sqrt(stiffness / LINE_MASS)
        for phase in (0.0, 0.3, 0.7):
            height, speed = (4.0 + phase) * 3.0 * dt, 3.0
            scene, rod, _ = level(height, stiffness, velocity=(0.0, -speed))
            steps = 12 + round(period / dt)
            run = ancf.simulate(scene, steps * dt, dt, integrator=integrator)
            y, v = run.position(rod.at(0.5))[:, 1] - 0.005, run.velocity(rod.at(0.5))[:, 1]
            returned = 0.5 * v[-1] ** 2 + 9.81 * y[-1]
            assert v[-1] > 0.0
            assert least < returned / (0.5 * speed**2 + 9.81 * height) < 1.0001


def test_explicit_steps_without_a_limit_of_the_energy_are_not_changed():
    """Then the energy of an impact depends on its phase, in either direction."""
    dt = 0.2 / math.sqrt(1e6 / LINE_MASS)
    ratios = []
    for height in (0.5, 0.507, 0.513, 0.52):
        scene, rod, _ = level(height, 1e6)
        fall = math.sqrt(2.0 * height / 9.81)
        run = ancf.simulate(
            scene, round(1.8 * fall / dt) * dt, dt, integrator=ancf.CentralDifference(),
            max_energy_gain=math.inf,
        )  # fmt: skip
        y, v = run.position(rod.at(0.5))[:, 1] - 0.005, run.velocity(rod.at(0.5))[:, 1]
        ratios.append((0.5 * v**2 + 9.81 * y)[-1] / (9.81 * height))
    assert max(ratios) > 1.002


@pytest.mark.parametrize(
    ("integrator", "bound"),
    [(ancf.CentralDifference(), 1e-5), (ancf.DormandPrince(), 1e-3)],
    ids=repr,
)
def test_a_rigid_ball_that_falls_on_a_pinned_cable_gains_no_energy(integrator, bound):
    """The impulses act on the body of the obstacle too; 1 % and .27 % were gained."""
    for height in (0.02, 0.0213):
        scene = ancf.Scene((0.0, 0.0, -9.81))
        cable = scene.add_beam("thin", (-0.4, 0, 0), (0.4, 0, 0), 12, SECTION, MATERIAL)
        scene.pin(cable.start)
        scene.pin(cable.end)
        place = (0.0, 0.0, 0.055 + height)
        ball = scene.add_body(mass=0.05, inertia=(5e-5, 5e-5, 5e-5), position=place)
        scene.contact(cable, ancf.Ball(place, 0.05), on=ball, stiffness=1e8)
        run = ancf.simulate(scene, 0.15, 5e-5, integrator=integrator)
        energy, touches = run.energy.total - run.energy.total[0], run.energy.contact > 0.0
        assert touches.any()
        assert energy[~touches].max() < bound * run.energy.kinetic.max()


@pytest.mark.parametrize("integrator", EXPLICIT[:2], ids=repr)
def test_an_explicit_run_that_is_interrupted_in_an_impact_is_one_run(integrator):
    """The energy gained so far is part of the state."""
    dt, options = 0.4 / math.sqrt(1e7 / LINE_MASS), {"integrator": integrator}

    def near():
        return level(1e-3, 1e7, velocity=(0.0, -3.0))[0]

    whole = ancf.simulate(near(), 40 * dt, dt, **options)
    for steps in range(3, 18, 2):
        scene = near()
        first = ancf.simulate(scene, steps * dt, dt, **options)
        second = ancf.simulate(scene, 40 * dt, dt, start=first.last, **options)
        assert np.array_equal(second.q[-1], whole.q[-1])


def test_a_repeated_step_remembers_no_acceleration():
    """q1 - q0 = dt (v0 + v1) / 2 and v1 - v0 = dt a1, as for beta = 1/2 and gamma = 1."""
    dt = 1e-3
    scene, _, _ = level(1e-4, 1e9, velocity=(0.0, -3.0))
    run = ancf.simulate(scene, 8 * dt, dt, integrator=ancf.GeneralizedAlpha(0.5), tolerance=1e-10)
    repeated = [each.step for each in run.stats.events if each.cause == "gained energy"]

    def errors(k):
        way = run.q[k] - run.q[k - 1] - 0.5 * dt * (run.v[k - 1] + run.v[k])
        change = run.v[k] - run.v[k - 1] - dt * run.a[k]
        return np.abs(way).max() / (3.0 * dt), np.abs(change).max() / 3.0

    assert repeated
    assert 1 not in repeated
    assert min(errors(1)) > 1e-2  # the impact itself, by the formulas of the integrator
    for k in repeated:
        assert max(errors(k)) < 1e-9


@pytest.mark.parametrize("integrator", NEWMARKS[:4:3], ids=repr)
def test_steps_that_are_divided_in_an_impact_gain_no_energy(integrator):
    """A tilted cable on a stiff floor, whose steps a solver of few corrections divides."""
    slope, height = 0.1, 0.1
    scene = ancf.Scene((0.0, -9.81))
    end = (math.cos(slope), height + math.sin(slope))
    rod = scene.add_beam("thin", (0.0, height), end, 8, SECTION, MATERIAL)
    scene.contact(rod, FLOOR, stiffness=1e9)
    solver = ancf.QuasiNewton("bfgs", 5, max_iterations=3)
    run = ancf.simulate(scene, 0.4, 1e-3, integrator=integrator, solver=solver, max_halvings=8)
    assert run.stats.short_steps > 50
    energy = run.energy.total - run.energy.total[0]
    assert energy.max() < 1e-4 * LINE_MASS * 9.81 * height


@pytest.mark.parametrize("integrator", NEWMARKS[:4:3], ids=repr)
def test_a_run_that_is_interrupted_between_repeated_steps_is_one_run(integrator):
    """The number of steps since an impact is part of the state."""
    options = {"integrator": integrator, "solver": ancf.Newton()}

    def near():
        return level(1e-4, 1e9, velocity=(0.0, -3.0))[0]

    whole = ancf.simulate(near(), 0.012, 1e-3, **options)
    assert any(each.cause == "gained energy" for each in whole.stats.events)
    for steps in range(1, 6):
        scene = near()
        first = ancf.simulate(scene, steps * 1e-3, 1e-3, **options)
        second = ancf.simulate(scene, 0.012, 1e-3, start=first.last, **options)
        assert np.array_equal(second.q[-1], whole.q[-1])
