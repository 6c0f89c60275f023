"""Forces and moments that follow sections, and loads of any shape along a beam."""

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import eigvals

import ancfsparse as ancf
from ancfsparse.dispatch import compiled_module
from ancfsparse.errors import InputError
from ancfsparse.system import System
from tests.matrices import full

YOUNGS, DENSITY, SIDE, LENGTH = 2.1e11, 7800.0, 0.005, 1.0
SECTION, STEEL = ancf.Rectangle(SIDE, SIDE), ancf.Material(YOUNGS, DENSITY, 0.0)
EI = YOUNGS * SIDE**4 / 12.0


def cantilever(n, dim=2, element="thin", **options):
    z = (0.0,) * (dim - 1)
    scene = ancf.Scene((0.0, *z))
    rod = scene.add_beam(element, (0.0, *z), (LENGTH, *z), n, SECTION, STEEL, **options)
    scene.clamp(rod.start)
    return scene, rod


# Critical loads of columns: thrust per length of the shape, so that the normal force N(s) is its
# integral from s to the end; the tip alone for Beck's.
SHAPES = {"beck": None, "leipholz": lambda s: 1.0, "hauger": lambda s: 1.0 - s / LENGTH}


def by_galerkin(name, terms=14):
    """Load p at which w'''' + p N(s) w'' = w^2 w of a cantilever of length 1 first flutters."""
    x, weight = np.polynomial.legendre.leggauss(40)
    s, weight = 0.5 * (1.0 + x), 0.5 * weight
    normal = {"beck": np.ones_like(s), "leipholz": 1.0 - s, "hauger": 0.5 * (1.0 - s) ** 2}[name]
    shapes = [s**2 * np.polynomial.legendre.Legendre.basis(k, [0, 1])(s) for k in range(terms)]

    def second(k):
        poly = np.polynomial.Polynomial([0, 0, 1]) * np.polynomial.legendre.Legendre.basis(
            k, [0, 1]
        ).convert(kind=np.polynomial.Polynomial)
        return poly.deriv(2)(s)

    bends = [second(k) for k in range(terms)]
    mass = np.array([[weight @ (a * b) for b in shapes] for a in shapes])
    stiff = np.array([[weight @ (a * b) for b in bends] for a in bends])
    load = np.array([[weight @ (a * normal * b) for b in bends] for a in shapes])
    low, high = 1.0, 300.0
    for _ in range(60):
        p = 0.5 * (low + high)
        roots = eigvals(stiff + p * load, mass)
        roots = roots[np.argsort(np.abs(roots))][:2]
        low, high = (low, p) if np.abs(roots.imag).max() > 1e-6 * abs(roots[0]) else (p, high)
    return p


def critical(name, n):
    """Load at which the two lowest frequencies meet: their difference squared is linear there."""

    def split(p):
        scene, rod = cantilever(n)
        if name == "beck":
            scene.point_force(rod.end, (-p * EI / LENGTH**2, 0.0), follow=True)
        else:
            shape = SHAPES[name]
            scene.distributed_force(rod, (-p * EI / LENGTH**3, 0.0), shape=shape, follow=True)
        found = ancf.complex_modes(ancf.solve_static(scene), 2)
        return found, np.real((found.eigenvalues[1] ** 2 - found.eigenvalues[0] ** 2) ** 2)

    exact = {"beck": 20.05, "leipholz": 40.05, "hauger": 150.0}[name]
    below, above = 0.999 * exact, 1.001 * exact
    one, two = split(below)[1], split(above)[1]
    return below + (above - below) * one / (one - two)


@pytest.mark.parametrize("name", SHAPES)
def test_columns_under_thrust_that_follows_flutter(name):
    expected = by_galerkin(name)
    # Published: Beck (1952) 20.05, Leipholz (1962) 40.05.
    published = {"beck": 20.05, "leipholz": 40.05}
    if name in published:
        assert expected == pytest.approx(published[name], abs=0.01)
    assert critical(name, 12) == pytest.approx(expected, rel=1e-3)


def test_becks_column_grows_beyond_its_critical_load():
    for p, stable in ((20.0, True), (20.1, False)):
        scene, rod = cantilever(8)
        scene.point_force(rod.end, (-p * EI / LENGTH**2, 0.0), follow=True)
        found = ancf.complex_modes(ancf.solve_static(scene), 2)
        assert found.stable is stable
        assert (found.growth.max() > 0.01 * found.eigenvalues[0].imag) is not stable


def elastica(share):
    """Tip of a cantilever of length 1 under a force on it that stays normal to it, by its ODE.

    From the tip back: there the force and the bending moment (none) are known in its frame.
    """

    def rate(u, state):
        angle, kappa = state[2:]
        # Away from the tip, against s: the force is (0, share) in the frame of the tip.
        return [-math.cos(angle), -math.sin(angle), -kappa, share * math.cos(angle)]

    x, y, angle, _ = solve_ivp(rate, (0, 1), [0.0] * 4, rtol=1e-11, atol=1e-12).y[:, -1]
    turn = np.array([[math.cos(angle), math.sin(angle)], [-math.sin(angle), math.cos(angle)]])
    return turn @ -np.array([x, y])


