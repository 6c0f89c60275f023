"""Bodies that begin inside each other are moved apart, by little and within their joints."""

import math

import numpy as np
import pytest

import ancfsparse as ancf

RADIUS = 0.005
SECTION, MATERIAL = ancf.Circle(2.0 * RADIUS), ancf.Material(1e8, 5e3)
# Of a length, where depths are measured: from the first point of the first element of 8 with a
# contact force, to the last one; the ends beyond can be deeper, as in a motion.
SHARES = np.linspace(0.0141, 0.9859, 401)


def axis_of(state, beam):
    """Points on the axis of a beam (n, dim) [m]."""
    length = beam.lengths.sum()
    return np.array([state.position(beam.at(s * length)) for s in SHARES])


def distance_of(one, other):
    """Smallest distance of two axes as polygons, by points and segments [m]."""
    begin, along = other[:-1], np.diff(other, axis=0)
    offset = one[:, None] - begin
    share = np.clip(np.sum(offset * along, axis=2) / np.sum(along**2, axis=1), 0.0, 1.0)
    return np.linalg.norm(offset - share[:, :, None] * along, axis=2).min()


def on_floor():
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (0.0, -0.003), (1.0, 0.004), 8, SECTION, MATERIAL)
    scene.contact(cable, ancf.HalfSpace((0.0, 0.0), (0.0, 1.0)), push_out=True)
    return scene, cable, lambda x: x[:, 1]


def over_ball():
    """It is clamped at both ends, and a ball from below reaches over its axis."""
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (-0.5, 0.0), (0.5, 0.0), 40, SECTION, MATERIAL)
    for end in (cable.start, cable.end):
        scene.clamp(end)
    scene.contact(cable, ancf.Ball((0.0, -0.498), 0.5), push_out=True, stiffness=1e5)
    return scene, cable, lambda x: np.linalg.norm(x - (0.0, -0.498), axis=1) - 0.5


def around_drum():
    scene = ancf.Scene((0.0, -9.81))
    arc = ancf.Arc((0.0, 0.0), (-0.1, 0.0), -math.pi)
    cable = scene.add_beam("thin", curve=arc, n_elements=30, section=SECTION, material=MATERIAL)
    scene.contact(cable, ancf.Drum((0.0, 0.0), 0.1), push_out=True)
    return scene, cable, lambda x: np.linalg.norm(x, axis=1) - 0.1


@pytest.mark.parametrize("build", [on_floor, over_ball, around_drum])
def test_a_cable_is_moved_out_of_an_obstacle(build):
    scene, cable, distances = build()
    deep = RADIUS - distances(cable.positions).min()
    apart = ancf.assemble(scene)
    assert (distances(axis_of(apart, cable)) > 0.99 * RADIUS).all()
    assert apart.violation == pytest.approx(deep, rel=0.05)
    assert 0.9 * deep < apart.moved < 2.0 * deep
    assert apart.worst.startswith("contact of")
    if build is over_ball:  # supports hold
        for end, x in ((cable.start, -0.5), (cable.end, 0.5)):
            np.testing.assert_allclose(apart.position(end), (x, 0.0), atol=1e-15)
            assert abs(apart.slope(end)[1]) < 1e-15


def crossing(height=0.004, **more):
    scene = ancf.Scene((0.0, 0.0, -9.81))
    lower = scene.add_beam("thin", (-0.5, 0, 0), (0.5, 0, 0), 10, SECTION, MATERIAL)
    scene.pin(lower.start)
    scene.pin(lower.end)
    upper = scene.add_beam("thin", (0.01, -0.5, height), (0.01, 0.5, height), 10, SECTION, MATERIAL)
    contact = scene.contact(lower, upper, stiffness=1e7, **more)
    return scene, lower, upper, contact


@pytest.mark.parametrize("height", [0.0099, 0.004, 0.0005])
@pytest.mark.parametrize("stiffness", [1e3, 1e9])
def test_a_cable_is_moved_off_another_one(height, stiffness):
    scene, *_, contact = crossing(height)
    apart = ancf.assemble(scene.replaced(contact, stiffness=stiffness, push_out=True))
    one, other = (axis_of(apart, beam) for beam in apart.system.scene.beams)
    assert distance_of(one, other) > 1.99 * RADIUS
    # The free one moves as a whole, up and by hardly more than it must.
    assert apart.moved == pytest.approx(2.0 * RADIUS - height, rel=0.1, abs=1e-4)
    assert (other[:, 2] > height).all()
    assert np.abs(one[:, 2]).max() < 0.05 * (2.0 * RADIUS - height)


def test_a_run_begins_apart_and_reports_the_motion():
    """The energy of the overlap is at most that of 1 % of the radius by the formula, not 2 J."""
    scene, _, upper, contact = crossing(push_out=True)
    run = ancf.simulate(scene, 0.02, 1e-3, integrator=ancf.EnergyMomentum(), max_halvings=6)
    apart = ancf.assemble(scene)
    np.testing.assert_array_equal(run.q[0], apart.q)
    assert f"moved by up to {apart.moved:.6g} m" in repr(run)
    most = 8.0 / 15.0 * math.sqrt(4.0 * RADIUS) * 1e7 * (0.01 * RADIUS) ** 2.5
    assert run.energy.contact[0] < most
    assert run.contact_force(contact).penetration[0] < 0.01 * RADIUS
    assert np.abs(run.velocity(upper.at(0.5))).max() < 0.25  # 9.81 m/s2 within .02 s
    moving = scene.replaced(upper, velocity=(0.0, 0.0, 0.3))
    quick = ancf.simulate(moving, 0.01, 1e-3, integrator=ancf.EnergyMomentum(), max_halvings=6)
    np.testing.assert_allclose(quick.velocity(moving.beams[1].start)[0], (0.0, 0.0, 0.3))


