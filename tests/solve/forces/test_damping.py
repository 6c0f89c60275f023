"""Damped motions against theory, and the energy that damping takes."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import pendulum
from tests.beams import build_beam

YOUNGS, DENSITY, SIDE, STEPS = 1e8, 1000.0, 0.02, 60
WAVE = np.sqrt(YOUNGS / DENSITY)
ELEMENTS = {
    "l2t2": {"element": "l2t2"},
    "thin": {"element": "thin"},
    "thin, biot": {"element": "thin", "strain": "biot"},
    "thin, spatial": {"element": "thin", "dim": 3},
    "thick": {"element": "thick", "section_strain": "nodal"},
    "thick, section": {"element": "thick", "section_strain": "nodal", "curvature": "section"},
    "thick, spatial": {"element": "thick", "section_strain": "nodal", "dim": 3},
}
"""Poisson's ratio is zero here, so that a thick beam is the beam of the textbook."""


def rod_of(joint, field, damping, element, dim=2, n_elements=8, **options):
    """A rod of 1 m, held at its left end and moving with field(x, y) -> (v_x, v_y)."""

    def velocity(places):
        out = np.zeros_like(places)
        out[:, 0], out[:, 1] = field(places[:, 0], places[:, 1])
        return out

    scene = ancf.Scene((0.0,) * dim)
    rod = scene.add_beam(
        element, (0.0,) * dim, (1.0,) + (0.0,) * (dim - 1), n_elements,
        ancf.Rectangle(SIDE, SIDE), ancf.Material(YOUNGS, DENSITY, 0.0, **damping),
        velocity=velocity, **options,
    )  # fmt: skip
    getattr(scene, joint)(rod.start)
    return scene, rod


# Fixed-free bar, pinned because a clamp holds the strain of a thick beam:
# v = sin(pi x / 2), omega = pi c / 2.
AXIAL_OMEGA = np.pi * WAVE / 2


def axial(size):
    return lambda x, y: (size * np.sin(np.pi * x / 2), 0.0)


# Clamped-free beam of Euler and Bernoulli, first root of cos b cosh b = -1.
ROOT = 1.8751040687119611
BENDING_OMEGA = ROOT**2 * WAVE * SIDE / np.sqrt(12.0)


def bending(size):
    """Deflection with 1 at the tip; sections turn with the axis."""
    ratio = (np.sinh(ROOT) - np.sin(ROOT)) / (np.cosh(ROOT) + np.cos(ROOT))

    def field(x, y):
        b = ROOT * x
        shape = np.cosh(b) - np.cos(b) - ratio * (np.sinh(b) - np.sin(b))
        slope = ROOT * (np.sinh(b) + np.sin(b) - ratio * (np.cosh(b) - np.cos(b)))
        return -size / 2 * y * slope, size / 2 * shape

    return field


def free_vibration(t, omega, zeta, size):
    """Displacement from rest with the velocity `size`: x'' + 2 zeta omega x' + omega^2 x = 0."""
    damped = omega * np.sqrt(1 - zeta**2)
    return size / damped * np.exp(-zeta * omega * t) * np.sin(damped * t)


def tip(make, omega, size, damping, steps, direction, **options):
    """Displacement of the tip over two periods, and the run."""
    joint = "pin" if make is axial else "clamp"
    scene, rod = rod_of(joint, make(size), damping, **options)
    dt = 2 * np.pi / omega / steps
    run = ancf.simulate(scene, 2 * steps * dt, dt, solver=ancf.Newton(), tolerance=1e-6 * size)
    return run, run.position(rod.end)[:, direction] - rod.end.position[direction]


def decrement(t, x):
    """Damping ratio from the first two maxima of a free vibration, each refined by a parabola."""
    peaks = []
    for k in range(1, len(x) - 1):
        if x[k - 1] < x[k] >= x[k + 1]:
            second = x[k - 1] - 2 * x[k] + x[k + 1]
            peaks.append(x[k] - (x[k + 1] - x[k - 1]) ** 2 / (8 * second))
    delta = np.log(peaks[0] / peaks[1])
    return delta / np.hypot(2 * np.pi, delta)


ZETA = 0.05
CASES = {
    "stretching": (axial, AXIAL_OMEGA, 1e-6 * WAVE, 0, {"axial_damping": 2 * ZETA / AXIAL_OMEGA}),
    "bending": (bending, BENDING_OMEGA, 1e-4, 1, {"bending_damping": 2 * ZETA / BENDING_OMEGA}),
    "Rayleigh's alpha": (bending, BENDING_OMEGA, 1e-4, 1,
                         {"rayleigh": (2 * ZETA * BENDING_OMEGA, 0.0)}),
    "Rayleigh's alpha, stretching": (axial, AXIAL_OMEGA, 1e-6 * WAVE, 0,
                                     {"rayleigh": (2 * ZETA * AXIAL_OMEGA, 0.0)}),
    "Rayleigh's beta": (bending, BENDING_OMEGA, 1e-4, 1,
                        {"rayleigh": (0.0, 2 * ZETA / BENDING_OMEGA)}),
}  # fmt: skip


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize("case", CASES)
def test_a_free_vibration_decays_as_theory_says(case, element):
    """zeta = omega tau / 2 for a retardation time, alpha / (2 omega) for Rayleigh's alpha."""
    make, omega, size, direction, damping = CASES[case]
    run, x = tip(make, omega, size, damping, STEPS, direction, **ELEMENTS[element])
    expected = free_vibration(run.t, omega, ZETA, size)
    assert decrement(run.t, x) == pytest.approx(ZETA, rel=0.01)
    # The trapezoidal rule lags by omega^3 dt^2 t / 12; shear softens the thick beam a little.
    assert np.abs(x - expected).max() < 0.02 * size / omega
    assert run.stats.recoveries == 0


