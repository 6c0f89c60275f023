"""Meshes of thick beams: the same as beams and pins one by one, and calculations by hand."""

from __future__ import annotations

import numpy as np
import pytest

import ancfsparse as ancf

SECTION, SOFT = ancf.Rectangle(0.02, 0.03), ancf.Material(2e9, 7800.0)
NODES = np.array([(0, 0), (1, 0), (2, 0), (1, -1)])
EDGES = [(0, 1), (2, 1), (1, 3)]  # a beam of two edges, one of them given backwards, and a post


def place(point, dim):
    return (*point, *(0.0,) * (dim - 2))


def both(dim, **options):
    """A beam on a hinged post, as a mesh and as two beams with a pin."""
    scenes = []
    for _ in range(2):
        scenes.append(ancf.Scene(place((0.0, -9.81), dim)))
    one, other = scenes
    nodes = [place(each, dim) for each in NODES]
    mesh = one.add_mesh(nodes, EDGES, "thick", SECTION, SOFT, n_elements=3, **options)
    one.clamp(mesh.node(0))
    one.pin(mesh.node(2))
    one.clamp(mesh.node(3))
    one.point_force(mesh.at(0, 0.5), place((3.0, -20.0), dim))
    beam = other.add_beam("thick", nodes[0], nodes[2], 6, SECTION, SOFT, **options)
    post = other.add_beam("thick", nodes[1], nodes[3], 3, SECTION, SOFT, **options)
    other.clamp(beam.start)
    other.pin(beam.end)
    other.clamp(post.end)
    other.connect(beam.node(3), post.start)
    other.point_force(beam.at(0.5), place((3.0, -20.0), dim))
    return one, mesh, other, beam, post


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("options", [{}, {"curvature": "section"}, {"section_strain": "nodal"}])
def test_a_mesh_is_the_beams_and_pins_that_it_stands_for(dim, options):
    one, mesh, other, beam, post = both(dim, **options)
    a, b = ancf.solve_static(one), ancf.solve_static(other)
    pairs = [(mesh.at(0, 0.5), beam.at(0.5)), (mesh.at(1, 0.3), beam.at(1.7)),
             (mesh.at(2, 0.3), post.at(0.3)), (mesh.node(1), post.start)]  # fmt: skip
    assert np.abs(b.position(beam.at(0.5)) - beam.at(0.5).position).max() > 1e-3
    for mine, its in pairs:
        np.testing.assert_allclose(a.position(mine), b.position(its), atol=1e-13)
    inside = a.section_force(mesh, [mesh.at(0, 0.5), mesh.at(2, 0.5)])
    expected = [b.section_force(beam, 0.5), b.section_force(post, 0.5)]
    for name in ("N", "Q", "M"):
        values = [getattr(each, name)[0] for each in expected]
        np.testing.assert_allclose(getattr(inside, name), values, atol=1e-7)
    # Along the edge that was given backwards N stays as it is; in the plane a moment changes sign.
    back, along = a.section_force(mesh, mesh.at(1, 0.5)), b.section_force(beam, 1.5)
    np.testing.assert_allclose(back.N, along.N, atol=1e-7)
    np.testing.assert_allclose(back.M, -along.M if dim == 2 else along.M, atol=1e-7)


def test_a_mesh_moves_and_vibrates_like_its_beams():
    one, mesh, other, beam, _ = both(2, curvature="section")
    a, b = ancf.simulate(one, 0.1, 1e-3), ancf.simulate(other, 0.1, 1e-3)
    path = a.position(mesh.at(0, 0.5))
    np.testing.assert_allclose(path, b.position(beam.at(0.5)), atol=1e-12)
    assert np.ptp(path[:, 1]) > 1e-3
    mine, its = ancf.modes(one, 4).frequencies, ancf.modes(other, 4).frequencies
    np.testing.assert_allclose(mine, its, rtol=1e-9)


