"""Beams along curves: free of stress there, bent into them, slack or taut."""

import math
import tomllib

import numpy as np
import pytest
import scipy.sparse.linalg as sla

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import stiffness
from tests.paths import REFERENCES

REFERENCES = tomllib.loads((REFERENCES / "curved.toml").read_text(encoding="utf-8"))
THICK = [
    {"curvature": curvature, "section_strain": section_strain}
    for curvature in ("axis", "section")
    for section_strain in ("consistent", "nodal")
]
THIN = [{"strain": "green"}, {"strain": "biot"}]
PLANAR = [("thin", each) for each in THIN] + [("thick", each) for each in THICK]
STEEL = ancf.Material(2.06e11, 7850.0, poisson_ratio=0.3)


def tangent(system):
    """Stiffness at the start over the free coordinates."""
    return stiffness(system, system.q0)


def circle(dim, radius=1.0, angle=2.0 * math.pi):
    if dim == 2:
        return ancf.Arc((0, 0), (radius, 0), angle)
    return ancf.Arc((0, 0, 0), (radius, 0, 0), angle, axis=(0, 0, 1))


SHAPES = [
    *((each, circle(2)) for each in PLANAR),
    *((("thick", each), circle(3)) for each in THICK),
    *((("thick", each), ancf.Helix(0.5, 0.3, 2.0)) for each in THICK),
]


@pytest.mark.parametrize(("element", "curve"), SHAPES)
def test_a_curved_reference_stores_nothing_and_moves_only_as_a_rigid_body(element, curve):
    name, options = element
    dim = 3 if isinstance(curve, ancf.Helix) else len(curve.centre)
    scene = ancf.Scene(np.zeros(dim))
    section = ancf.Rectangle(0.05, 0.03)
    rod = scene.add_beam(
        name, curve=curve, n_elements=16, section=section, material=STEEL, **options
    )
    system = System(scene)
    stiffness = STEEL.youngs_modulus * section.area
    assert system.assembly.strain_energy(system.q_ref) <= 1e-28 * stiffness * rod.length
    assert np.abs(system.assembly.force(system.q_ref)).max() <= 1e-13 * stiffness
    # In units in which slopes and positions weigh alike.
    is_position = np.isin(np.arange(system.n_all), system.positions)
    unit = np.where(is_position, rod.shortest, 1.0)
    sizes = np.linalg.eigvalsh(unit[:, None] * tangent(system).toarray() * unit)
    rigid = {2: 3, 3: 6}[dim]
    assert np.abs(sizes[:rigid]).max() <= 1e-13 * sizes[-1]
    assert sizes[rigid] > 1e-9 * sizes[-1]


@pytest.mark.parametrize(
    ("element", "counts", "order"),
    [
        (("thin", {"strain": "green"}), (8, 16, 32), 4.0),
        (("thin", {"strain": "biot"}), (8, 16, 32), 4.0),
        (("thick", {"section_strain": "nodal"}), (64, 128, 256), 2.0),
        (("thick", {"curvature": "section", "section_strain": "nodal"}), (16, 32, 64), 2.0),
        (("thick", {}), (128, 256, 512), 2.0),
    ],
)
def test_a_half_ring_is_straightened_by_a_moment(element, counts, order):
    """The curvature becomes 1/R + M/EI all along: with M = -EI/R the ring is a line of length pi R.

    Green's strain and a section that bends change the length by shares of (b/R)^2 = 1e-6.
    """
    name, options = element
    section, material = ancf.Rectangle(1e-3, 1e-3), ancf.Material(1e9, 1e3)
    errors = []
    for n in counts:
        scene = ancf.Scene((0.0, 0.0))
        ring = scene.add_beam(
            name, curve=circle(2, 1.0, math.pi), n_elements=n, section=section, material=material,
            **options,
        )  # fmt: skip
        scene.clamp(ring.start)
        scene.point_moment(ring.end, -material.youngs_modulus * section.inertia_z)
        tip = ancf.solve_static(scene).position(ring.end)
        errors.append(np.linalg.norm(tip - [1.0, math.pi]))
    assert errors[-1] < {4.0: 2e-6, 2.0: 6e-3}[order]
    rates = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(rates > order - 0.35)


def wrench(system, rod, force, moment):
    """Forces on the end of a thick beam, of which moments act on what its section is."""
    f, places, kind = np.zeros(system.n_all), system.place(rod.end), rod.kind
    f[places[kind.columns("r")]] = force
    vectors = {name: rod.vectors[-1, "xyz".index(name[-1])] for name in kind.section}
    matrix = sum((u @ u) * np.eye(3) - np.outer(u, u) for u in vectors.values())
    w = np.linalg.solve(matrix, moment)
    for name, u in vectors.items():
        f[places[kind.columns(name)]] = np.cross(w, u)
    return f[: system.n_free]


