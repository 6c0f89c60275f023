"""Equilibria of rigid bodies: on springs, on each other and on cables, beside closed forms."""

import numpy as np
import pytest
from scipy.integrate import quad, solve_bvp
from scipy.optimize import root

import ancfsparse as ancf
from tests.beams import build_beam
from tests.solve.statics.equilibria import eigenvalues, unbalanced

G = 9.81
SIZES = [1e-6, 1.0, 1e6]


def hung_rod(turn, *, size=1.0, dim=2, stiffness=30.0):
    """A rod of 2 kg, pinned at one end, the other on a spring without a length of its own.

    Its potential is linear in its direction u, so at rest u is along its gradient.
    """
    down = -G * np.eye(dim)[-1]
    hook = size * np.array([0.7, 0.4, 0.3])[-dim:]
    scene = ancf.Scene(down)
    orientation = turn if dim == 2 else (np.cos(turn / 2), 0.0, np.sin(turn / 2), 0.0)
    rod = scene.add_body(ancf.Rod(size), mass=2.0, position=np.zeros(dim), orientation=orientation)
    scene.pin(rod.origin)
    scene.spring(rod.end, hook, stiffness=stiffness / size, length=0.0)
    pull = stiffness / size * hook + 0.5 * 2.0 * down
    direction = pull / np.linalg.norm(pull)
    support = -2.0 * down - stiffness / size * (hook - size * direction)
    frequency = np.sqrt(np.linalg.norm(pull) * size / (2.0 * size**2 / 3.0)) / (2 * np.pi)
    return scene, rod, direction, support, frequency


def box_on_cable(n=8, *, size=1.0, load=0.5, arm=0.1, offset=0.0, thick=0.02):
    """A clamped cable of no weight with a box beyond its end, whose weight is `load` EI / L2."""
    section, modulus = ancf.Rectangle(thick * size, thick * size), 2e9
    weight = load * modulus * section.inertia_y / size**2
    material = ancf.Material(modulus, 1e-9 * weight / (G * section.area * size))
    scene, cable = build_beam("thin", (0, 0), (size, 0), n, section, material, "clamp")
    box = scene.add_body(
        ancf.Box(length=0.2 * size, width=0.2 * size, height=0.2 * size),
        mass=weight / G,
        position=((1.0 + arm) * size, offset * size),
    )
    scene.weld(cable.end, box.at((-arm * size, -offset * size)))
    return scene, cable, box, weight


def chain_of_two(size=1.0):
    """Two hinged bars on springs without lengths of their own, and where these are at rest."""
    length, mass = np.array([1.0, 0.7]) * size, np.array([2.0, 0.5])
    hooks = np.array([[1.2, 0.6], [1.5, 0.2]]) * size
    stiffness = np.array([40.0, 15.0]) / size
    scene = ancf.Scene()
    bars, ends = [], []
    for each, m, start in zip(length, mass, (0.0, length[0]), strict=True):
        box = ancf.Box(length=each, width=0.1 * size, height=0.1 * size)
        bars.append(scene.add_body(box, mass=m, position=(start + 0.5 * each, 0.0)))
        ends.append([bars[-1].at((side * each, 0)) for side in (-0.5, 0.5)])
    scene.pin(ends[0][0])
    scene.connect(ends[0][1], ends[1][0])
    for (_, end), hook, k in zip(ends, hooks, stiffness, strict=True):
        scene.spring(end, hook, stiffness=k, length=0.0)

    def moments(angles):
        u = np.stack([np.cos(angles), np.sin(angles)], axis=1)
        tips = np.cumsum(length[:, None] * u, axis=0)
        pulls = stiffness[:, None] * (hooks - tips)
        down = np.array([0.0, -G])
        # What acts on each bar at its far end, and at its centre.
        ends = [pulls[0] + pulls[1] + mass[1] * down, pulls[1]]
        forces = np.array([end + 0.5 * m * down for end, m in zip(ends, mass, strict=True)])
        return u[:, 0] * forces[:, 1] - u[:, 1] * forces[:, 0]

    angles = root(moments, [0.0, 0.0], tol=1e-14).x
    u = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return scene, bars[1], ends, np.cumsum(length[:, None] * u, axis=0)


def between_cables(join, size=1.0, *, apart=0.4):
    """A box of 3 kg between two clamped cables; if they meet, its weight alone."""
    section, material = ancf.Circle(0.01 * size), ancf.Material(1e8 / size**2, 1e-3 / size**3)
    scene = ancf.Scene()
    left = scene.add_beam("thin", (0, 0), (size, 0), 6, section, material)
    meet = (1.0 + apart) * size
    right = scene.add_beam("thin", (meet, 0), (meet + size, 0), 6, section, material)
    for held in (left.start, right.end):
        scene.clamp(held)
    if apart == 0.0:
        scene.connect(left.end, right.start)
        scene.point_force(left.end, (0.0, -3.0 * G))
        return scene, left, right, None
    shape = ancf.Box(length=0.4 * size, width=0.1 * size, height=0.1 * size)
    box = scene.add_body(shape, mass=3.0, position=(1.2 * size, 0.0))
    getattr(scene, join)(left.end, box.at((-0.2 * size, 0.0)))
    getattr(scene, join)(right.start, box.at((0.2 * size, 0.0)))
    return scene, left, right, box


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("turn", [0.0, np.pi / 2, -np.pi / 2, 1.0])
def test_a_rod_on_a_spring_is_along_the_gradient_of_its_potential(turn, dim, size):
    scene, rod, direction, support, _ = hung_rod(turn, size=size, dim=dim)
    found = ancf.solve_static(scene)
    np.testing.assert_allclose(found.position(rod.end) / size, direction, atol=1e-11)
    np.testing.assert_allclose(found.reaction(rod.origin), support, atol=1e-9)
    assert found.stable


