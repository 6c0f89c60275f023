"""Cables that rest, fall, rebound and slide on obstacles, against formulas."""

import math
import re

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.scene.force_elements.contacts import LAYER_RATIO
from ancfsparse.solve.stepping.implicit_setup import prepare_implicit
from ancfsparse.system import System
from tests.grids import level_grid
from tests.matrices import derivative_of_step, full

SECTION, MATERIAL = ancf.Circle(0.01), ancf.Material(1e8, 5e3)
LINE_MASS = MATERIAL.density * SECTION.area
FLOOR = ancf.HalfSpace((0, 0), (0, 1))


def level(height, stiffness=None, slope=0.0, velocity=(0.0, 0.0), **friction):
    """A cable of 1 m whose lower surface is at a height above a floor of some slope."""
    along = np.array([math.cos(slope), math.sin(slope)])
    normal = np.array([-along[1], along[0]])
    scene = ancf.Scene((0.0, -9.81))
    start = (height + 0.005) * normal
    rod = scene.add_beam("thin", start, start + along, 8, SECTION, MATERIAL, velocity=velocity)
    floor = ancf.HalfSpace((0, 0), tuple(normal))
    return scene, rod, scene.contact(rod, floor, stiffness=stiffness, **friction)


@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_a_cable_rests_on_the_pressure_of_its_weight(unit):
    """In metres, and with all lengths in millimetres: forces per length k e = w."""
    scene = ancf.Scene((0.0, -9.81))
    section = ancf.Circle(0.01 * unit)
    rod = scene.add_beam("thin", (0, 0.0049 * unit), (unit, 0.0049 * unit), 8, section, MATERIAL)
    contact = scene.contact(rod, FLOOR, stiffness=1e5 * unit)
    rest = ancf.solve_static(scene)
    weight = MATERIAL.density * section.area * 9.81
    depth = weight / (1e5 * unit) + 0.5 * LAYER_RATIO * 0.005 * unit
    assert 0.005 * unit - rest.position(rod.end)[1] == pytest.approx(depth, rel=1e-9)
    force = rest.contact_force(contact)
    assert np.allclose(force.force, (0.0, weight * unit), rtol=1e-9, atol=1e-9 * weight * unit)
    assert np.allclose(force.pressure, weight, rtol=1e-8)
    # The first point is the first of three on the last part of four of the element.
    assert force.s[0] == pytest.approx(0.5 * unit / 32 * (1 - math.sqrt(0.6)))


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9])
def test_energy_momentum_conserves_the_energy_of_impacts_with_any_step(stiffness, dt):
    scene, rod, _ = level(0.1, stiffness)
    run = ancf.simulate(scene, 0.4, dt, integrator=ancf.EnergyMomentum(), tolerance=1e-9)
    assert run.position(rod.end)[:, 1].min() < 0.005  # it has touched
    assert run.velocity(rod.end)[-1, 1] > 0.0 or run.velocity(rod.end)[:, 1].max() > 1.0
    assert run.energy.drift < 1e-7


@pytest.mark.parametrize("dt", [1e-4, 1e-3, 1e-2])
@pytest.mark.parametrize("stiffness", [1e5, 1e7, 1e9])
@pytest.mark.parametrize(
    "integrator", [ancf.GeneralizedAlpha(0.9), ancf.HHT(0.1), ancf.Newmark(0.0)], ids=repr
)
def test_no_impact_returns_more_energy_than_it_had(integrator, stiffness, dt):
    """Without damping, up to 5 times as much came back; the phase of the first touch matters."""
    for height in [0.5] if dt < 1e-3 else [0.48, 0.49, 0.5, 0.51]:
        scene, rod, _ = level(height, stiffness)
        fall = math.sqrt(2.0 * height / 9.81)
        steps = round(1.8 * fall / dt)
        run = ancf.simulate(scene, steps * dt, dt, integrator=integrator, tolerance=1e-10)
        y, v = run.position(rod.at(0.5))[:, 1] - 0.005, run.velocity(rod.at(0.5))[:, 1]
        assert y.min() < 3.2 * dt  # the way of a step, in which damping acts before the touch
        returned = (0.5 * v**2 + 9.81 * y)[run.t > fall + 2.0 * dt].max() / (9.81 * height)
        assert returned < 1.0001
        if (stiffness, dt) == (1e5, 1e-4):  # 63 steps per impact
            assert returned > 0.999