def test_a_helix_spring_has_the_stiffness_of_the_theory_of_rods_and_nearly_wahls():
    """By an axial force F through the axis: moments F R, of which cos(a) twists and sin(a) bends.

    Castigliano's theorem gives the compliance of the rod; Wahl's 8 D^3 N / (G d^4) is the twist of
    a closely wound one.
    """
    radius, pitch, turns, d = 0.025, 0.008, 3.0, 0.004
    section, curve = ancf.Circle(d), ancf.Helix(radius, pitch, turns)
    rise = math.atan(pitch / (2.0 * math.pi * radius))
    c, s = math.cos(rise), math.sin(rise)
    young, shear = STEEL.youngs_modulus, STEEL.shear_modulus
    rod_theory = curve.length * (
        (radius * c) ** 2 / (shear * section.torsion_constant)
        + (radius * s) ** 2 / (young * section.inertia_y)
        + s**2 / (young * section.area)
        + c**2 / (section.shear_correction(0.3) * shear * section.area)
    )
    wahl = 8.0 * (2.0 * radius) ** 3 * turns / (shear * d**4)
    assert rod_theory == pytest.approx(wahl, rel=5e-3)
    errors = []
    for n in (36, 72, 144):
        scene = ancf.Scene((0.0, 0.0, 0.0))
        rod = scene.add_beam(
            "thick", curve=curve, n_elements=n, section=section, material=STEEL,
            curvature="section",
        )  # fmt: skip
        scene.clamp(rod.start)
        system = System(scene)
        arm = -rod.positions[-1] * [1.0, 1.0, 0.0]
        f = wrench(system, rod, (0.0, 0.0, 1.0), np.cross(arm, (0.0, 0.0, 1.0)))
        errors.append(f @ sla.spsolve(tangent(system), f) / rod_theory - 1.0)
    assert abs(errors[-1]) < 2e-3
    assert np.log2(np.array(errors[:-1]) / errors[1:]) == pytest.approx([2.0, 2.0], abs=0.15)


@pytest.mark.parametrize("options", THICK)
def test_a_bend_of_45_degrees_moves_as_the_rod_of_reissner(options):
    table = REFERENCES["bend"]
    section = ancf.Section(1.0, 1.0 / 12.0, 1.0 / 12.0, 2.0 * 8.3333e5 / 1e7)
    found = []
    for n in (16, 32):
        scene = ancf.Scene((0.0, 0.0, 0.0))
        rod = scene.add_beam(
            "thick", curve=ancf.Arc((0, 100, 0), (0, 0, 0), math.pi / 4, axis=(0, 0, 1)),
            n_elements=n, section=section, material=ancf.Material(1e7, 1e3, poisson_ratio=0.0),
            **options,
        )  # fmt: skip
        scene.clamp(rod.start, stretch="fixed")
        scene.point_force(rod.end, (0.0, 0.0, 600.0))
        found.append(ancf.solve_static(scene).displacement(rod.end))
    errors = [np.abs(each - table["tip"]).max() for each in found]
    assert errors[1] < min(table["tolerance"], 0.45 * errors[0])


def test_frequencies_of_a_closed_ring():
    """In its plane n waves vibrate at sqrt(EI n^2 (n^2 - 1)^2 / (rho A R^4 (n^2 + 1))).

    Love's formula for a ring that does not stretch (Rao, Vibration of Continuous Systems, 2007).
    """
    section, material = ancf.Rectangle(1e-2, 1e-2), ancf.Material(1e9, 1e3)
    scene = ancf.Scene((0.0, 0.0))
    ring = scene.add_beam(
        "thin", curve=circle(2), n_elements=96, section=section, material=material
    )
    scene.weld(ring.start, ring.end)
    found = ancf.modes(scene, 9).frequencies
    n = np.array([2, 2, 3, 3, 4, 4])
    speed = math.sqrt(1e9 * section.inertia_z / (1e3 * section.area))
    expected = speed * n * (n**2 - 1) / np.sqrt(n**2 + 1) / (2.0 * math.pi)
    assert found[3:9] == pytest.approx(expected, rel=3e-5)


def test_a_curved_beam_in_motion_keeps_its_energy():
    scene = ancf.Scene((0.0, -9.81, 0.0))
    rod = scene.add_beam(
        "thick", curve=ancf.Helix(0.2, 0.1, 1.0), n_elements=12, section=ancf.Circle(0.02),
        material=ancf.Material(1e7, 1e3),
    )  # fmt: skip
    scene.pin(rod.start)
    run = ancf.simulate(scene, 0.3, 1e-3, integrator=ancf.EnergyMomentum())
    energy = run.energy
    total = energy.kinetic + energy.elastic + energy.potential
    assert np.ptp(total) <= 1e-9 * energy.kinetic.max()
    assert energy.elastic[0] <= 1e-20 * energy.elastic.max()


@pytest.mark.parametrize(
    ("name", "dim", "options"),
    [
        ("l2t2", 2, {}),
        ("thin", 2, {}),
        ("thin", 3, {}),
        ("thick", 3, {"section_strain": "nodal"}),
        ("thick", 2, {"section_strain": "nodal", "curvature": "section"}),
    ],
)
def test_a_straight_rod_bent_into_a_half_ring_stores_the_energy_of_its_bend(name, dim, options):
    scene = ancf.Scene(np.zeros(dim))
    section, material = ancf.Circle(0.01), ancf.Material(1e9, 1e3)
    rod = scene.add_beam(
        name, curve=circle(dim, 1.0, math.pi), n_elements=96, section=section, material=material,
        rest="straight", **options,
    )  # fmt: skip
    system = System(scene)
    bending = material.youngs_modulus * section.inertia_z
    assert system.assembly.strain_energy(system.q_ref) == pytest.approx(
        0.5 * bending * rod.length, rel=2e-3
    )