def test_a_run_that_begins_apart_is_the_same_with_push_out():
    scene, *_, contact = crossing(0.02)
    other = scene.replaced(contact, push_out=True)
    settings = {"integrator": ancf.EnergyMomentum()}
    one, two = (ancf.simulate(each, 0.02, 1e-3, **settings) for each in (scene, other))
    np.testing.assert_array_equal(one.q, two.q)
    assert "initial state" not in repr(two)


def test_a_plan_and_a_run_to_an_error_begin_apart():
    """A cable is thrown up from inside another one, as if it had begun where it is moved to."""
    scene, *_, contact = crossing()
    scene = scene.replaced(contact, stiffness=1e4, push_out=True)
    thrown = scene.replaced(scene.beams[1], velocity=(0.0, 0.0, 0.5))
    apart, end, error = ancf.assemble(thrown), 0.05, 1e-3
    cable = thrown.beams[1]
    begin, stop = (apart.position(each) for each in (cable.start, cable.end))
    placed, *_, contact = crossing()
    placed = placed.replaced(contact, stiffness=1e4)
    placed = placed.replaced(placed.beams[1], start=begin, end=stop, velocity=(0.0, 0.0, 0.5))
    settings = {"dt": 1e-4, "integrator": ancf.EnergyMomentum()}
    expected = ancf.simulate(placed, end, **settings).position(placed.beams[1].at(0.5))[-1]
    flight = apart.position(cable.at(0.5))[2] + 0.5 * end - 0.5 * 9.81 * end**2
    assert expected[2] == pytest.approx(flight, abs=0.2 * error)
    assert apart.position(cable.at(0.5))[2] > 0.004 + 5.0 * error
    quantity = ancf.position(cable.at(0.5))
    planned = ancf.plan(thrown, end, quantity, error)
    runs = planned.run(), ancf.simulate(thrown, end, quantity=quantity, error=error)
    for run in runs:
        point = run.system.scene.beams[1].at(0.5)
        np.testing.assert_allclose(run.position(point)[-1], expected, rtol=0.0, atol=error)
        np.testing.assert_allclose(run.position(point)[0], apart.position(cable.at(0.5)), atol=1e-9)
        assert f"moved by up to {apart.moved:.6g} m" in repr(run)


def test_an_equilibrium_and_a_file_begin_apart(tmp_path):
    scene, cable, distances = over_ball()
    rest = ancf.solve_static(scene)
    assert (distances(axis_of(rest, cable)) > 0.9 * RADIUS).all()
    assert "moved by up to" in rest.stats.solver
    path = ancf.quasi_static(scene, 0.1, 0.05)
    assert "moved by up to" in repr(path)
    run = ancf.simulate(scene, 0.002, 1e-3, output=tmp_path / "run.h5")
    again = ancf.load(tmp_path / "run.h5")
    np.testing.assert_array_equal(again.q[:], run.q[:])
    assert "moved by up to" in repr(again)


def test_a_heap_is_moved_apart():
    rng = np.random.default_rng(0)
    scene = ancf.Scene((0.0, 0.0, -9.81))
    floor = ancf.HalfSpace((0.0, 0.0, 0.0), (0.0, 0.0, 1.0))
    cables = []
    for _ in range(8):
        at, along = rng.uniform((-0.05, -0.05, 0.004), (0.05, 0.05, 0.03)), rng.normal(size=3)
        along *= (0.1, 0.1, 0.005) / np.linalg.norm(along)
        cables.append(scene.add_beam("thin", at - along, at + along, 8, SECTION, MATERIAL))
        scene.contact(cables[-1], floor, stiffness=1e6, push_out=True)
        for other in cables[:-1]:
            scene.contact(cables[-1], other, stiffness=1e6, push_out=True)
    apart = ancf.assemble(scene)
    axes = [axis_of(apart, cable) for cable in cables]
    assert min(axis[:, 2].min() for axis in axes) > 0.99 * RADIUS
    assert min(distance_of(a, b) for k, a in enumerate(axes) for b in axes[:k]) > 1.99 * RADIUS
    assert 0.5 * apart.violation < apart.moved < 0.1


def test_what_push_out_refuses():
    scene, *_ = crossing(0.004)
    with pytest.raises(ancf.InputError, match=r"begins with a penetration of 0.006 m .* push_out"):
        ancf.simulate(scene, 0.01, 1e-3)
    with pytest.raises(ancf.InputError, match="push_out"):
        crossing(push_out="yes")
    for build in (lambda: crossing(0.0, push_out=True)[0], crossed_in_the_plane, between_walls):
        with pytest.raises(
            ancf.InputError, match=r"push_out=True leaves a penetration of .* cross"
        ):
            ancf.simulate(build(), 0.01, 1e-3)
    with pytest.raises(ancf.InputError, match="load_path begins at the reference shape"):
        ancf.load_path(over_ball()[0])


def crossed_in_the_plane():
    scene = ancf.Scene((0.0, -9.81))
    one = scene.add_beam("thin", (-0.5, 0.0), (0.5, 0.0), 10, SECTION, MATERIAL)
    other = scene.add_beam("thin", (0.01, -0.5), (0.01, 0.5), 10, SECTION, MATERIAL)
    scene.contact(one, other, stiffness=1e6, push_out=True)
    return scene


def between_walls():
    scene = ancf.Scene((0.0, -9.81))
    cable = scene.add_beam("thin", (0.0, 0.004), (1.0, 0.004), 8, SECTION, MATERIAL)
    for height, up in ((0.0, 1.0), (0.008, -1.0)):
        wall = ancf.HalfSpace((0.0, height), (0.0, up))
        scene.contact(cable, wall, stiffness=1e6, push_out=True)
    return scene