@pytest.mark.parametrize("share", [0.5, 4.0, 10.0])
def test_a_normal_force_that_follows_the_tip_bends_a_cantilever(share):
    scene, rod = cantilever(24, strain="biot")
    scene.point_force(rod.end, (0.0, share * EI / LENGTH**2), follow=True)
    tip = ancf.solve_static(scene).position(rod.end)
    stretch = share * EI / LENGTH**2 / (YOUNGS * SIDE**2)  # which the formula does not have
    np.testing.assert_allclose(tip, elastica(share) * LENGTH, atol=2e-6 + 2.0 * stretch)


def test_a_thick_beam_in_space_takes_components_along_all_axes():
    planar, rod = cantilever(12)
    planar.point_force(rod.end, (30.0, 2.0), follow=True)
    expected = ancf.solve_static(planar).displacement(rod.end)
    for value in ((30.0, 2.0, 0.0), (30.0, 0.0, 2.0)):
        scene, beam = cantilever(12, 3, "thick", section_strain="nodal")
        scene.point_force(beam.end, value, follow=True)
        found = ancf.solve_static(scene).displacement(beam.end)
        np.testing.assert_allclose([found[0], max(found[1:])], expected, rtol=3e-3)


def test_moments_that_follow_roll_a_beam_into_a_circle():
    off = []
    for n in (20, 40):
        scene, rod = cantilever(n, 3, "thick", section_strain="nodal")
        scene.point_moment(rod.end, (0.0, 2.0 * math.pi * EI / LENGTH, 0.0), follow=True)
        rest = ancf.solve_static(scene, load_steps=4)
        middle = rest.position(rod.node(n // 2)) + np.array([0.0, 0.0, LENGTH / math.pi])
        off.append([np.linalg.norm(each) / LENGTH for each in (rest.position(rod.end), middle)])
    assert np.max(off[1]) < 0.01
    np.testing.assert_allclose(np.array(off[0]) / off[1], 4.0, rtol=0.15)  # second order


def test_a_moment_that_follows_the_end_makes_a_helix():
    # The moment is constant along the rod, and its tangent turns about it at the rate M / EI.
    moment = np.array([0.8, 0.0, 2.0]) * EI / LENGTH
    size = np.linalg.norm(moment)
    cosine, rate = moment[0] / size, size / EI
    radius = math.sqrt(1.0 - cosine**2) / rate
    chord = math.hypot(LENGTH * cosine, 2.0 * radius * math.sin(0.5 * rate * LENGTH))
    tips = {}
    for n, follow in ((20, True), (40, True), (40, False)):
        scene, rod = cantilever(n, 3, "thick", section_strain="nodal")
        scene.point_moment(rod.end, moment, follow=follow)
        tips[n, follow] = ancf.solve_static(scene, load_steps=4).position(rod.end)
    off = [np.linalg.norm(tips[n, True]) / chord - 1.0 for n in (20, 40)]
    assert abs(off[1]) < 5e-4
    assert off[0] / off[1] == pytest.approx(4.0, rel=0.1)  # second order
    # With axes fixed in space the shape is another one.
    assert np.linalg.norm(tips[40, False] - tips[40, True]) > 0.05 * LENGTH


@pytest.mark.parametrize("follow", [False, True])
@pytest.mark.parametrize(
    ("shape", "factor"),
    [
        (None, 1.0 / 8.0),
        (lambda s: 1.0 - s / LENGTH, 1.0 / 30.0),
        (lambda s: s / LENGTH, 11.0 / 120.0),
        (lambda s: (s / LENGTH) ** 2, 13.0 / 180.0),
    ],
)
def test_small_deflections_under_loads_of_any_shape(follow, shape, factor):
    load = 1e-4
    scene, rod = cantilever(6)
    scene.distributed_force(rod, (0.0, load), shape=shape, follow=follow)
    tip = ancf.solve_static(scene, tolerance=1e-12).displacement(rod.end)
    assert tip[1] == pytest.approx(factor * load * LENGTH**4 / EI, rel=1e-7)


@pytest.mark.parametrize(
    ("dim", "element"), [(2, "thin"), (3, "thick"), (3, "thin"), (2, "string"), (3, "string")]
)
def test_the_derivative_is_that_of_the_force(dim, element):
    z = (0.0,) * (dim - 1)
    scene = ancf.Scene((0.0, *z))
    rod = scene.add_beam(element, (0.0, *z), (LENGTH, *z), 3, SECTION, STEEL)
    scene.pin(rod.start)
    one = dim == 3 and element != "thick"
    scene.point_force(rod.at(0.4), 3.0 if one else (3.0, -5.0, 7.0)[:dim], follow=True)
    value = -2.0 if one else (2.0, 1.0, -4.0)[:dim]
    scene.distributed_force(rod, value, shape=lambda s: 1.0 + s, follow=True)
    system = System(scene)
    part = next(
        made
        for each, made in zip(system.contributions, system.assembly.contributions, strict=True)
        if not each.conservative
    )
    alone = compiled_module("assembly").Assembly(
        system.n_free, system.n_all, system.loads.n_amplitudes, system.pattern.indptr, [part]
    )
    amplitudes = system.loads.amplitudes(np.zeros(1))[0]
    none, lam = np.zeros(system.n_all), np.zeros(0)
    q = system.q_ref + 0.05 * np.random.default_rng(0).standard_normal(system.n_all)
    n, small = system.n_free, 1e-6

    def force(q):
        return np.array(alone.residual(q, none, none, lam, none, amplitudes)[0])[:n]

    moved = small * np.eye(n, system.n_all)
    exact = np.stack([(force(q + d) - force(q - d)) / (2.0 * small) for d in moved], axis=1)
    found = full(system, alone.matrix(0.0, 1.0, q, lam, amplitudes))
    np.testing.assert_allclose(found, 0.5 * (exact + exact.T), atol=1e-8)


def test_thrust_on_a_rigid_body_turns_with_it():
    scene = ancf.Scene((0.0, 0.0))
    body = scene.add_body(mass=2.0, inertia=0.5, position=(0.0, 0.0), orientation=0.3)
    force, arm = 1.5, 0.4
    scene.point_force(body.at((arm, 0.0)), (0.0, force), follow=True)
    run = ancf.simulate(scene, 2.0, 1e-3, tolerance=1e-11)
    angle = run.position(body.at((1.0, 0.0))) - run.position(body.centre)
    found = np.unwrap(np.arctan2(angle[:, 1], angle[:, 0]))
    np.testing.assert_allclose(found, 0.3 + 0.5 * force * arm / 0.5 * run.t**2, atol=2e-5)
    total = run.energy.total
    # The force does work: half of omega squared times the inertia, and that of the centre.
    assert total[-1] > 0.9


def test_the_energy_of_a_run_includes_the_work_of_following_forces():
    scene, rod = cantilever(6, 3, "thick", section_strain="nodal")
    scene.point_force(rod.end, lambda t: (0.0, 20.0 * t**2, 900.0 * t**3), follow=True)
    scene.distributed_force(rod, lambda t: (0.0, 0.0, 300.0 * t**2), follow=True)
    scene.point_moment(rod.end, lambda t: (8.0 * t**2, 0.0, 40.0 * t**2), follow=True)
    ends = []
    for dt in (4e-4, 2e-4):
        run = ancf.simulate(scene, 0.08, dt, integrator=ancf.Newmark(0.0), tolerance=1e-10)
        power = run.system.power(run.q, run.v, run.t)
        work = np.concatenate([[0.0], np.cumsum(0.5 * dt * (power[1:] + power[:-1]))])
        gained = run.energy.kinetic + run.energy.elastic
        ends.append(np.abs(gained - work).max() / gained.max())
    assert ends[1] < 0.35 * ends[0]
    assert ends[1] < 5e-3


def test_following_loads_are_checked():
    scene, rod = cantilever(4, 3)
    with pytest.raises(InputError, match="only axis that a cable has in space"):
        scene.point_force(rod.end, (1.0, 0.0, 0.0), follow=True)
    scene.point_force(rod.end, 1.0, follow=True)
    with pytest.raises(InputError, match="no axis but the slope"):
        scene.point_moment(rod.end, (0.0, 1.0, 0.0), follow=True)
    string = scene.add_beam("string", (0, 1, 0), (1, 1, 0), 4, SECTION, STEEL)
    with pytest.raises(InputError, match="jumps at the nodes of a string"):
        scene.point_force(string.end, 1.0, follow=True)
    scene.point_force(string.at(0.1), 1.0, follow=True)
    with pytest.raises(InputError, match="follow"):
        scene.point_force(rod.end, 1.0, follow="yes")
    with pytest.raises(InputError, match="shape must be a function of the arc coordinate"):
        scene.distributed_force(rod, (0.0, 0.0, 1.0), shape=2.0)
    with pytest.raises(InputError, match=r"shape of .* at s = 1 m failed: ZeroDivisionError"):
        scene.distributed_force(rod, (0.0, 0.0, 1.0), shape=lambda s: 1.0 / (1.0 - s))
    with pytest.raises(InputError, match="at s = 0 m"):
        scene.distributed_force(rod, (0.0, 0.0, 1.0), shape=lambda s: math.nan)