def test_the_matrix_of_a_damped_impact_is_the_derivative_of_its_residual():
    scene, _, _ = level(1e-4, 1e5, velocity=(0.0, -1.0))
    system = System(scene)
    march, *_ = prepare_implicit(
        system, 2e-3, ancf.GeneralizedAlpha(0.9), ancf.Newton(), 1e-9, math.inf
    )
    march.prepare(np.zeros((1, 0)))
    derivative = derivative_of_step(march, system.n_free)
    march.residual()
    matrix = full(system, march.matrix())
    assert np.abs(matrix - derivative).max() < 1e-5 * np.abs(matrix).max()


@pytest.mark.parametrize("unit", [1.0, 1e-3])
def test_by_default_a_cable_sinks_in_by_little_at_rest_and_in_an_impact(unit):
    """Half of 1 % of its radius at rest, a fifth of 1 % after a level fall; also in millimetres.

    The soft layer adds half of its thickness of 1e-3 radii.
    """
    section = ancf.Circle(0.01 * unit)
    depths = {}
    for height, t_end, dt in ((0.0, 0.25, 5e-5), (0.2 * unit, 0.21, 1e-6)):
        scene = ancf.Scene((0.0, -9.81 * unit))
        start = 0.005 * unit + height
        rod = scene.add_beam("thin", (0, start), (unit, start), 8, section, MATERIAL)
        scene.contact(rod, FLOOR)
        run = ancf.simulate(scene, t_end, dt, integrator=ancf.EnergyMomentum())
        depths[height] = 1.0 - run.position(rod.at(0.5 * unit))[:, 1] / (0.005 * unit)
    assert 0.004 < depths[0.0].mean() < 0.007
    assert depths[0.2 * unit].max() == pytest.approx(0.01 / 5.0 + 0.0005, rel=0.05)


def test_by_default_a_loaded_wire_sinks_into_a_drum_by_little():
    """Forces of 20 N at both ends: at most 1 % of the radius."""
    scene = ancf.Scene((0.0, 0.0))
    arc = scene.add_beam(
        "thin",
        curve=ancf.Arc((0, 0), (-0.102, 0.0), -math.pi),
        n_elements=24,
        section=ancf.Circle(0.004),
        material=ancf.Material(1e9, 1e4),
    )
    contact = scene.contact(arc, ancf.Drum((0, 0), 0.1))
    for end in (arc.start, arc.end):
        scene.point_force(end, ancf.Ramp((0.0, -20.0), 0.05, smooth=True))
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.GeneralizedAlpha(0.5))
    depth = 0.102 - np.linalg.norm(run.position(arc.at(0.16)), axis=1)
    assert 0.0025 < depth[-100:].mean() / 0.002 < 0.01
    assert run.contact_force(contact).pressure[-1].mean() == pytest.approx(20.0 / 0.102, rel=0.02)


def test_by_default_a_net_sinks_into_a_ball_by_little():
    """A node falls by 2 cm onto its top, and sinks in by less than a run warns of."""
    nodes, edges, _ = level_grid(3, 0.2)
    scene = ancf.Scene((0.0, 0.0, -9.81))
    section = ancf.Circle(0.004)
    net = scene.add_mesh(nodes, edges, "thin", section, ancf.Material(1e7, 1e3), n_elements=2)
    contact = scene.contact(net, ancf.Ball((0.1, 0.1, -0.122), 0.1))
    run = ancf.simulate(scene, 0.08, 2e-4, integrator=ancf.EnergyMomentum())
    assert run.contact_force(contact).pressure.any()
    centre = run.position(net.node(4))
    depths = 1.0 - (np.linalg.norm(centre - (0.1, 0.1, -0.122), axis=1) - 0.1) / 0.002
    assert 0.01 < depths.max() < 0.3


@pytest.mark.parametrize("n", [3, 6, 12, 24])
def test_the_lower_end_of_a_tilted_cable_stays_on_the_floor_with_elements_of_any_length(n):
    """Without points close to it, it sank in by up to 2.3 radii."""
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0.03), (1, 0.33), n, SECTION, MATERIAL)
    scene.contact(rod, FLOOR)
    run = ancf.simulate(scene, 0.12, 2e-4, integrator=ancf.EnergyMomentum())
    deepest = 1.0 - run.position(rod.start)[:, 1].min() / 0.005
    # Its last part is at most 8 radii long, its first Gauss point at 0.113 of it; the slope is 0.3.
    assert 0.05 < deepest < 0.113 * 8 * 0.3 + 0.01


