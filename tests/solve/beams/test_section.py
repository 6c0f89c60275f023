"""Beams that shear, curvature="section": against another program, a continuum and theory."""

import functools
import tomllib

import numpy as np
import pytest
import scipy.linalg
from scipy.sparse.linalg import eigsh

import ancfsparse as ancf
from ancfsparse.system import System
from tests.beams import build_beam
from tests.matrices import full, stiffness
from tests.paths import REFERENCES
from tests.solve.beams.continuum import tip

REFERENCES = tomllib.loads((REFERENCES / "statics.toml").read_text(encoding="utf-8"))
PRINCETON = REFERENCES["princeton"]
REFERENCES = REFERENCES["section"]
STEEL = ancf.Material(2.07e11, 7850.0, 0.3)
SQUARE = ancf.Rectangle(0.1, 0.1)
STRAINS = ("consistent", "nodal")


def cantilever(n, section_strain="consistent", dim=2, stretch="free"):
    """The beam of `ancf.problems.cantilever`, not loaded yet."""
    out_of_plane = (0.0,) * (dim - 2)
    options = {"curvature": "section", "section_strain": section_strain}
    ends = (0.0, 0.0, *out_of_plane), (2.0, 0.0, *out_of_plane)
    scene, rod = build_beam("thick", *ends, n, SQUARE, STEEL, gravity=(0.0,) * dim, **options)
    scene.clamp(rod.start, stretch)
    return scene, rod


def pushed(*args, **options):
    """Bent by a dead force of 3 E I / L^2."""
    scene, rod = cantilever(*args, **options)
    force = 3 * rod.parameters()["bending_stiffness"] / rod.length**2
    scene.point_force(rod.end, (0.0, -force, 0.0)[: scene.dim])
    return ancf.solve_static(scene), rod


def rolled(*args, **options):
    """Bent by a moment of 2 pi E I / L."""
    scene, rod = cantilever(*args, **options)
    moment = 2 * np.pi * rod.parameters()["bending_stiffness"] / rod.length
    scene.point_moment(rod.end, moment if scene.dim == 2 else (0.0, 0.0, moment))
    return ancf.solve_static(scene), rod


def lowest(equilibrium):
    """Eigenvalue of the tangent next to zero [N/m]."""
    system = equilibrium.system
    amplitudes = system.loads.amplitudes(np.zeros(1))[0]
    matrix = stiffness(system, equilibrium.q, amplitudes=amplitudes)
    return eigsh(matrix, 1, sigma=0.0, return_eigenvectors=False)[0]


@pytest.mark.parametrize("dim", [2, 3])
def test_large_bending_digit_for_digit(dim):
    table = REFERENCES["cantilever"]
    for n in (16, 32, 128, 512)[: 6 - dim]:
        equilibrium, rod = pushed(n, dim=dim, stretch="fixed")
        found = -equilibrium.displacement(rod.end)[1]
        assert found == pytest.approx(table[str(n)], abs=table["tolerance"])


def test_a_roll_up_by_a_moment_on_the_section_digit_for_digit():
    table = REFERENCES["roll_up"]
    for n in (32, 64, 128):
        equilibrium, rod = rolled(n, stretch="fixed")
        found = equilibrium.position(rod.end)
        np.testing.assert_allclose(found, table[str(n)], rtol=0, atol=table["tolerance"])


@pytest.mark.parametrize("n", [256, 512])
@pytest.mark.parametrize("section_strain", STRAINS)
def test_refinement_stays_on_the_branch(section_strain, n):
    table = REFERENCES["stiffness"]
    equilibrium, _ = pushed(n, section_strain)
    assert lowest(equilibrium) == pytest.approx(table[str(n)], abs=table["tolerance"])


@functools.cache
def continuum(bend):
    _, rod = cantilever(1)
    p = rod.parameters()
    if bend is pushed:
        return tip(p, rod.length, force=(0.0, -3 * p["bending_stiffness"] / rod.length**2))
    return tip(p, rod.length, moment=2 * np.pi * p["bending_stiffness"] / rod.length)


@pytest.mark.parametrize("bend", [pushed, rolled])
@pytest.mark.parametrize("section_strain", STRAINS)
def test_large_bending_tends_to_the_continuum(bend, section_strain):
    errors = []
    for n in (32, 64, 128):
        equilibrium, rod = bend(n, section_strain)
        errors.append(np.abs(equilibrium.position(rod.end) - continuum(bend)).max())
    assert errors[0] > 3.5 * errors[1] > 12 * errors[2]  # second order
    assert errors[2] < (3e-5 if bend is pushed else 2e-3)


@pytest.mark.parametrize("load", [key for key in PRINCETON if key.startswith("load")])
def test_bending_and_twist_in_space_are_those_of_the_princeton_beam(load):
    force, degrees, *expected = PRINCETON[load]
    height, width = 12.3777e-3, 3.2024e-3
    about_y, about_z = height * width**3 / 12, width * height**3 / 12
    section = ancf.Section(height * width, about_y, about_z, 0.198 * (about_y + about_z))
    scene = ancf.Scene((0.0, 0.0, 0.0))
    options = {"curvature": "section", "section_strain": "nodal"}
    material = ancf.Material(71.7e9, 2700.0, 0.31)
    rod = scene.add_beam("thick", (0, 0, 0), (0.508, 0, 0), 64, section, material, **options)
    scene.clamp(rod.start)
    angle = np.radians(degrees)
    scene.point_force(rod.end, (0.0, -force * np.cos(angle), -force * np.sin(angle)))
    found = -ancf.solve_static(scene).displacement(rod.end)[1:]
    np.testing.assert_allclose(found, expected, rtol=0, atol=PRINCETON["tolerance"])


