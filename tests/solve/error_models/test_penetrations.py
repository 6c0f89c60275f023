"""Warnings of deep penetrations, in motions and equilibria, on obstacles and between beams."""

import math
import re
import warnings

import numpy as np
import pytest

import ancfsparse as ancf

LENGTHS = 1e-3, 10.0  # of the rods [m]
DENSITY = 5e3  # [kg/m3]
GRAVITY = 9.81  # [m/s2]
SPRING_DEPTH = 1.8  # over the radius
SOLVERS = "solve_static", "quasi_static", "load_path"


def rod(scene, length, y):
    radius = length / 100.0
    section, material = ancf.Circle(2.0 * radius), ancf.Material(1e13, DENSITY)
    return scene.add_beam("thin", (0.0, y), (length, y), 2, section, material)


def lying(length, kind, depth, factor=1.0):
    """Return a scene of a rod on a held rod or on a block, and its weight per length [N/m].

    At rest it sinks in by a depth over the radius, if the stiffness is not increased by a factor.
    Springs, by which alone it would sink in by SPRING_DEPTH, lead equilibria to this one.
    """
    scene, radius = ancf.Scene((0.0, -GRAVITY)), length / 100.0
    upper = rod(scene, length, 2.0 * radius)
    weight = math.pi * radius**2 * DENSITY * GRAVITY
    of_springs = weight / (SPRING_DEPTH * radius)
    stiffness = factor * (weight / (depth * radius) - of_springs)
    if kind == "rod":
        lower = rod(scene, length, 0.0)
        for s in (0.0, 0.5, 1.0):
            scene.pin(lower.at(s * length))
        scene.contact(lower, upper, stiffness=stiffness)
    else:
        size = (1.2 * length, length)
        block = ancf.Block((0.5 * length, radius - 0.5 * length), size)
        scene.contact(upper, block, stiffness=stiffness, radius=radius)
    top = 2.0 * radius
    for end, place in (
        (upper.start, (-length, top)),
        (upper.start, (0.0, length)),
        (upper.end, (length, length)),
    ):
        scene.spring(end, place, stiffness=0.5 * length * of_springs)
    return scene, weight


def half_period(length, depth):
    """Return half a period of a rod that sinks in by a depth over the radius at rest [s]."""
    return math.pi * math.sqrt(depth * length / 100.0 / GRAVITY)