@pytest.mark.parametrize("name", ["thin", "thick"])
@pytest.mark.parametrize("strain", ["green", "biot"])
def test_a_taut_beam_pulls_by_its_tension(name, strain):
    options = {"strain": strain} if name == "thin" else {}
    section, material = ancf.Circle(0.1), ancf.Material(1e7, 1e3, poisson_ratio=0.3)
    for force in (2e4, -50.0):
        scene = ancf.Scene((0.0, 0.0, 0.0))
        rod = scene.add_beam(name, (0, 0, 0), (2, 1, 0), 4, section, material, tension=force,
                             **options)  # fmt: skip
        scene.clamp(rod.start)
        scene.clamp(rod.end)
        assert (rod.length < math.sqrt(5)) == (force > 0)
        still = ancf.solve_static(scene)
        assert np.abs(still.q - System(scene).q_ref).max() < 1e-12
        assert still.section_force(rod).N == pytest.approx(force, rel=1e-11)
        if force > 0.0:
            same = scene.replaced(rod, tension=None, length=rod.length)
            assert same.beams[0].vectors == pytest.approx(rod.vectors, rel=1e-14)


def test_a_slack_cable_hangs_by_its_length_in_one_line():
    table = REFERENCES["slack"]
    scene = ancf.Scene((0.0, -9.81))
    section, material = ancf.Rectangle(0.01, 0.01), ancf.Material(1e8, 4e3)
    rope = scene.add_beam("thin", (0, 0), (2, 0), 16, section, material, strain="biot",
                          length=table["length"])  # fmt: skip
    scene.pin(rope.start)
    scene.pin(rope.end)
    hanging = ancf.solve_static(scene)
    middle = hanging.position(rope.at(0.5 * rope.length))
    assert middle == pytest.approx(table["middle"], abs=table["tolerance"])
    pull = hanging.reaction(rope.end)
    assert np.abs(pull) == pytest.approx(table["pull"], abs=table["pull_tolerance"])


@pytest.mark.parametrize("end", [(1.5, 0.4), (0.2, -0.9), (-1.0, 0.0)])
def test_a_slack_cable_starts_as_a_catenary(end):
    scene = ancf.Scene((0.0, -9.81))
    rope = scene.add_beam("thin", (0, 0), end, 400, ancf.Circle(0.01), ancf.Material(1e8, 4e3),
                          length=2.0)  # fmt: skip
    assert rope.length == 2.0
    r, t = rope.positions, rope.vectors[:, 0]
    chords = np.linalg.norm(np.diff(r, axis=0), axis=1)
    assert chords.sum() == pytest.approx(2.0, rel=1e-4)
    # Its weight balances the change of the force along it: the slope grows evenly with length.
    slope = t[:, 1] / t[:, 0]
    steps = np.diff(slope)
    assert steps == pytest.approx(np.full(400, steps.mean()), rel=1e-9)


def test_a_pretwisted_cantilever_bends_aside_as_the_integral_of_its_compliance():
    """A quarter turn along a strip twice as high as wide: w = int M (L - x) c(x) dx, and shear.

    With the angle a(x) the compliances are cos^2 a / E I_z + sin^2 a / E I_y along the force and
    sin a cos a (1 / E I_z - 1 / E I_y) across it.
    """
    height, width, modulus, force = 0.02, 0.01, 2e11, 0.01
    i_z, i_y = width * height**3 / 12.0, height * width**3 / 12.0
    x, w = np.polynomial.legendre.leggauss(40)
    x, w = 0.5 * (1.0 + x), 0.5 * w
    angle = 0.5 * np.pi * x
    along = np.cos(angle) ** 2 / i_z + np.sin(angle) ** 2 / i_y
    across = np.sin(angle) * np.cos(angle) * (1.0 / i_z - 1.0 / i_y)
    bent = np.array([w @ ((1.0 - x) ** 2 * each) for each in (along, across)]) * force / modulus
    bent[0] += force / (5.0 / 6.0 * 0.5 * modulus * height * width)
    off = []
    for n in (8, 16):
        scene = ancf.Scene((0.0, 0.0, 0.0))
        rod = scene.add_beam(
            "thick", (0, 0, 0), (1, 0, 0), n, ancf.Rectangle(height=height, width=width),
            ancf.Material(modulus, 7800.0, 0.0), curvature="section", twist=0.5 * np.pi,
        )  # fmt: skip
        scene.clamp(rod.start)
        scene.point_force(rod.end, (0.0, force, 0.0))
        off.append(ancf.solve_static(scene).displacement(rod.end)[1:] / bent - 1.0)
    assert np.abs(off[1]).max() < 0.006
    np.testing.assert_allclose(np.log2(np.divide(*off)), 2.0, atol=0.2)