def test_a_default_stiffness_that_is_too_small_is_reported_with_one_that_suffices():
    """A user's function of time is not known before the run."""

    def run(stiffness=None):
        scene, rod, _ = level(0.0, stiffness)
        scene.point_force(rod.at(0.5), lambda t: (0.0, -1e4 * t))
        return ancf.simulate(scene, 0.05, 1e-3, integrator=ancf.EnergyMomentum())

    with pytest.warns(ancf.PenetrationWarning, match=r"times the radius.*stiffness=") as caught:
        run()
    run(float(str(caught[0].message).split("stiffness=")[1]))


def test_a_given_stiffness_by_which_the_axis_enters_a_disc_is_reported_with_one_that_suffices():
    """A cable that is bent around a disc springs back into it, as in random contacts 11001/1839."""
    disc, radius = 0.05, 0.005

    def run(stiffness):
        scene = ancf.Scene((0.0, 0.0))
        arc = ancf.Arc((0, 0), (-disc - radius, 0), -2.0)
        cable = scene.add_beam("l2t2", curve=arc, n_elements=12, section=SECTION, material=MATERIAL,
                               rest="straight")  # fmt: skip
        contact = scene.contact(cable, ancf.Drum((0, 0), disc), stiffness=stiffness)
        run = ancf.simulate(scene, 0.02, 1e-4, integrator=ancf.EnergyMomentum(), max_halvings=5)
        places = np.array([run.position(point) for point in contact.points])
        depths = disc + radius - np.linalg.norm(places, axis=-1)
        k = np.unravel_index(np.argmax(depths), depths.shape)[0]
        return depths.max() / radius, f"{depths.max():.3g} m, .* at {contact.points[k]!r}"

    with pytest.warns(ancf.PenetrationWarning, match=r"given stiffness of 1e\+05 N/m2") as caught:
        depth, words = run(1e5)
    assert depth > 1.0
    assert re.search(words, str(caught[0].message))
    assert run(float(str(caught[0].message).split("stiffness=")[1]))[0] < 0.3


def test_the_given_stiffness_of_a_flat_floor_can_be_as_soft_as_it_may():
    """There the pressure is right at any depth: a fall of 0.1 m returns all of its energy."""
    scene, rod, _ = level(0.1, 1e4)
    run = ancf.simulate(scene, 0.35, 1e-3, integrator=ancf.EnergyMomentum())
    mass = MATERIAL.density * SECTION.area
    rest = mass * 9.81 / 1e4
    depth = rest + math.sqrt(rest**2 + mass * 2.0 * 9.81 * 0.1 / 1e4)
    assert depth > 1.5 * 0.005
    assert 0.005 - run.position(rod.start)[:, 1].min() == pytest.approx(depth, rel=0.01)
    assert run.energy.drift < 1e-9


def test_a_contact_that_nothing_is_known_to_press_needs_a_stiffness():
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 1), (1, 1), 8, SECTION, MATERIAL)
    scene.contact(rod, FLOOR)
    with pytest.raises(ancf.InputError, match="neither weight nor a known force"):
        ancf.simulate(scene, 0.1, 1e-3)


def test_the_rebound_is_of_second_order():
    """Height after a soft impact, against a mass on a spring that is found by quadrature."""

    def height(dt):
        scene, rod, _ = level(0.05, 1e4)
        run = ancf.simulate(scene, 0.2, dt, integrator=ancf.EnergyMomentum(), tolerance=1e-10)
        return run.position(rod.end)[-1, 1]

    finest = height(1.25e-4)
    errors = np.array([abs(height(dt) - finest) for dt in (4e-3, 2e-3, 1e-3)])
    orders = np.log2(errors[:-1] / errors[1:])
    assert np.all(orders > 1.7)
    assert errors[-1] < 2e-4


