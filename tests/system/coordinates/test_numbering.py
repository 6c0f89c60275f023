"""Where coordinates stand, what the joints do to them, and the state a motion starts from."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from ancfsparse.system import System

SECTION, MATERIAL = ancf.Circle(0.02), ancf.Material(1e8, 1000.0)


def cable(scene, start, end, n=2, element="thin", **options):
    return scene.add_beam(element, start, end, n, SECTION, MATERIAL, **options)


def test_free_coordinates_come_first():
    scene, _ = pendulum("l2t2", 2)
    system = System(scene)
    assert (system.n_free, system.n_all, system.n_multipliers) == (10, 12, 0)
    np.testing.assert_array_equal(system.places[0], [[10, 11, 0, 1], [2, 3, 4, 5], [6, 7, 8, 9]])
    np.testing.assert_array_equal(system.q0, [1, 0, 1, 0, 1, 0, 2, 0, 1, 0, 0, 0])
    np.testing.assert_array_equal(system.v0, np.zeros(12))


@pytest.mark.parametrize("dim", [2, 3])
def test_connected_beams_share_a_position_and_nothing_else(dim):
    scene = ancf.Scene((0.0, -9.81, 0.0)[:dim])
    zero = (0.0,) * (dim - 2)
    one = cable(scene, (0, 0, *zero), (1, 0, *zero))
    two = cable(scene, (1, 0, *zero), (1, 1, *zero))
    three = cable(scene, (2, 0, *zero), (1, 0, *zero))
    scene.connect(two.start, one.end)
    scene.connect(three.end, two.start)
    system = System(scene)
    assert system.n_free == system.n_all == 3 * 3 * 2 * dim - 2 * dim
    places = [system.place(node) for node in (one.end, two.start, three.end)]
    for each in places[1:]:
        np.testing.assert_array_equal(each[:dim], places[0][:dim])
        assert not set(each[dim:]) & set(places[0])
    np.testing.assert_array_equal(system.q0[places[0]][:2], [1, 0])
    np.testing.assert_array_equal(system.q0[places[1][dim : dim + 2]], [0, 1])
    np.testing.assert_array_equal(system.q0[places[2][dim : dim + 2]], [-1, 0])


def test_a_pin_holds_all_that_is_connected_there():
    scene = ancf.Scene()
    one, two = cable(scene, (0, 0), (1, 0)), cable(scene, (1, 0), (2, 0))
    scene.pin(one.end)
    scene.connect(one.end, two.start)
    system = System(scene)
    assert system.n_all - system.n_free == 2
    assert (system.place(two.start)[:2] >= system.n_free).all()
    assert (system.place(two.start)[2:] < system.n_free).all()


def test_a_pin_by_constraint_holds_nothing_by_numbering():
    scene, rod = pendulum("l2t2", 2, as_constraint=True)
    system = System(scene)
    assert (system.n_free, system.n_all, system.n_multipliers) == (12, 12, 2)
    jacobian = system.constraints.jacobian(system.q0).toarray()
    np.testing.assert_array_equal(jacobian[:, system.place(rod.start)], np.eye(2, 4))


@pytest.mark.parametrize(
    ("end", "stretch", "fixed", "multipliers"),
    [
        ((1, 0), "free", [0, 1, 3], 0),
        ((-1, 0), "free", [0, 1, 3], 0),
        ((0, -2), "free", [0, 1, 2], 0),
        ((1, 1), "free", [0, 1], 1),
        ((1, 1e-9), "free", [0, 1], 1),
        ((1, 0), "fixed", [0, 1, 2, 3], 0),
        ((1, 1), "fixed", [0, 1, 2, 3], 0),
        ((1, 0, 0), "free", [0, 1, 2, 4, 5], 0),
        ((0, 0, 1), "free", [0, 1, 2, 3, 4], 0),
        ((1, 2, 0), "free", [0, 1, 2], 2),
        ((1, 2, 3), "fixed", [0, 1, 2, 3, 4, 5], 0),
    ],
)
def test_a_clamp_is_numbers_where_it_can_be(end, stretch, fixed, multipliers):
    dim = len(end)
    scene = ancf.Scene((0.0,) * dim)
    rod = cable(scene, (0,) * dim, end)
    scene.clamp(rod.start, stretch)
    system = System(scene)
    held = np.flatnonzero(system.place(rod.start) >= system.n_free)
    assert held.tolist() == fixed
    assert system.n_multipliers == multipliers
    # Held across, free along: turning the slope is seen, stretching it is not.
    slope = system.place(rod.start)[dim:]
    jacobian = system.constraints.jacobian(system.q0).toarray()[:, slope] / rod.lengths[0]
    np.testing.assert_allclose(jacobian @ rod.axes[0], 0.0, atol=1e-15)
    np.testing.assert_allclose(jacobian @ jacobian.T, np.eye(multipliers), atol=1e-15)


@pytest.mark.parametrize(("end", "n"), [((1, 0.5), 7), ((1, 0.5, 2), 12)])
def test_a_thick_clamp_holds_the_section_too(end, n):
    dim = len(end)
    scene = ancf.Scene((0.0,) * dim)
    rod = cable(scene, (0,) * dim, end, element="thick")
    scene.clamp(rod.start)
    system = System(scene)
    assert system.n_all == 3 * n
    assert system.n_all - system.n_free == n
    assert system.n_multipliers == 0
    axes = system.q0[system.place(rod.start)[dim : dim + dim * dim]].reshape(dim, dim)
    np.testing.assert_allclose(axes, rod.axes, atol=1e-15)


def test_the_reference_shape_is_straight_and_free_of_stress():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    for k, element in enumerate(("thin", "thick")):
        cable(scene, (k, 0, 1), (k + 0.3, 0.4, 1.5), 4, element)
    system = System(scene)
    assert system.assembly.strain_energy(system.q0) < 1e-24
    for beam in scene.beams:
        for s in (0.0, 0.21 * beam.length, 0.5 * beam.length, beam.length):
            node = beam.at(s)
            for places, expected in (
                (system.point(node), node.position),
                (system.slope(node), beam.axes[0]),
            ):
                where, weights = places
                np.testing.assert_allclose(system.q0[where] @ weights, expected, atol=1e-14)


def test_point_and_slope_follow_a_cubic():
    # Hermite interpolation holds cubics exactly, so it and its derivative must agree with one.
    scene, rod = pendulum("thin", 4)
    system = System(scene)
    x = rod.positions[:, 0]
    q = np.zeros(system.n_all)
    cubic = np.polynomial.Polynomial([0.3, -1.0, 2.0, 0.7])
    q[system.places[0][:, 0]], q[system.places[0][:, 2]] = cubic(x), cubic.deriv()(x)
    for s in (0.0, 0.1, 0.77, 1.0, 1.99, 2.0):
        where, weights = system.point(rod.at(s))
        assert q[where[0]] @ weights == pytest.approx(cubic(s), rel=1e-13)
        where, weights = system.slope(rod.at(s))
        assert q[where[0]] @ weights == pytest.approx(cubic.deriv()(s), rel=1e-13)


SPIN = np.array([0.3, -0.7, 1.9])


def turning(x):
    """Rigid rotation about SPIN, with a translation; in the plane about z."""
    full = np.zeros((len(x), 3))
    full[:, : x.shape[1]] = x
    spin = SPIN if x.shape[1] == 3 else SPIN * [0, 0, 1]
    return (np.array([1.0, 2.0, 3.0]) + np.cross(spin, full))[:, : x.shape[1]]


@pytest.mark.parametrize("element", ["thin", "thick"])
@pytest.mark.parametrize("dim", [2, 3])
def test_a_rigid_rotation_turns_every_vector(dim, element):
    scene = ancf.Scene((0.0,) * dim)
    start, end = (5.0, 1.0, -2.0)[:dim], (6.0, 1.5, -1.0)[:dim]
    rod = cable(scene, start, end, 3, element, velocity=turning)
    system = System(scene)
    vectors = system.q0[system.places[0]]
    rates = system.v0[system.places[0]]
    np.testing.assert_allclose(rates[:, :dim], turning(rod.positions), rtol=1e-14)
    for k in range(1, vectors.shape[1] // dim):
        columns = slice(dim * k, dim * (k + 1))
        expected = turning(vectors[:, columns]) - turning(np.zeros((1, dim)))
        np.testing.assert_allclose(rates[:, columns], expected, rtol=0, atol=1e-10)
    # No strain changes in a rigid motion: the energy is still zero a little later.
    stretch = system.assembly.strain_energy(system.q0 + 1e-4 * system.v0)
    squares = (1e-4 * 2.1) ** 4 / 8 * rod.parameters()["axial_stiffness"] * rod.length
    assert stretch <= 50 * squares


def test_a_smooth_velocity_gives_its_derivative():
    scene = ancf.Scene()
    rod = cable(
        scene, (0, 0), (2, 0), 8, velocity=lambda x: np.stack([0 * x[:, 0], x[:, 0] ** 3], 1)
    )
    system = System(scene)
    s = rod.positions[:, 0]
    rates = system.v0[system.places[0]]
    np.testing.assert_allclose(rates[:, 1], s**3, atol=1e-14)
    # A difference of fourth order over a thousandth of an element, 0.25 m: exact but for rounding.
    np.testing.assert_allclose(rates[:, 3], 3 * s**2, atol=8.0 * 1.1e-16 / (1e-3 * 0.25))


def test_a_uniform_velocity_turns_nothing():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    cable(scene, (0, 0, 0), (2, 0, 0), 3, velocity=(1.0, -2.0, 0.5))
    system = System(scene)
    np.testing.assert_array_equal(system.v0[system.places[0]], [[1, -2, 0.5, 0, 0, 0]] * 4)


def test_a_velocity_of_a_held_point_is_refused():
    scene = ancf.Scene()
    rod = cable(scene, (0, 0), (2, 0), velocity=(0.0, 1.0))
    scene.pin(rod.start)
    with pytest.raises(ancf.InputError, match=r"initial velocity moves 1 held .* by 1 m/s"):
        System(scene)


def test_a_rotation_about_the_pin_is_no_velocity_of_the_pin():
    scene = ancf.Scene()
    rod = cable(
        scene, (1, 1), (2, 1), velocity=lambda x: 3 * np.stack([1 - x[:, 1], x[:, 0] - 1], axis=1)
    )
    scene.pin(rod.start)
    system = System(scene)
    np.testing.assert_array_equal(system.v0[system.n_free :], 0.0)
    assert system.v0[system.place(rod.end)[1]] == pytest.approx(3.0)


@pytest.mark.parametrize(
    ("dim", "element", "names"),
    [
        (2, "l2t2", ["r_1", "r_2", "r_x1", "r_x2"]),
        (3, "thin", ["r_1", "r_2", "r_3", "r_x1", "r_x2", "r_x3"]),
        (3, "thick", ["r_1", "r_2", "r_3", *(f"r_{v}{k}" for v in "xyz" for k in (1, 2, 3))]),
    ],
)
def test_describe_names_beam_node_and_coordinate(dim, element, names):
    scene = ancf.Scene((0.0,) * dim)
    rod = cable(scene, (0,) * dim, (1,) + (0,) * (dim - 1), 2, element, name="left arm")
    scene.pin(rod.node(1))
    system = System(scene)
    for node in range(3):
        for name, place in zip(names, system.places[0][node], strict=True):
            assert system.describe(place) == f"left arm, node {node}, {name}"
    with pytest.raises(IndexError):
        system.describe(system.n_all)


def crossing(first, second):
    scene = ancf.Scene()
    one = cable(scene, (0, 0), (1, 0), velocity=first)
    two = cable(scene, (1, 0), (2, 0), velocity=second)
    scene.connect(one.end, two.start)
    return scene


@pytest.mark.parametrize(
    ("first", "second", "words"),
    [
        ((0, 1), (0, -1), ", .* along y"),
        ((0, 1), None, ", .* along y"),
        (None, (0, 1), ", .* along y"),
        ((1e-10, 0.0), (2e-10, 0.0), ", 2e-10 m/s again"),  # however slow they are
    ],
)
def test_connected_beams_must_agree_on_how_they_move(first, second, words):
    words = f"beam 1 at s = 0 m is connected to .* another initial velocity{words}"
    with pytest.raises(ancf.InputError, match=words):
        System(crossing(first, second))
    assert System(crossing((0, 1), (0, 1))).v0[1] == 1.0


@pytest.mark.parametrize("order", [1, -1])
@pytest.mark.parametrize("speed", [1e-6, 1.0, 1e6])
def test_velocities_that_agree_up_to_rounding_are_taken(order, speed):
    scene = ancf.Scene()
    noise = 2e-16 * speed  # at the end of a rod whose other end moves fast
    beams = [
        lambda: cable(scene, (0, 0), (1, 0), velocity=lambda x: speed * np.c_[
            0 * x[:, 0], 1 - x[:, 0]] + (0.0, noise)),
        lambda: cable(scene, (1, 0), (2, 0)),
    ][::order]  # fmt: skip
    one, two = (beam() for beam in beams)
    scene.connect(one.end, two.start) if order == 1 else scene.connect(two.end, one.start)
    assert np.max(np.abs(System(scene).v0)) == pytest.approx(speed)


def test_a_velocity_that_is_no_number_beside_the_beam_is_refused():
    scene = ancf.Scene()
    scene.add_beam("thin", (0, 0), (1, 0), 2, SECTION, MATERIAL, velocity=lambda x: np.where(
        x < 0, np.nan, x))  # fmt: skip
    with pytest.raises(ancf.InputError, match=r"is not a number for .* coordinates"):
        System(scene)


def test_a_scene_that_cannot_move_is_refused():
    scene = ancf.Scene((0.0, -9.81, 0.0))
    rod = scene.add_beam("thick", (0, 0, 0), (1, 0, 0), 1, SECTION, MATERIAL)
    scene.clamp(rod.start)
    scene.clamp(rod.end)
    for solve in (System, ancf.solve_static, lambda scene: ancf.simulate(scene, 0.1, 0.1)):
        with pytest.raises(ancf.InputError, match="nothing can move"):
            solve(scene)
    with pytest.raises(ancf.InputError, match="a Scene is needed"):
        ancf.solve_static(None)


def swaying(length, speed, n, tilt, least=0.0):
    """A beam whose velocity across it starts with zero value and slope, or with another slope."""
    along = np.array([np.cos(tilt), np.sin(tilt)])

    def field(places):
        x = places @ along / length
        size = x**2 * (3.0 - x) * (1.0 + np.sin(4.0 * x)) + least * x
        return speed * np.outer(size, [-along[1], along[0]])

    scene = ancf.Scene((0.0, 0.0))
    section = ancf.Circle(0.02 * length)
    rod = scene.add_beam("thin", (0, 0), length * along, n, section, MATERIAL, velocity=field)
    return scene, rod


@pytest.mark.parametrize("tilt", [0.0, 0.3])
@pytest.mark.parametrize("n", [1, 10, 100])
@pytest.mark.parametrize(("length", "speed"), [(1e-6, 1e-6), (1.0, 1e-9), (1.0, 1e6), (1e4, 1.0)])
def test_a_clamp_takes_a_velocity_field_that_is_smooth_there(length, speed, n, tilt):
    for least, stretch in ((0.0, "free"), (0.0, "fixed"), (1e-6, "free")):
        scene, rod = swaying(length, speed, n, tilt, least)
        scene.clamp(rod.start, stretch)
        time = 1e-3 * length / max(speed, 1e2)
        if least == 0.0:
            assert ancf.simulate(scene, time, time).stats.steps == 1
            continue
        told = "initial velocity moves 1 held coord|initial velocities violate the clamp at beam 0 "
        with pytest.raises(ancf.InputError, match=told):
            ancf.simulate(scene, time, time)


def test_velocities_of_slopes_are_exact_beyond_the_rounding_of_results():
    scene, _ = swaying(2.0, 3.0, 10, 0.0)
    system = System(scene)
    x = np.linspace(0.0, 1.0, 11)
    swing, rise = x**2 * (3.0 - x), 6.0 * x - 3.0 * x**2
    slope = 1.5 * (rise * (1.0 + np.sin(4.0 * x)) + swing * 4.0 * np.cos(4.0 * x))
    found = system.v0[system.places[0]][:, 3]
    np.testing.assert_allclose(found, slope, rtol=0.0, atol=1e-11 * np.max(np.abs(slope)))
