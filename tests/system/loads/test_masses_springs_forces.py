"""Masses, springs and forces of the motion: residual, matrix and energy against differences."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from tests.matrices import full


def scene_of(dim, *, coupled=True, force=True):
    """A beam of two elements with everything that can be attached, also inside one element."""
    pad = (0.0,) * (dim - 2)
    scene = ancf.Scene(gravity=(0.0, -9.81, *pad))
    section, material = ancf.Rectangle(0.1, 0.1), ancf.Material(1e6, 400, 0.3)
    beam = scene.add_beam("thick", (0, 0, *pad), (1, 0.2, *pad), 2, section, material)
    scene.pin(beam.start)
    scene.add_mass(beam.at(0.3), 2.0)
    scene.add_mass(beam.end, 1.0, inertia=0.3 if dim == 2 else (1.0, 2.0, 2.5))
    scene.spring(beam.at(0.2), beam.at(0.4), stiffness=1e4, damping=3.0, length=0.1)
    scene.spring(beam.at(0.6), (1, 1, *pad), damping=7.0)
    scene.spring(beam.end, (1, 1, *pad), stiffness=lambda e: 1e3 * e + 1e5 * e**3)
    scene.spring(beam.end, beam.end.position, stiffness=50.0, length=0.0)

    def drag(q, v, t):
        own = -3.0 * v * np.linalg.norm(v, axis=1)[:, None] + 50.0 * np.sin(t) * q
        return own + 100.0 * np.roll(q, 1, 0) ** 2 if coupled else own

    if force:
        scene.force([beam.at(0.6), beam.at(0.8), beam.end], drag, coupled=coupled)
    return scene


@pytest.mark.parametrize("coupled", [True, False])
@pytest.mark.parametrize("dim", [2, 3])
def test_matrix_is_the_symmetric_part_of_the_derivatives(dim, coupled, rng):
    system = System(scene_of(dim, coupled=coupled))
    n, none, rest = system.n_free, np.zeros(0), np.zeros(system.n_all)
    q = system.q0 + 1e-2 * rng.normal(size=system.n_all)
    v = rng.normal(size=system.n_all)
    loads = system.loads.amplitudes(np.array([0.3]))[0]

    def residual(q, v, a):
        return system.assembly.residual(q, v, a, none, rest, loads)[0][:n]

    def derivative(of):
        step, units = 1e-5, np.eye(system.n_all)[:n]
        found = np.array([(of(step * e) - of(-step * e)) / (2.0 * step) for e in units]).T
        return 0.5 * (found + found.T)

    def matrix(mass, stiffness, damping, v):
        values = system.assembly.matrix(
            mass, stiffness, q, none, loads, damping_factor=damping, v=v
        )
        return full(system, values)

    expected = {
        (1.0, 0.0, 0.0): derivative(lambda dx: residual(q, v, dx)),
        # At rest: what positions do to the force of a damper is left to iteration.
        (0.0, 1.0, 0.0): derivative(lambda dx: residual(q + dx, rest, rest)),
        (0.0, 0.0, 1.0): derivative(lambda dx: residual(q, v + dx, rest)),
    }
    for (mass, stiffness, damping), wanted in expected.items():
        found = matrix(mass, stiffness, damping, rest if stiffness else v)
        assert np.abs(found - wanted).max() <= 1e-7 * np.abs(wanted).max()


@pytest.mark.parametrize("dim", [2, 3])
def test_between_two_states_a_spring_gives_back_its_energy(dim, rng):
    system = System(scene_of(dim, force=False))
    none, rest = np.zeros(0), np.zeros(system.n_all)
    q0 = system.q0 + 1e-2 * rng.normal(size=system.n_all)
    for size in (1e-1, 1e-8, 0.0):
        q1 = q0 + size * rng.normal(size=system.n_all)
        r, _ = system.assembly.residual_between(q0, q1, rest, rest, none, rest, none)
        gained = system.assembly.strain_energy(q1) - system.assembly.strain_energy(q0)
        assert r @ (q1 - q0) == pytest.approx(gained, rel=1e-9, abs=1e-12)
    # In the limit it is the force itself.
    force = system.assembly.residual(q0, rest, rest, none, rest, none)[0]
    assert np.abs(r - force).max() <= 1e-9 * np.abs(force).max()


@pytest.mark.parametrize("dim", [2, 3])
def test_a_body_turns_with_the_inertia_it_was_given(dim):
    """Kinetic energy of a turning beam of no mass to speak of: 1/2 m v^2 + 1/2 w.J w by hand."""
    pad = (0.0,) * (dim - 2)
    scene = ancf.Scene(gravity=(0.0, 0.0, *pad))
    beam = scene.add_beam(
        "thick", (0, 0, *pad), (2, 0, *pad), 1, ancf.Circle(0.01), ancf.Material(1e6, 1e-9, 0.3)
    )
    inertia = 0.7 if dim == 2 else np.array([[1.0, 0.1, 0.0], [0.1, 2.0, 0.2], [0.0, 0.2, 2.5]])
    scene.add_mass(beam.end, 3.0, inertia=inertia)
    system = System(scene)
    spin = np.array([0.0, 0.0, 2.0]) if dim == 2 else np.array([1.0, -0.5, 2.0])
    v, places = np.zeros(system.n_all), system.place(beam.end)
    kind = system.kind_of(beam)
    v[places[:dim]] = np.cross(spin, [2.0, 0.0, 0.0])[:dim]
    for name, axis in zip(("r_x", "r_y", "r_z"), np.eye(3), strict=True):
        columns = kind.columns(name)
        if len(kind.directions(name)) == dim:
            v[places[columns]] = np.cross(spin, axis)[:dim]
    matrix = np.diag([0.0, 0.0, 0.7]) if dim == 2 else inertia
    expected = 0.5 * 3.0 * (v[places[:dim]] ** 2).sum() + 0.5 * spin @ matrix @ spin
    kinetic, *_ = system.energies(system.q0[None], v[None])
    assert kinetic[0] == pytest.approx(expected, rel=1e-8)
    assert system.mass == pytest.approx(3.0, rel=1e-9)


def test_gravity_acts_on_a_mass_and_a_reaction_holds_it():
    scene = ancf.Scene(gravity=(0.0, -10.0))
    beam = scene.add_beam(
        "thin", (0, 0), (2, 0), 2, ancf.Rectangle(0.1, 0.1), ancf.Material(1e9, 100)
    )
    scene.clamp(beam.start)
    scene.add_mass(beam.at(1.5), 5.0)
    rest = ancf.solve_static(scene)
    np.testing.assert_allclose(rest.reaction(beam.start), [0.0, 20.0 + 50.0], atol=1e-6)


def test_memory_of_what_was_attached_is_in_the_digest():
    one, other = scene_of(2), scene_of(2)
    assert one.digest() == other.digest()
    other.add_mass(other.beams[0].start, 1e-3)
    assert one.digest() != other.digest()


def test_springs_add_nothing_to_the_masses_of_rigid_bodies():
    def masses(*, spring):
        scene = ancf.Scene((0.0, 0.0))
        body = scene.add_body(mass=2.0, inertia=0.05, position=(0.0, 0.0))
        if spring:
            scene.spring(body.origin, (1.0, 0.0), stiffness=1e4, damping=3.0)
        return System(scene).mass_diagonal

    np.testing.assert_array_equal(masses(spring=True), masses(spring=False))