@pytest.mark.parametrize("section_strain", STRAINS)
def test_vibrations_are_timoshenkos(section_strain):
    # Pinned at both ends: sines w and phi, (rI w2 - E I k2 - k G A)(rA w2 - k G A k2) = (k G A k)2.
    errors = []
    for n in (8, 16, 32):
        options = {"curvature": "section", "section_strain": section_strain}
        scene, rod = build_beam(
            "thick", (0, 0), (0.5, 0), n, SQUARE, STEEL, "pin", "pin", gravity=(0.0, 0.0), **options
        )
        system, p = System(scene), rod.parameters()
        elastic, mass = (
            full(system, system.assembly.matrix(m, k, system.q0, np.zeros(0), np.zeros(0)))
            for m, k in ((0.0, 1.0), (1.0, 0.0))
        )
        found = np.sqrt(np.abs(scipy.linalg.eigh(elastic, mass, eigvals_only=True)))
        bending, shear = p["bending_stiffness_z"], p["shear_stiffness_y"]
        heavy, turning = p["mass_per_length"], p["inertia_y"]
        for k in np.pi * np.arange(1, 4) / rod.length:
            middle = turning * shear * k**2 + heavy * (bending * k**2 + shear)
            squares = np.roots([turning * heavy, -middle, bending * shear * k**4])
            exact = np.sqrt(squares.real.min())
            errors.append(np.abs(found / exact - 1).min())
    errors = np.array(errors).reshape(3, 3)
    assert (np.abs(np.log2(errors[:-1] / errors[1:]) - 2) < 0.1).all()
    assert errors[-1].max() < 2.5e-3


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("section_strain", STRAINS)
def test_a_free_beam_in_rough_motion_keeps_what_it_has(section_strain, dim):
    # Thrown with a bending that makes it shear: energy with the energy-momentum method, and with
    # generalised-alpha no more than was given.
    def field(points):
        out = np.zeros_like(points)
        out[:, 1] = 40.0 * np.sin(3.0 * points[:, 0])
        if dim == 3:
            out[:, 2] = 15.0 * np.cos(5.0 * points[:, 0])
        return out

    scene = ancf.Scene((0.0,) * dim)
    z = (0.0,) * (dim - 2)
    soft = ancf.Material(2e7, 1000.0, 0.3)
    rod = scene.add_beam(
        "thick", (0.0, 0.0, *z), (1.0, 0.0, *z), 8, SQUARE, soft,
        curvature="section", section_strain=section_strain, velocity=field,
    )  # fmt: skip
    run = ancf.simulate(scene, 0.1, 2e-4, integrator=ancf.EnergyMomentum())
    total = run.energy.kinetic + run.energy.elastic
    assert run.energy.elastic.max() > 0.1 * total[0]
    assert np.abs(total - total[0]).max() < 1e-6 * total[0]
    damped = ancf.simulate(scene, 0.1, 2e-4, integrator=ancf.GeneralizedAlpha(0.8))
    total = damped.energy.kinetic + damped.energy.elastic
    assert (total < total[0] * (1 + 1e-3)).all()
    assert np.abs(damped.position(rod.end) - run.position(rod.end)).max() < 0.05


def test_a_damped_beam_loses_what_its_damping_takes():
    soft = ancf.Material(2e7, 1000.0, 0.3, axial_damping=1e-3, bending_damping=5e-3)
    scene, _ = build_beam("thick", (0, 0), (1, 0), 8, SQUARE, soft, "clamp", curvature="section")
    run = ancf.simulate(scene, 0.5, 5e-4)
    taken = run.energy.kinetic + run.energy.elastic + run.energy.potential + run.energy.dissipated
    assert run.energy.dissipated[-1] > 0.1 * run.energy.kinetic.max()
    assert np.abs(taken - taken[0]).max() < 1e-3 * run.energy.kinetic.max()


@pytest.mark.parametrize("curvature", ["axis", "section"])
def test_only_the_curvature_of_the_axis_has_a_shortest_element(curvature):
    # On a circle, with elements of half the length that the theory page asks for and of twice it.
    radius = 1.0
    for share in (0.5, 2.0):
        scene = ancf.Scene((0.0, 0.0))
        probe, _ = cantilever(1)
        p = probe.beams[0].parameters()
        shortest = 2 * np.pi * p["bending_stiffness"] / radius
        h = share * shortest / np.sqrt(p["shear_stiffness_y"] * p["axial_stiffness"])
        rod = scene.add_beam("thick", (0, 0), (20 * h, 0), 20, SQUARE, STEEL, curvature=curvature)
        scene.clamp(rod.start)
        system = System(scene)
        q, places = system.q0.copy(), system.places[0]
        angle = np.arange(21) * h / radius
        c, s = np.cos(angle), np.sin(angle)
        q[places[:, :6]] = np.stack([radius * s, radius * (1 - c), c, s, -s, c], axis=1)
        values = system.assembly.matrix(0.0, 1.0, q, np.zeros(0), np.zeros(0))
        stable = np.linalg.eigvalsh(full(system, values))[0] > 0
        assert stable == (curvature == "section" or share > 1)