@pytest.mark.parametrize("case", CASES)
def test_the_error_of_a_decaying_vibration_is_of_second_order(case):
    make, omega, size, direction, damping = CASES[case]
    errors, ratios = [], []
    for steps in (30, 60, 120):
        run, x = tip(make, omega, size, damping, steps, direction, element="thin")
        errors.append(np.abs(x - free_vibration(run.t, omega, ZETA, size)).max())
        ratios.append(abs(decrement(run.t, x) - ZETA))
    for found in (errors, ratios):
        np.testing.assert_allclose(np.divide(found[:-1], found[1:]), 4.0, rtol=0.05)


@pytest.mark.parametrize("element", ["l2t2", "thin", "thick"])
def test_stretching_and_bending_are_damped_apart(element):
    for make, omega, size, direction, other in (
        (axial, AXIAL_OMEGA, 1e-6 * WAVE, 0, {"bending_damping": 0.1 / AXIAL_OMEGA}),
        (bending, BENDING_OMEGA, 1e-4, 1, {"axial_damping": 0.1 / BENDING_OMEGA}),
    ):
        options = ELEMENTS[element]
        run, x = tip(make, omega, size, other, STEPS, direction, **options)
        _, free = tip(make, omega, size, {}, STEPS, direction, **options)
        assert np.abs(x - free).max() < 1e-3 * size / omega
        assert run.energy.dissipated[-1] < 1e-3 * run.energy.total[0]


@pytest.mark.parametrize("solver", [
    ancf.Newton(), ancf.ModifiedNewton(), ancf.QuasiNewton("bfgs", memory="full"),
    ancf.QuasiNewton("broyden", memory=5),
])  # fmt: skip
def test_a_translation_through_a_fluid_decays_exponentially(solver):
    """Nothing but alpha M v acts: v = v0 exp(-alpha t), x = v0 (1 - exp(-alpha t)) / alpha."""
    errors = []
    for dt in (0.02, 0.01, 0.005):
        scene = ancf.Scene((0.0, 0.0))
        rod = scene.add_beam(
            "thin", (0, 0), (1, 0), 3, ancf.Rectangle(SIDE, SIDE),
            ancf.Material(YOUNGS, DENSITY, rayleigh=(3.0, 0.0)), velocity=(0.3, 0.5),
        )  # fmt: skip
        run = ancf.simulate(scene, 1.0, dt, solver=solver)
        way = (1 - np.exp(-3.0 * run.t)) / 3.0
        errors.append(np.abs(run.position(rod.end) - (1, 0) - way[:, None] * (0.3, 0.5)).max())
    np.testing.assert_allclose(np.divide(errors[:-1], errors[1:]), 4.0, rtol=0.1)
    kinetic = run.energy.kinetic
    np.testing.assert_allclose(kinetic, kinetic[0] * np.exp(-6.0 * run.t), rtol=1e-3)
    np.testing.assert_allclose(run.energy.dissipated, kinetic[0] - kinetic, atol=1e-4 * kinetic[0])


def test_every_body_has_the_damping_of_its_own_material():
    """A net in a fluid, a bar in another, a bar in none."""
    scene, section = ancf.Scene((0.0, 0.0, 0.0)), ancf.Circle(0.01)
    nodes = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (1, 1, 0)]
    edges = [(0, 1), (2, 3), (0, 2), (1, 3)]
    thick = ancf.Material(YOUNGS, DENSITY, rayleigh=(2.0, 0.0))
    net = scene.add_mesh(nodes, edges, "thin", section, thick, velocity=(0, 0, 1))
    free = scene.add_beam("thick", (0, 0, 5), (1, 0, 5), 2, section,
                          ancf.Material(YOUNGS, DENSITY), velocity=(0, 0, 1))  # fmt: skip
    other = scene.add_beam("thick", (0, 0, 9), (1, 0, 9), 2, section,
                           ancf.Material(YOUNGS, DENSITY, rayleigh=(5.0, 0.0)),
                           velocity=(0, 0, 1))  # fmt: skip
    run = ancf.simulate(scene, 0.5, 0.01)
    for node, alpha in ((net.node(2), 2.0), (free.end, 0.0), (other.node(1), 5.0)):
        expected = np.exp(-alpha * run.t)
        np.testing.assert_allclose(run.velocity(node)[:, 2], expected, rtol=0, atol=5e-4)