def deflection_of_a_cross(a, b, force, section, n_elements):
    nodes = [(-a / 2, 0, 0), (a / 2, 0, 0), (0, -b / 2, 0), (0, b / 2, 0), (0, 0, 0)]
    scene = ancf.Scene((0.0, 0.0, 0.0))
    mesh = scene.add_mesh(
        nodes, [(0, 4), (4, 1), (2, 4), (4, 3)], "thick", section, SOFT,
        n_elements=n_elements, curvature="section",
    )  # fmt: skip
    assert mesh.n_lines == 2
    for node, axis in {0: (0.0, 1.0, 0.0), 2: (1.0, 0.0, 0.0)}.items():
        scene.revolute(mesh.node(node), axis=axis)
        scene.rod(mesh.node(node + 1), np.add(nodes[node + 1], (0.0, 0.0, 50.0)))
    scene.point_force(mesh.node(4), (0.0, 0.0, -force))
    return -ancf.solve_static(scene).position(mesh.node(4))[2]


def test_a_cross_of_hinged_beams_shares_its_load_as_calculated():
    # Two simply supported beams of lengths a and b that cross in their middles, across the plane:
    # a force there deflects them by F / (48 EI (1 / a^3 + 1 / b^3)), with little shear.
    a, b, force, section = 2.0, 1.5, 5e-3, ancf.Rectangle(0.01, 0.01)
    expected = force / (48.0 * 2e9 * section.inertia_z * (1.0 / a**3 + 1.0 / b**3))
    coarse, fine = (deflection_of_a_cross(a, b, force, section, n) for n in (4, 8))
    assert fine == pytest.approx(expected, rel=5e-3)
    assert fine + (fine - coarse) / 3.0 == pytest.approx(expected, rel=2e-4)  # order 2


@pytest.mark.parametrize("factorization", ["complete", "incomplete"])
def test_a_lattice_of_short_beams_hangs_and_swings(factorization):
    n = 5
    nodes = [(0.1 * x, 0.1 * y) for y in range(n) for x in range(n)]
    edges = [(n * y + x, n * y + x + 1) for y in range(n) for x in range(n - 1)]
    edges += [(n * y + x, n * y + x + n) for y in range(n - 1) for x in range(n)]
    scene = ancf.Scene((0.0, -9.81))
    mesh = scene.add_mesh(nodes, edges, "thick", ancf.Rectangle(0.01, 0.01), SOFT)
    for corner in (n * n - n, n * n - 1):
        scene.pin(mesh.node(corner))
    run = ancf.simulate(scene, 0.05, 1e-3, factorization=factorization)
    assert run.energy.drift < 1e-3
    assert scene.refined(2).counterpart(mesh).n_elements == 2 * mesh.n_elements


def test_a_joint_at_a_crossing_that_needs_a_direction_is_refused():
    scene = ancf.Scene((0.0, -9.81))
    mesh = scene.add_mesh(NODES, EDGES, "thin", SECTION, SOFT, n_elements=2)
    box = scene.add_body(mass=1.0, inertia=0.1, position=(1, 0))
    scene.weld(mesh.node(1), box.origin)
    with pytest.raises(ancf.InputError, match="has 2 slopes, one for each line through it"):
        ancf.solve_static(scene)


def test_sections_that_would_twist_at_a_steep_bend_are_refused():
    scene = ancf.Scene((0.0, 0.0, 0.0))
    upright = [(0, 0, 0), (0, 0, 1), (0, 0.02, 2)]
    with pytest.raises(ancf.InputError, match="too steep at edge 0: its sections"):
        scene.add_mesh(upright, [(0, 1), (1, 2)], "thick", SECTION, SOFT)
    scene.add_mesh(upright, [(0, 1), (1, 2)], "thick", SECTION, SOFT, smooth=0.5)
    flat = scene.add_mesh([(0, 0, 0), (1, 0, 0), (2, 0.02, 0.05)], [(0, 1), (1, 2)], "thick",
                          SECTION, SOFT)  # fmt: skip
    assert flat.n_lines == 1