@pytest.mark.parametrize("turn", [0.0, np.pi / 2, -np.pi / 2])
@pytest.mark.parametrize("stiffness", [0.1, 10.0, 40.0])
def test_a_box_beginning_along_an_axis_hangs_where_a_rod_does(stiffness, turn):
    """There no equation of its vectors meets the stiffness of the spring at first."""
    scene = ancf.Scene()
    box = scene.add_body(
        ancf.Box(length=1.0, width=0.1, height=0.2), mass=2.0, centre=(0.5, 0.0),
        position=(0, 0), orientation=turn,
    )  # fmt: skip
    scene.pin(box.origin)
    scene.spring(box.at((1.0, 0.0)), (0.4, 0.3), stiffness=stiffness, length=0.0)
    pull = stiffness * np.array([0.4, 0.3]) - [0.0, G]
    found = ancf.solve_static(scene)
    expected = pull / np.linalg.norm(pull)
    np.testing.assert_allclose(found.position(box.at((1.0, 0.0))), expected, atol=1e-9)
    assert found.stable
    assert eigenvalues(found).min() > 0.0


def test_an_arch_of_two_rods_without_any_stiffness_has_the_thrust_of_its_weight():
    for size in SIZES:
        scene = ancf.Scene()
        half, rise = 0.8 * size, 0.6 * size
        turn = np.arctan2(rise, half)
        left = scene.add_body(ancf.Rod(size), mass=2.0, position=(0, 0), orientation=turn)
        right = scene.add_body(
            ancf.Rod(size), mass=2.0, position=(2 * half, 0), orientation=np.pi - turn
        )
        for foot in (left.origin, right.origin):
            scene.pin(foot)
        scene.connect(left.end, right.end)
        found = ancf.solve_static(scene)
        thrust = 2.0 * G * half / (2.0 * rise)
        np.testing.assert_allclose(np.abs(found.lam[-2:]), [thrust, 0.0], atol=1e-9)
        np.testing.assert_allclose(found.position(left.end) / size, [0.8, 0.6], atol=1e-12)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("arm", [0.0, 0.1, 0.5])
def test_a_box_on_a_cable_bends_it_as_its_weight_and_moment_do(arm, size):
    """Beside the formula for small deflections, of which the square is left."""
    load = 1e-5
    scene, cable, box, weight = box_on_cable(size=size, load=load, arm=arm)
    found = ancf.solve_static(scene)
    expected = -load * (1.0 / 3.0 + arm / 2.0)
    assert found.displacement(cable.end)[1] / size == pytest.approx(expected, rel=1e-6)
    slope = -load * (0.5 + arm)
    assert found.slope(cable.end)[1] == pytest.approx(slope, rel=1e-6)
    np.testing.assert_allclose(found.reaction(cable.start) / weight, [0.0, 1.0], atol=1e-6)
    expected = -load * (1.0 / 3.0 + arm + arm**2)
    assert found.displacement(box.centre)[1] / size == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("load", [1.0, 4.0])
def test_a_heavy_box_bends_a_cable_to_the_elastica(load):
    """EI theta'' = W cos(theta) with the moment W arm cos(theta) at the end, by collocation."""
    arm = 0.3
    scene, cable, _, weight = box_on_cable(32, load=load, arm=arm, thick=0.002)
    found = ancf.solve_static(scene)

    def bends(s, y):
        return np.stack([y[1], load * np.cos(y[0])])

    def ends(a, b):
        return np.array([a[0], b[1] + load * arm * np.cos(b[0])])

    curve = solve_bvp(bends, ends, np.linspace(0, 1, 50), np.zeros((2, 50)), tol=1e-8)
    assert curve.success
    tip = [quad(lambda s, f=f: f(curve.sol(s)[0]), 0, 1, epsabs=1e-10)[0] for f in (np.cos, np.sin)]
    # It is extensible, by EI / (EA L2) = 3.3e-7 of the load, and divided into elements.
    np.testing.assert_allclose(found.position(cable.end), tip, atol=2e-6 * load)
    np.testing.assert_allclose(found.reaction(cable.start) / weight, [0.0, 1.0], atol=1e-6)


@pytest.mark.parametrize("size", SIZES)
def test_two_hinged_bars_on_springs_balance_their_moments(size):
    scene, _, ends, tips = chain_of_two(size)
    found = ancf.solve_static(scene)
    places = [found.position(end) / size for _, end in ends]
    np.testing.assert_allclose(places, tips / size, atol=1e-9)
    np.testing.assert_allclose(found.position(ends[1][0]) / size, places[0], atol=1e-12)
    assert unbalanced(found) < 1e-9
    assert found.stable