@pytest.mark.parametrize("element", ["l2t2", "thin", "thick"])
def test_swinging_as_a_rigid_body_is_not_damped(element):
    """What a stiff pendulum loses goes to zero with its strains: like 1 / E for a given tau."""
    lost = []
    for youngs in (1e8, 1e9):
        scene = ancf.Scene((0.0, -9.81))
        material = ancf.Material(youngs, DENSITY, 0.0, axial_damping=1e-3, bending_damping=1e-3)
        options = {"section_strain": "nodal"} if element == "thick" else {}
        rod = scene.add_beam(element, (0, 0), (0.3, 0), 2, ancf.Rectangle(0.05, 0.05), material,
                             **options)  # fmt: skip
        scene.pin(rod.start)
        run = ancf.simulate(scene, 0.8, 1e-4)
        swung = run.energy.kinetic.max()
        assert np.abs(run.energy.total - run.energy.total[0]).max() < 2e-3 * swung
        lost.append(run.energy.dissipated[-1] / swung)
    assert 0 < lost[0] < 1e-4
    assert lost[0] / lost[1] == pytest.approx(10.0, rel=0.2)


def falling(element="thin", n=4, hold="pin", **damping):
    """Return a scene with a soft beam of 1 m that falls, and the beam."""
    section, material = ancf.Rectangle(SIDE, SIDE), ancf.Material(1e7, DENSITY, **damping)
    options = {"section_strain": "nodal"} if element == "thick" else {}
    return build_beam(element, (0, 0), (1, 0), n, section, material, hold, **options)


@pytest.mark.parametrize("element", ["l2t2", "thin", "thick"])
def test_the_balance_with_dissipation_is_of_second_order(element):
    """A soft pendulum in large motion with every kind of damping and a changing load."""
    drifts = []
    for dt in (4e-4, 2e-4, 1e-4):
        scene, rod = falling(
            element, axial_damping=1e-3, bending_damping=0.02, rayleigh=(0.5, 1e-3)
        )
        scene.point_force(rod.end, lambda t: (2.0 * np.sin(9.0 * t), 0.0))
        run = ancf.simulate(scene, 0.6, dt, solver=ancf.Newton(), tolerance=1e-6)
        energy = run.energy
        drifts.append(energy.drift)
        assert (np.diff(energy.dissipated) >= 0).all()
        assert energy.dissipated[-1] > 0.1 * energy.kinetic.max()
        assert np.abs(energy.work).max() > 0.05 * energy.kinetic.max()
    assert drifts[-1] < 1e-4
    assert drifts[0] > 3 * drifts[1] > 9 * drifts[2]


@pytest.mark.parametrize("integrator", [ancf.Newmark(), ancf.HHT(0.1), ancf.GeneralizedAlpha(0.8)])
def test_damped_motion_is_of_second_order_with_every_integrator(integrator):
    """A cantilever falling in a fluid, far bent; compared with itself at finer steps."""
    tips = []
    for dt in (4e-3, 2e-3, 1e-3, 5e-4):
        damping = {"bending_damping": 0.01, "rayleigh": (1.0, 0.0)}
        scene, rod = falling(n=3, hold="clamp", **damping)
        run = ancf.simulate(scene, 0.2, dt, integrator=integrator, solver=ancf.Newton(),
                            tolerance=1e-8)  # fmt: skip
        tips.append(run.position(rod.end)[-1])
    changes = np.linalg.norm(np.diff(tips, axis=0), axis=1)
    assert changes[-1] / changes[-2] == pytest.approx(0.25, rel=0.1)


def test_a_damped_pendulum_is_the_same_with_multipliers():
    paths, reactions = [], []
    for as_constraint in (False, True):
        damping = {"axial_damping": 1e-3, "bending_damping": 0.02, "rayleigh": (0.5, 0.0)}
        scene, rod = falling(hold="", **damping)
        scene.pin(rod.start, as_constraint=as_constraint)
        run = ancf.simulate(scene, 0.3, 5e-4, solver=ancf.Newton(), tolerance=1e-7)
        paths.append(run.position(rod.end))
        reactions.append(run.reaction(rod.start))
        assert run.energy.drift < 1e-4
    np.testing.assert_allclose(*paths, rtol=0, atol=1e-8)
    np.testing.assert_allclose(*reactions, rtol=0, atol=1e-3 * np.abs(reactions[0]).max())


def test_statics_does_not_feel_damping():
    tips = []
    for damping in ({}, {"bending_damping": 1.0, "axial_damping": 1.0, "rayleigh": (9.0, 0.1)}):
        scene, rod = falling(hold="clamp", **damping)
        tips.append(ancf.solve_static(scene).position(rod.end))
    np.testing.assert_array_equal(*tips)
    assert tips[0][1] < -0.1


def test_what_is_not_damped_loses_nothing():
    scene, _ = pendulum("thin", 4)
    run = ancf.simulate(scene, 0.2, 1e-3)
    assert not run.energy.dissipated.any()