def warned(call):
    """Return the numbers of the only warning of a call, None without a warning."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        call()
    if not caught:
        return None
    (warning,) = caught
    assert warning.category is ancf.PenetrationWarning
    assert warning.filename == __file__
    numbers = re.fullmatch(
        r"the contact of beam \d with .* has a penetration of (\S+) m, (\S+) times the radius of "
        r"(\S+) m, at (?:t = |the load factor )(\S+?)(?: s)?, at .* s = .*: the .* stiffness of "
        r"(\S+) N/m2 .*\. Give contact the stiffness=(\S+)",
        str(warning.message),
    )
    assert numbers, str(warning.message)
    return tuple(map(float, numbers.groups()))


@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("kind", ["rod", "block"])
@pytest.mark.parametrize("integrator", [ancf.EnergyMomentum(), ancf.GeneralizedAlpha(0.9)])
def test_a_motion_that_sinks_in_deeper_than_the_radius_is_reported(length, kind, integrator):
    """Released at the touch it sinks in twice as deep as at rest, after half a period."""

    def run(depth=0.75, factor=1.0):
        scene, _ = lying(length, kind, depth, factor)
        step = half_period(length, depth) / 50.0 / math.sqrt(factor)
        return warned(lambda: ancf.simulate(scene, 60 * step, step, integrator=integrator))

    depth, ratio, radius, t, stiffness, enough = run()
    assert radius == pytest.approx(length / 100.0)
    assert ratio == pytest.approx(1.5, rel=0.01)
    assert depth == pytest.approx(ratio * radius, rel=0.01)
    assert t == pytest.approx(half_period(length, 0.75), rel=0.03)
    assert run(depth=0.45) is None
    assert enough / stiffness == pytest.approx(150.0 ** (2.5 if kind == "rod" else 2.0), rel=0.05)
    assert run(factor=enough / stiffness) is None


@pytest.mark.parametrize("length", LENGTHS)
@pytest.mark.parametrize("kind", ["rod", "block"])
@pytest.mark.parametrize("solve", SOLVERS)
def test_an_equilibrium_deeper_than_the_radius_is_reported(length, kind, solve):
    """Loads that grow press it in deepest at the end."""

    def run(depth, factor=1.0):
        scene, weight = lying(length, kind, depth, factor)
        if solve == "quasi_static":
            scene.distributed_force(scene.beams[0], lambda t: (0.0, -0.2 * t * weight))
        call = {
            "solve_static": lambda: ancf.solve_static(scene, t=0.25),
            "quasi_static": lambda: ancf.quasi_static(scene, 1.0, 0.25),
            "load_path": lambda: ancf.load_path(scene),
        }
        return warned(call[solve])

    depth, ratio, radius, at, stiffness, enough = run(1.5)
    assert ratio == pytest.approx(1.8 if solve == "quasi_static" else 1.5, rel=0.02)
    assert depth == pytest.approx(ratio * radius, rel=0.01)
    assert at == (0.25 if solve == "solve_static" else 1.0)
    assert run(0.8) is None
    assert run(1.5, enough / stiffness) is None


@pytest.mark.parametrize("length", LENGTHS)
def test_a_default_stiffness_is_reported_at_rest_from_three_per_cent_of_the_radius(length):
    """The weight alone causes half a percent; the stiffness does not consider functions of time."""

    def run(load, stiffness=None):
        scene, radius = ancf.Scene((0.0, -GRAVITY)), length / 100.0
        cable = rod(scene, length, radius)
        scene.contact(cable, ancf.HalfSpace((0.0, 0.0), (0.0, 1.0)), stiffness=stiffness)
        scene.spring(cable.start, (-length, radius), stiffness=1e-3 * GRAVITY)
        weight = math.pi * radius**2 * DENSITY * GRAVITY
        scene.distributed_force(cable, lambda t: (0.0, -t * weight))
        return warned(lambda: ancf.solve_static(scene, t=load))

    assert run(4.0) is None
    depth, ratio, radius, _, stiffness, enough = run(7.0)
    assert ratio == pytest.approx(0.04, rel=0.1)
    assert enough == pytest.approx(ratio / 0.01 * stiffness, rel=0.05)
    assert depth == pytest.approx(ratio * radius, rel=0.1)
    assert run(7.0, enough) is None


def test_a_run_that_continues_another_does_not_repeat_its_warning():
    scene, step = lying(10.0, "rod", 0.75)[0], half_period(10.0, 0.75) / 50.0
    settings = {"integrator": ancf.EnergyMomentum()}
    first = []
    assert warned(lambda: first.append(ancf.simulate(scene, 90 * step, step, **settings)))
    (run,) = first
    assert warned(lambda: ancf.simulate(scene, 96 * step, step, start=run.last, **settings)) is None


def test_a_run_with_few_saved_points_is_reported_without_a_time():
    scene, step = lying(10.0, "rod", 0.75)[0], half_period(10.0, 0.75) / 50.0
    point = scene.beams[0].start
    with pytest.warns(ancf.PenetrationWarning, match="m, in the run at beam . at s = "):
        run = ancf.simulate(scene, 60 * step, step, save_nodes=[point], save_every=60)
    assert np.shape(run.t) == (2,)


@pytest.mark.parametrize("n", [1, 60])
def test_a_simulation_warns_once_after_the_step_that_is_too_deep(n):
    scene, step = lying(10.0, "rod", 0.75)[0], half_period(10.0, 0.75) / 50.0
    sim = ancf.Simulation(scene, step)
    times = []
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        for _ in range(180 // n):
            sim.step(n)
            times += [sim.t] * (len(caught) > len(times))
    (warning,) = caught
    assert warning.category is ancf.PenetrationWarning
    assert f"before t = {times[0]:.4g} s, at beam" in str(warning.message)
    assert warning.filename == __file__


@pytest.mark.parametrize("kind", ["rod", "block"])
def test_steps_that_are_repeated_do_not_lose_the_deepest_point(kind):
    """A repetition begins anew, and restores the internal variables of an earlier state."""
    scene, step = lying(10.0, kind, 0.4)[0], half_period(10.0, 0.4) / 50.0
    run = ancf.simulate(scene, 60 * step, step, integrator=ancf.EnergyMomentum())
    assembly = run.system.assembly
    (contact,) = (each for each in run.system.contributions if each.is_contact)
    deepest, memory = contact.deepest_of_motion, assembly.memory
    assert deepest[0] == pytest.approx(0.8 * 0.1, rel=0.02)
    assembly.begin(run.q[0])
    assert contact.deepest_of_motion[0] == 0.0
    assembly.memory = memory
    assert contact.deepest_of_motion == deepest


def test_the_deepest_of_several_pairs_is_that_with_the_largest_ratio_to_the_smaller_radius():
    scene, stiffness = ancf.Scene(), 2e4
    lower, upper, depths = [], [], []
    for k, (below, above, speed) in enumerate(((0.02, 0.02, 3.3), (0.06, 0.002, 5.3))):
        for side, radius, y in ((lower, below, 0.0), (upper, above, below + above + 1e-5)):
            start, end = (2.0 * k, y), (2.0 * k + 1.0, y)
            section, material = ancf.Circle(2.0 * radius), ancf.Material(1e13, 1e3)
            velocity = (0.0, -speed if side is upper else 0.0)
            side.append(scene.add_beam("thin", start, end, 2, section, material, velocity=velocity))
        for s in (0.0, 0.5, 1.0):
            scene.pin(lower[k].at(s))
        mass = math.pi * above**2 * 1e3
        depths.append(speed * math.sqrt(mass / stiffness) / min(below, above))
    assert depths[1] > 1.5 * depths[0]
    scene.contact(lower, upper, stiffness=stiffness)
    with pytest.warns(ancf.PenetrationWarning, match="the radius of 0.002 m") as caught:
        ancf.simulate(scene, 0.015, 5e-5, integrator=ancf.EnergyMomentum())
    ratio = float(re.search(r"m, (\S+) times", str(caught[0].message)).group(1))
    assert ratio == pytest.approx(depths[1], rel=0.03)
