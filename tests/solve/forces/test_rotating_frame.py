"""Scenes in a rotating frame: equilibria, vibrations and motions about a steady rotation."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ancfsparse as ancf
from ancfsparse.system import System
from tests.beams import build_beam
from tests.solve.refusals import assert_refused

# Rotating cantilevers (Wright, Smith, Thresher and Wang, J. Appl. Mech. 49, 1982, table 1; Hodges
# and Rutkowski, AIAA J. 19, 1981): frequencies across the plane of rotation over sqrt(EI/mL^4).
WRIGHT = {
    2.0: (4.1373, 22.6149, 62.2732),
    6.0: (7.3604, 26.8091, 66.6840),
    12.0: (13.1702, 37.6031, 79.6145),
}
SQUARE, SOFT = ancf.Rectangle(1e-3, 1e-3), ancf.Material(1e10, 1000.0)
UNIT = np.sqrt(1e10 * 1e-6 / 12.0 / 1000.0)  # of the frequencies of a beam of 1 m [rad/s]


def blade(n, speed, dim=3):
    """Return a scene with a clamped blade of 1 m along +x that rotates about its root."""
    zero = (0.0,) * dim
    scene, beam = build_beam("thin", zero, np.eye(dim)[0], n, SQUARE, SOFT, "clamp", gravity=zero)
    scene.rotating_frame(speed if dim == 2 else (0.0, 0.0, speed))
    return scene, beam


@pytest.mark.parametrize("eta", WRIGHT)
def test_a_rotating_cantilever_vibrates_as_published(eta):
    """Across the plane; in it the squares are less by that of the speed."""
    scene, _ = blade(16, eta * UNIT)
    found = ancf.complex_modes(ancf.solve_static(scene), 6)
    omega = 2.0 * np.pi * found.frequencies / UNIT
    np.testing.assert_allclose(omega[1::2], WRIGHT[eta], rtol=1e-4)
    np.testing.assert_allclose(np.sqrt(omega[::2] ** 2 + eta**2), WRIGHT[eta], rtol=1e-4)
    assert found.stable


def test_the_plane_and_space_agree_along_any_axis():
    """A planar scene, the same in space, and the same turned with its axis."""
    speed = 5.0 * UNIT
    planar = ancf.complex_modes(ancf.solve_static(blade(8, speed, 2)[0]), 2).frequencies
    spatial = ancf.complex_modes(ancf.solve_static(blade(8, speed)[0]), 4).frequencies
    np.testing.assert_allclose(spatial[::2], planar, rtol=1e-7)
    turn = np.linalg.qr(np.random.default_rng(3).standard_normal((3, 3)))[0]
    turn *= np.linalg.det(turn)
    scene, point = ancf.Scene((0.0, 0.0, 0.0)), np.array([3.0, -2.0, 1.0])
    beam = scene.add_beam("thin", point, point + turn[:, 0], 8, SQUARE, SOFT)
    scene.clamp(beam.start)
    scene.rotating_frame(speed * turn[:, 2], point=point)
    found = ancf.complex_modes(ancf.solve_static(scene), 4).frequencies
    np.testing.assert_allclose(found, spatial, rtol=1e-6)


def spun_rope(n, youngs_modulus, speed=7.0):
    """Return a scene with a rope of 1 m along +x, pinned on the axis of rotation."""
    material = ancf.Material(youngs_modulus, 4e3)
    scene, rope = build_beam(
        "thin", (0, 0, 0), (1, 0, 0), n, ancf.Circle(1e-4), material, "pin", gravity=(0, 0, 0)
    )
    scene.rotating_frame((0.0, 0.0, speed))
    return scene, rope


def test_a_rotating_string():
    """Pinned on the axis: omega^2 = n (2 n - 1) Omega^2 across the plane, one less in it."""
    speed = 7.0
    scene, rope = spun_rope(24, 1e8, speed)
    rest = ancf.solve_static(scene)
    # Stretch: (L^2 - s^2) rho Omega^2 / 2 E, a first approximation.
    assert rest.position(rope.end)[0] - 1.0 == pytest.approx(4e3 * speed**2 / 3e8, rel=2e-3)
    squares = (2.0 * np.pi * ancf.complex_modes(rest, 5).frequencies / speed) ** 2
    # It turns about the axis freely, and across as a rigid pendulum.
    np.testing.assert_allclose(squares[:2], (0.0, 1.0), atol=1e-9)
    np.testing.assert_allclose(squares[2:], (5.0, 6.0, 14.0), rtol=5e-3)


@pytest.mark.parametrize("n", [8, 32])
def test_a_free_rotation_is_zero_also_beside_large_stiffness(n):
    """Stress by strains of 1e-7 rounds to 5e-10 of the centrifugal forces: that is no growth."""
    found = ancf.complex_modes(ancf.solve_static(spun_rope(n, 1e12)[0]), 3)
    assert found.eigenvalues[0] == 0.0
    assert found.stable
    assert 2.0 * np.pi * found.frequencies[1] == pytest.approx(7.0, rel=1e-7)


def test_the_stretch_of_a_spinning_bar():
    """tan(a L) / a - L with a^2 = rho Omega^2 / E, for strains linear in the displacement."""
    scene = ancf.Scene((0.0, 0.0))
    bar = scene.add_beam("thin", (0, 0), (10, 0), 32, ancf.Rectangle(0.1, 0.1),
                         ancf.Material(2.8e9, 120.0), strain="biot")  # fmt: skip
    scene.clamp(bar.start, stretch="free")
    scene.rotating_frame(60.0)
    a = 60.0 * np.sqrt(120.0 / 2.8e9)
    rest = ancf.solve_static(scene)
    found = rest.position(bar.end)[0] - 10.0
    assert found == pytest.approx(np.tan(10.0 * a) / a - 10.0, rel=1e-4)
    # The root pulls with E A times its strain, 1 / cos(a L) - 1.
    pull = 2.8e7 * (1.0 / np.cos(10.0 * a) - 1.0)
    np.testing.assert_allclose(rest.reaction(bar.start), (-pull, 0.0), rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("speed", [0.5, 2.0, 3.0])
@pytest.mark.parametrize("lossy", [False, True])
def test_a_jeffcott_rotor(speed, lossy):
    """Whirl about the critical speed 1, where internal damping makes it unstable."""
    c = 0.2 if lossy else 0.0
    scene = ancf.Scene((0.0, 0.0))
    disc = scene.add_body(mass=2.0, inertia=0.3, position=(0, 0))
    for end in [(1, 0), (-1, 0), (0, 1), (0, -1)]:
        # Two along each axis make 2 N/m; those across it are taut by no force.
        scene.spring(disc.origin, end, stiffness=1.0, damping=c, length=1.0)
    scene.rotating_frame(speed)
    rest = ancf.simulate(scene, 1e-3, 1e-3).last  # the disc is free to turn: statics has no answer
    found = ancf.complex_modes(scene, 3, at=rest)
    # z'' + 2 i Omega z' - Omega^2 z + (c/m) z' + z = 0 for z = x + i y, and its conjugate.
    roots = np.roots([1.0, 2j * speed + c, 1.0 - speed**2])
    roots = np.where(roots.imag < 0.0, roots.conj(), roots)
    roots = roots[np.argsort(np.abs(roots))]
    moving = found.eigenvalues[np.abs(found.eigenvalues) > 1e-6]
    np.testing.assert_allclose(moving, roots, rtol=1e-9, atol=1e-9)
    assert found.stable == (not lossy or speed < 1.0)


def test_a_gyroscope_whirls_as_formulas_say():
    """A disc on a ball joint and springs: A w^2 - C W w = k in space, w - W in the frame."""
    a, c, speed, stiffness = 0.2, 0.3, 11.0, 40.0
    scene = ancf.Scene((0.0, 0.0, 0.0))
    disc = scene.add_body(mass=1.0, inertia=(a, a, c), position=(0, 0, 0))
    scene.pin(disc.origin)
    top = disc.at((0, 0, 1))
    for end in [(2, 0, 1), (-2, 0, 1), (0, 2, 1), (0, -2, 1)]:
        scene.spring(top, end, stiffness=0.5 * stiffness, length=2.0)
    scene.rotating_frame((0.0, 0.0, speed))
    rest = ancf.simulate(scene, 1e-3, 1e-3).last
    found = ancf.complex_modes(scene, 3, at=rest)
    whirl = np.roots([a, -c * speed, -stiffness])
    expected = np.sort(np.abs(whirl - speed))
    np.testing.assert_allclose(2.0 * np.pi * found.frequencies[1:], expected, rtol=1e-8)
    assert found.frequencies[0] == pytest.approx(0.0, abs=1e-6)
    assert found.stable


SPIN = np.array([0.4, -0.7, 2.0])


def thrown(frame):
    """Return a beam with a mass, hinged to a body: in space, or in a frame that rotates."""
    scene = ancf.Scene((0.0, 0.0, 0.0))
    point = np.array([0.3, 0.1, -0.2])
    spin = np.zeros(3) if frame else SPIN

    def velocity(x):
        return np.cross(spin, x - point) + np.outer(x[:, 0], [0.0, 0.5, 1.0])

    start, end = np.array([0.0, 0.0, 0.0]), np.array([1.0, 0.0, 0.0])
    rod = scene.add_beam("thick", start, end, 3, ancf.Rectangle(0.05, 0.02),
                         ancf.Material(2e7, 1000.0), velocity=velocity, name="rod")  # fmt: skip
    box = scene.add_body(ancf.Box(length=0.4, width=0.1, height=0.2), mass=0.7, position=end,
                         name="box",
                         velocity=velocity(end[None])[0], angular_velocity=spin)  # fmt: skip
    scene.connect(rod.end, box.origin)
    scene.add_mass(rod.at(0.4), 0.3)
    scene.add_mass(rod.start, 0.1, inertia=(1e-3, 2e-3, 2.5e-3))
    if frame:
        scene.rotating_frame(SPIN, point=point)
    return scene, rod, box, point


@pytest.mark.parametrize(
    "integrator", [ancf.DormandPrince(), ancf.GeneralizedAlpha(0.9), ancf.EnergyMomentum()]
)
def test_a_motion_is_the_same_in_both_frames(integrator):
    """Centrifugal and Coriolis forces on beams, bodies and masses, at the order of the method."""
    explicit = isinstance(integrator, ancf.DormandPrince)
    steps = (1e-4,) if explicit else (2e-3, 1e-3)
    options = {} if explicit else {"tolerance": 1e-10}
    far = []
    for dt in steps:
        places = []
        for frame in (False, True):
            scene, rod, box, point = thrown(frame)
            run = ancf.simulate(scene, 0.4, dt, integrator=integrator, **options)
            there = np.stack([run.position(rod.start), run.position(box.at((0.2, 0.1, 0.0)))], 1)
            if frame:
                turn = Rotation.from_rotvec(np.outer(run.t, SPIN))
                there = np.stack(
                    [turn.apply(x - point) + point for x in np.moveaxis(there, 1, 0)], 1
                )
                assert run.energy.drift < (1e-7 if explicit else 2e-3)
            places.append(there)
        far.append(np.abs(places[0] - places[1]).max())
    if explicit:
        assert far[0] < 1e-8
    else:
        assert far[0] < 2e-3
        assert far[1] < 0.3 * far[0]


def test_energy_momentum_keeps_the_energy_in_the_frame():
    """With the potential of the centrifugal forces; Coriolis forces do no work."""
    scene = thrown(True)[0]
    run = ancf.simulate(scene, 0.4, 2e-3, integrator=ancf.EnergyMomentum(), tolerance=1e-12)
    assert np.ptp(run.energy.total) < 1e-9 * run.energy.kinetic.max()
    assert run.energy.potential[0] < 0.0


def test_bodies_in_a_frame_that_turns_fast_in_a_step_keep_their_energy():
    """0.2 rad: generalised-alpha was taken, for bodies at rest in the frame, and gained energy."""
    scene = ancf.Scene((0.0, 0.0))
    upper = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(0, 0))
    lower = scene.add_body(ancf.Rod(1.0), mass=1.0, position=(1, 0), orientation=0.5)
    scene.pin(upper.origin)
    scene.connect(upper.end, lower.origin)
    scene.rotating_frame(40.0)
    run = ancf.simulate(scene, 0.2, 5e-3)
    assert run.energy.drift < 1e-6


def test_a_small_vibration_of_a_run_has_the_frequency_of_its_mode():
    scene, beam = blade(6, 4.0 * UNIT, 2)
    rest = ancf.solve_static(scene)
    modes = ancf.complex_modes(rest, 2)
    period = 1.0 / modes.frequencies[0]
    run = ancf.simulate(
        scene, 2.0 * period, period / 400, start=modes.moving(0, 1e-5), tolerance=1e-10
    )
    across = run.position(beam.end)[:, 1]
    late = across[[0, 400, 800]]
    np.testing.assert_allclose(late, late[0], atol=1e-3 * np.abs(across).max())
    crossings = np.flatnonzero(np.diff(np.sign(across)))
    at = crossings - across[crossings] / (across[crossings + 1] - across[crossings])
    assert np.mean(np.diff(at)) * period / 400 == pytest.approx(0.5 * period, rel=2e-4)


def test_forces_of_a_frame_are_derivatives_of_their_potential():
    scene = thrown(True)[0]
    system = System(scene)
    random = np.random.default_rng(0)
    q = system.q0 + 0.1 * random.standard_normal(system.n_all)
    dq, none = random.standard_normal((2, system.n_all)) * [[1.0], [0.0]]
    lam, one = np.zeros(system.n_multipliers), np.ones(system.loads.n_amplitudes)
    frame = system.contributions[-1]
    alone = [
        np.asarray(system.assembly.residual(q, none, none, lam, none, share * one)[0])
        for share in (0.0, 1.0)
    ]
    energies = frame.potential(np.stack([q + dq, q - dq]))
    assert (alone[1] - alone[0]) @ dq == pytest.approx(0.5 * (energies[0] - energies[1]), rel=1e-9)
    elastic = system.energies(q[None], none[None])[1]
    scene_in_space = thrown(False)[0]
    assert elastic[0] == pytest.approx(System(scene_in_space).energies(q[None], none[None])[1][0])
    skew = system.gyroscopic
    assert abs(skew + skew.T).max() < 1e-14 * abs(skew).max()


def test_a_rotating_frame_is_printed_and_checked():
    scene, _ = blade(3, 2.0)
    assert "rotating frame: angular_velocity (0, 0, 2) rad/s" in str(scene)
    assert_refused("rotating frame already", scene.rotating_frame, (0.0, 0.0, 1.0))
    assert_refused("take complex_modes", ancf.modes, ancf.solve_static(scene), 2)
    assert_refused("no equilibrium in a rotating frame", ancf.complex_modes, scene, 2)
    planar = ancf.Scene((0.0, 0.0))
    assert_refused("angular velocity of the rotating frame", planar.rotating_frame, (0.0, 0.0, 1.0))
    assert_refused(r"at most 1e\+50 rad/s", planar.rotating_frame, 1e150)
    assert_refused("point of the rotating frame", planar.rotating_frame, 1.0, point=(0.0, 0.0, 1.0))