def test_a_cable_slides_down_a_slope_with_the_acceleration_of_coulomb():
    """g (sin a - mu cos a), where the speed is far above the slip speed."""
    slope, mu = 0.5, 0.3
    depth = LINE_MASS * 9.81 * math.cos(slope) / 1e6 + 0.5 * LAYER_RATIO * 0.005
    along = np.array([math.cos(slope), math.sin(slope)])
    scene, rod, contact = level(
        -depth, 1e6, slope, velocity=tuple(-1.0 * along), friction=mu, slip_speed=1e-4
    )
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.EnergyMomentum())
    speed = -run.velocity(rod.at(0.5)) @ along
    expected = 1.0 + 9.81 * (math.sin(slope) - mu * math.cos(slope)) * run.t
    assert np.abs(speed - expected).max() < 1e-4
    force = run.contact_force(contact)
    total = np.linalg.norm(force.friction, axis=2)
    assert np.all(total <= mu * force.pressure * (1 + 1e-12))
    slid = (run.position(rod.at(0.5))[0] - run.position(rod.at(0.5))[-1]) @ along
    normal_force = LINE_MASS * 9.81 * math.cos(slope)
    assert run.energy.friction[-1] == pytest.approx(mu * normal_force * slid, rel=1e-5)
    assert not run.energy.work.any()
    assert run.energy.drift < 1e-10


def test_a_cable_that_ought_to_stick_creeps_by_the_law():
    """slip_speed f / sqrt(1 - f^2) at the fraction f = tan(a) / mu of the force of sliding."""
    slope, mu, slip = 0.2, 0.4, 1e-3
    depth = LINE_MASS * 9.81 * math.cos(slope) / 1e6 + 0.5 * LAYER_RATIO * 0.005
    scene, rod, _ = level(-depth, 1e6, slope, friction=mu, slip_speed=slip)
    run = ancf.simulate(scene, 0.1, 1e-3, integrator=ancf.EnergyMomentum())
    f = math.tan(slope) / mu
    along = np.array([math.cos(slope), math.sin(slope)])
    speed = -np.diff(run.position(rod.at(0.5)) @ along) / 1e-3
    assert speed[-20:].mean() == pytest.approx(slip * f / math.sqrt(1 - f**2), rel=1e-3)


def test_explicit_and_implicit_runs_agree():
    def place(**options):
        scene, rod, _ = level(0.02, 1e5)
        return ancf.simulate(scene, 0.1, 2e-5, **options).position(rod.at(0.3))[-1]

    implicit = place(integrator=ancf.EnergyMomentum(), tolerance=1e-9)
    assert np.allclose(place(integrator=ancf.DormandPrince()), implicit, atol=1e-7)


def test_explicit_runs_begin_with_friction_that_does_not_act_yet():
    """On more coordinates than a dense matrix has: ARPACK refuses the damping, which is zero."""
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0.006), (1, 0.006), 60, SECTION, MATERIAL)
    scene.contact(rod, FLOOR, stiffness=1e5, friction=0.3, slip_speed=0.01)
    run = ancf.simulate(scene, 0.02, 1e-5, integrator=ancf.DormandPrince())
    assert run.position(rod.at(0.5))[-1, 1] < 0.005
    assert run.contact_force(scene.attachments[0]).pressure.any()


@pytest.mark.parametrize(
    "integrator", [ancf.GeneralizedAlpha(0.9), ancf.HHT(0.1), ancf.EnergyMomentum()], ids=repr
)
def test_a_run_in_two_parts_is_one_run_bit_for_bit(integrator):
    """The damping of an impact needs the penetration of the last step: it is history."""

    def drop():
        return level(2e-3, 1e5, friction=0.2, slip_speed=0.01)[0]

    options = {"integrator": integrator, "solver": ancf.Newton()}
    whole = ancf.simulate(drop(), 0.04, 1e-3, **options)
    scene = drop()
    first = ancf.simulate(scene, 0.022, 1e-3, **options)  # in the impact
    assert first.contact_force(scene.attachments[0]).pressure[-1].any()
    second = ancf.simulate(scene, 0.04, 1e-3, start=first.last, **options)
    assert np.array_equal(second.q[-1], whole.q[-1])