@pytest.mark.parametrize("join", ["connect", "weld"])
def test_a_box_between_two_cables_shares_its_weight(join):
    counts, hung = [], []
    for size in SIZES:
        scene, left, right, box = between_cables(join, size)
        found = ancf.solve_static(scene)
        one, other = found.reaction(left.start), found.reaction(right.end)
        assert one[1] == pytest.approx(1.5 * G, rel=2e-4)  # and the weight of the cables
        np.testing.assert_allclose(one, [-other[0], other[1]], rtol=1e-8)
        hung.append(found.position(box.origin) / size)
        counts.append(found.stats.factorizations)
    np.testing.assert_allclose(hung, [hung[1]] * 3, atol=1e-9)
    assert hung[1][0] == pytest.approx(1.2, abs=1e-10)
    assert len(set(counts)) == 1


def test_a_box_hinged_to_two_cables_bends_them_as_its_weight_does_where_they_meet():
    scene, left, right, _ = between_cables("connect")
    found = ancf.solve_static(scene)
    scene, one, other, _ = between_cables("connect", apart=0.0)
    expected = ancf.solve_static(scene)
    for mine, its, moved in ((left, one, 0.0), (right, other, 0.4)):
        for k in range(7):
            node = expected.position(its.node(k)) + np.array([moved, 0.0])
            np.testing.assert_allclose(found.position(mine.node(k)), node, atol=1e-9)


MADE = {
    "rod": lambda: hung_rod(0.0)[:2],
    "cable": lambda: box_on_cable(load=1.0, offset=0.05)[::2],
    "chain": lambda: chain_of_two()[:2],
    "between": lambda: between_cables("weld")[::3],
}


@pytest.mark.parametrize("name", MADE)
def test_what_is_at_rest_stays_there(name):
    scene, body = MADE[name]()
    rest = ancf.solve_static(scene)
    run = ancf.simulate(scene, t_end=1.0, dt=0.01, start=rest)
    assert np.abs(run.position(body.centre) - rest.position(body.centre)).max() < 1e-9


@pytest.mark.parametrize("turn", [0.0, 1.0])
def test_a_rod_on_a_spring_swings_about_its_equilibrium(turn):
    scene, _, _, _, frequency = hung_rod(turn)
    modes = ancf.modes(ancf.solve_static(scene), 1)
    assert modes.frequencies[0] == pytest.approx(frequency, rel=1e-9)


def test_modes_of_a_heavy_box_on_a_cable_are_those_of_a_massless_beam():
    """Of a weight whose own turn is nothing: omega2 = 3 EI / (m L3), bent by next to nothing."""
    scene, _, _, weight = box_on_cable(load=1e-4, arm=0.0)
    modes = ancf.modes(ancf.solve_static(scene), 2)
    ei = weight / 1e-4
    mass, inertia = weight / G, weight / G * (0.2**2 + 0.2**2) / 12
    stiffness = ei * np.array([[12.0, -6.0], [-6.0, 4.0]])
    expected = np.sqrt(np.linalg.eigvals(np.linalg.solve(np.diag([mass, inertia]), stiffness)))
    np.testing.assert_allclose(2 * np.pi * modes.frequencies, np.sort(expected), rtol=1e-5)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("natural", [2.5, 1.5])
def test_two_bars_in_line_without_loads_are_held_by_what_stresses_them(natural, size):
    """A spring at the slider stretches the bars, which then swing, or compresses and folds them.

    With y of the hinge the slider comes nearer by y^2 / L: the stiffness is 2 N / L and the mass
    2 m / 3.
    Folded, the spring has its own length.
    """
    scene = ancf.Scene((0.0, 0.0))
    bars = [
        scene.add_body(ancf.Rod(size), mass=1.0, position=(start * size, 0.0)) for start in (0, 1)
    ]
    slider = scene.add_body(mass=1.0, inertia=size**2, position=(2.0 * size, 0.0))
    scene.pin(bars[0].origin)
    scene.connect(bars[0].end, bars[1].origin)
    scene.connect(bars[1].end, slider.origin)
    scene.prismatic(slider.origin, axis=(1, 0))
    scene.spring(slider.origin, (0.0, 0.0), stiffness=200.0, length=natural * size)
    rest = ancf.solve_static(scene)
    assert rest.stable
    hinge = rest.position(bars[0].end) / size
    if natural > 2.0:
        np.testing.assert_allclose(hinge, (1.0, 0.0), atol=1e-9)
        swings = np.sqrt(2.0 * 200.0 * (natural - 2.0) / (2.0 / 3.0)) / (2.0 * np.pi)
        assert ancf.modes(rest, 1).frequencies[0] == pytest.approx(swings, rel=1e-9)
    else:
        expected = 0.5 * natural, np.sqrt(1.0 - (0.5 * natural) ** 2)
        np.testing.assert_allclose(np.abs(hinge), expected, atol=1e-9)