def test_a_saved_scene_moves_alike(tmp_path):
    scene, _, _ = level(0.02, 1e5, friction=0.2, slip_speed=0.01)
    scene.save(tmp_path / "drop.json")
    again = ancf.Scene.load(tmp_path / "drop.json")
    assert again.digest() == scene.digest()
    first, second = (
        ancf.simulate(each, 0.1, 1e-3, integrator=ancf.EnergyMomentum()) for each in (scene, again)
    )
    assert np.array_equal(first.q, second.q)
    ancf.simulate(scene, 0.1, 1e-3, integrator=ancf.EnergyMomentum(), output=tmp_path / "drop.h5")
    stored = ancf.load(tmp_path / "drop.h5", scene)
    contact = scene.attachments[0]
    forces = first.contact_force(contact), stored.contact_force(contact)
    assert np.array_equal(forces[0].pressure, forces[1].pressure)
    with pytest.raises(ancf.InputError, match="contact is not part of this scene"):
        second.contact_force(contact)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda s, r: s.contact(r, 3, stiffness=1.0), "needs one of HalfSpace, Drum, Ball"),
        (lambda s, r: s.contact(r.end, FLOOR, stiffness=1.0), "needs a beam or a mesh"),
        (lambda s, r: s.contact(r, FLOOR, stiffness=0.0), "stiffness of the contact"),
        (lambda s, r: s.contact(r, ancf.Ball((0, 0, 0), 1.0), stiffness=1.0), "3 coordinates"),
        (
            lambda s, r: s.contact(r, ancf.Ball((0.5, 0), 0.2), stiffness=1.0),
            "of 0.190.* m at beam 0",
        ),
        (
            lambda s, r: s.contact(r, ancf.HalfSpace((0, 4e-4), (0, 1))),
            "more than 5% of the radius",
        ),
        (lambda s, r: s.contact(r, FLOOR, radius=5e-324), "must lie between 1e-100 and"),
        (lambda s, r: s.contact(r, ancf.Ball((0.5, -1), 0.03), stiffness=1.0), "3 times as many"),
        (lambda s, r: [s.contact(r, FLOOR, stiffness=1.0) for _ in "ab"], "added before"),
        (lambda s, r: ancf.HalfSpace((0, 0), (0, 0)), "must have a direction"),
        (lambda s, r: ancf.HalfSpace((0,), (0, 1)), "must have 2 components"),
        (lambda s, r: ancf.Drum((0, 0, 0), 1.0), "give axis="),
        (lambda s, r: ancf.Drum((0, 0), 1.0, axis=(0, 0, 1)), "leave axis out"),
        (lambda s, r: ancf.Ball((0, 0), -1.0), "radius of a ball"),
    ],
)
def test_what_cannot_be_is_refused(call, message):
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0.0051), (1, 0.0051), 8, SECTION, MATERIAL)
    with pytest.raises(ancf.InputError, match=message):
        call(scene, rod)


def test_sections_that_are_not_round_need_a_radius():
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 1), (1, 1), 8, ancf.Rectangle(0.01, 0.01), MATERIAL)
    with pytest.raises(ancf.InputError, match="not round"):
        scene.contact(rod, FLOOR, stiffness=1.0)
    assert scene.contact(rod, FLOOR, stiffness=1.0, radius=0.005).radii == (0.005,)
    auto = ancf.Scene((0.0, -9.81))
    rod = auto.add_beam("auto", (0, 1), (1, 1), "auto", SECTION, MATERIAL)
    with pytest.raises(ancf.InputError, match="give element and n_elements"):
        auto.contact(rod, FLOOR, stiffness=1.0)


@pytest.mark.parametrize("element", ["thin", "thick"])
@pytest.mark.parametrize(("radius", "drum", "modulus"), [(0.004, 0.1, 1e8), (0.4, 7.25, 5.6e9)])
def test_a_bent_beam_that_springs_off_a_drum_sinks_in_by_less_than_a_hundredth(
    element, radius, drum, modulus
):
    """Its bending energy alone presses it."""
    scene = ancf.Scene((0, 0))
    reach = drum + radius
    beam = scene.add_beam(
        element, curve=ancf.Arc((0, 0), (-reach, 0), -3.1), n_elements=24, rest="straight",
        section=ancf.Circle(2.0 * radius), material=ancf.Material(modulus, 1e3),
    )  # fmt: skip
    contact = scene.contact(beam, ancf.Drum((0, 0), drum))
    bending = modulus * np.pi * radius**4 / 4.0
    time = 0.5 * reach**2 * np.sqrt(1e3 * np.pi * radius**2 / bending)
    run = ancf.simulate(scene, time, time / 400)
    distances = [np.linalg.norm(run.position(point), axis=1) for point in contact.points]
    deepest = reach - np.min(distances)
    assert 3e-4 * radius < deepest < 0.01 * radius
