"""Strains, curvatures and section forces against statics that can be done by hand."""

from itertools import product

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError
from ancfsparse.kernels.catalog import OPTIONS
from ancfsparse.problems import elastica, pendulum
from ancfsparse.system import System
from ancfsparse.system.recovery.element_end_forces import element_end_forces

EVERY = [
    (element, dim, dict(zip(options, values, strict=True)))
    for element, options in OPTIONS.items()
    if element != "string"  # does not bend
    for dim in ((2,) if element == "l2t2" else (2, 3))
    for values in product(*options.values())
]
STEEL = ancf.Material(2e11, 7800.0)


def name_of(case):
    element, dim, options = case
    return "-".join([element, str(dim), *options.values()])


@pytest.mark.parametrize("case", EVERY, ids=name_of)
def test_a_bent_cantilever_is_cut_free_anywhere(case):
    element, dim, options = case
    scene, rod = elastica(2.0, element, 4, dim, slenderness=100.0, **options)
    rest = ancf.solve_static(scene)
    s = np.array([0.0, 0.1, 0.25, 0.6, 0.75, 0.9, 1.0]) * rod.length
    cut = rest.section_force(rod, s)
    force = np.zeros(dim)
    force[1] = -2.0 * rod.parameters()["bending_stiffness"] / rod.length**2
    small = 1e-9 * abs(force[1])
    np.testing.assert_allclose(cut.force, np.tile(force, (len(s), 1)), atol=small)
    arm = rest.position(rod.end) - [rest.position(rod.at(x)) for x in s]
    moment = arm[:, 0] * force[1]
    got = cut.moment if dim == 2 else cut.moment[:, 2]
    np.testing.assert_allclose(got, moment, atol=small)
    # In the axes of the section: the tangent of a cable, the normal of the section of a beam.
    if dim == 2 and element != "thick":
        tangent = np.array([rest.slope(rod.at(x)) for x in s])
        tangent /= np.linalg.norm(tangent, axis=1)[:, None]
        np.testing.assert_allclose(cut.N, tangent @ force, atol=small)
        np.testing.assert_allclose(cut.Q, tangent[:, 0] * force[1], atol=small)
    shear = cut.Q if dim == 2 else np.linalg.norm(cut.Q, axis=1)
    np.testing.assert_allclose(cut.N**2 + shear**2, force[1] ** 2, rtol=1e-8)
    assert (cut.T is None) == (dim == 2 or element != "thick")


@pytest.mark.parametrize("case", EVERY, ids=name_of)
def test_pure_bending_has_the_moment_and_the_curvature_of_a_circle(case):
    element, dim, options = case
    errors = []
    for n in (8, 16):
        scene, rod = elastica(0.0, element, n, dim, slenderness=400.0, **options)
        stiffness = rod.parameters()["bending_stiffness"]
        expected = 0.5 * np.pi * stiffness / rod.length
        scene.point_moment(rod.end, expected if dim == 2 else (0.0, 0.0, expected))
        rest = ancf.solve_static(scene)
        cut, turn = rest.section_force(rod), rest.curvature(rod)
        moment = cut.M if dim == 2 else cut.moment[:, 2]
        np.testing.assert_allclose(moment, expected, rtol=1e-8)
        np.testing.assert_allclose(cut.force, 0.0, atol=1e-7 * expected)
        turn = turn if dim == 2 else turn[:, 2]
        errors.append(np.abs(stiffness * turn / expected - 1.0).max())
    # The strain of the element itself, on the mesh it has: it converges to the moment it carries.
    assert errors[1] < 0.35 * errors[0]
    assert errors[1] < (0.1 if options.get("section_strain") == "consistent" else 0.02)


@pytest.mark.parametrize("options", [case[2] for case in EVERY if case[:2] == ("thick", 3)])
def test_torsion_and_both_bendings_of_a_thick_beam(options):
    scene = ancf.Scene((0.0, 0.0, 0.0))
    section = ancf.Rectangle(0.02, 0.05)
    rod = scene.add_beam("thick", (0, 0, 0), (1, 0, 0), 5, section, STEEL, **options)
    scene.clamp(rod.start)
    twist, y, z = 0.3, 0.02, -0.07
    scene.point_moment(rod.end, (twist, 0.0, 0.0))
    scene.point_force(rod.end, (0.0, y, z))
    rest = ancf.solve_static(scene)
    s = np.linspace(0.0, 1.0, 9)
    cut = rest.section_force(rod, s)
    np.testing.assert_allclose(cut.T, twist, rtol=1e-4)
    np.testing.assert_allclose(cut.N, 0.0, atol=1e-4)
    np.testing.assert_allclose(cut.Q, np.tile([y, z], (9, 1)), rtol=1e-3)
    np.testing.assert_allclose(cut.M[:, 0], -z * (1.0 - s), atol=1e-4)
    np.testing.assert_allclose(cut.M[:, 1], y * (1.0 - s), atol=1e-4)
    middle = np.linspace(0.1, 0.9, 5)
    turn = rest.curvature(rod)
    stiffness = rod.stiffnesses()
    np.testing.assert_allclose(turn[:, 0], twist / stiffness["torsion_stiffness"], rtol=1e-3)
    bent = -z * (1.0 - middle) / stiffness["bending_stiffness_y"]
    np.testing.assert_allclose(turn[:, 1], bent, rtol=2e-2)
    bent = y * (1.0 - middle) / stiffness["bending_stiffness_z"]
    np.testing.assert_allclose(turn[:, 2], bent, rtol=2e-2)


def test_a_hanging_cable_carries_the_weight_below():
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam("thin", (0, 0), (0, -5), 8, ancf.Circle(0.01), STEEL)
    scene.clamp(rod.start)
    weight = STEEL.density * rod.section.area * 9.81
    rest = ancf.solve_static(scene)
    middle = (np.arange(8) + 0.5) * 5.0 / 8
    np.testing.assert_allclose(rest.section_force(rod).N, weight * (5.0 - middle), rtol=2e-8)
    stretched = weight * (5.0 - middle) / (STEEL.youngs_modulus * rod.section.area)
    np.testing.assert_allclose(rest.strain(rod), stretched, rtol=1e-5)
    # Weight counts at nodes: elsewhere in an element the force is off by half of what it has.
    s = np.linspace(0.0, 5.0, 41)
    error = np.abs(rest.section_force(rod, s).N - weight * (5.0 - s)).max()
    assert error == pytest.approx(0.5 * weight * 5.0 / 8, rel=1e-6)


def test_moments_under_weight_are_exact_at_gauss_points():
    scene = ancf.Scene((0.0, -1e-3))
    n, length = 4, 2.0
    rod = scene.add_beam("thin", (0, 0), (length, 0), n, ancf.Circle(0.05), STEEL)
    scene.clamp(rod.start)
    weight = STEEL.density * rod.section.area * 1e-3
    rest = ancf.solve_static(scene)
    for xi, share in (
        (0.0, 1 / 12),
        (0.5, -1 / 24),
        (0.5 - 0.5 / np.sqrt(3.0), 0.0),
        (1.0, 1 / 12),
    ):
        s = (np.arange(n) + min(xi, 1.0 - 1e-7)) * length / n
        exact = -0.5 * weight * (length - s) ** 2
        off = rest.section_force(rod, s).M - exact
        scale = weight * (length / n) ** 2
        np.testing.assert_allclose(off / scale, share, atol=1e-5)


@pytest.mark.parametrize("case", EVERY, ids=name_of)
def test_forces_of_single_elements_add_up_to_those_of_the_system(case):
    element, dim, options = case
    scene = ancf.Scene((0.0,) * dim)
    damped = ancf.Material(1e8, 4e3, axial_damping=1e-3, bending_damping=3e-3)
    end = (2.0, 0.3, 0.1)[:dim]
    rod = scene.add_beam(element, (0.0,) * dim, end, 11, ancf.Circle(0.05), damped, **options)
    system = System(scene)
    generator = np.random.default_rng(3)
    q = system.q0 + 0.02 * generator.normal(size=(2, system.n_all))
    v = generator.normal(size=q.shape)
    places = system.elements(rod)
    kind, states = system.kind_of(rod), (q[:, places], v[:, places], np.zeros(2))
    each = element_end_forces(rod, kind, np.arange(11), *states)
    for k in range(2):
        summed = np.zeros(system.n_all)
        np.add.at(summed, places, each[k])
        whole = np.asarray(system.assembly.force(q[k])) + system.assembly.damping(q[k], v[k])
        np.testing.assert_allclose(summed, whole, atol=1e-12 * np.abs(whole).max())


def test_forces_in_motion_accelerate_what_is_beyond():
    scene, rod = pendulum(n_elements=20)
    run = ancf.simulate(scene, 0.2, 1e-3)
    k, i = 150, 8
    middle = (i + 0.5) * rod.length / 20
    cut = run.section_force(rod, [middle])
    beyond = np.linspace(middle, rod.length, 1001)
    missing = np.array([run.acceleration(rod.at(x))[k] for x in beyond]) - [0.0, -9.81]
    pull = np.trapezoid(missing, beyond, axis=0) * 4e3 * rod.section.area
    np.testing.assert_allclose(cut.force[k, 0], -pull, atol=2e-2 * np.linalg.norm(pull))


def test_edges_of_a_mesh_count_as_given():
    scene = ancf.Scene((0.0, 0.0))
    nodes = [(0, 0), (1, 0), (2, 0)]
    mesh = scene.add_mesh(nodes, [(0, 1), (2, 1)], "thin", ancf.Circle(0.05), STEEL)
    scene.clamp(mesh.node(0))
    scene.point_force(mesh.node(2), (3.0, -1e-3))
    rest = ancf.solve_static(scene)
    assert mesh.flipped.tolist() == [False, True]
    cut = rest.section_force(mesh)
    np.testing.assert_allclose(cut.N, 3.0, rtol=1e-6)
    np.testing.assert_allclose(cut.force, [[3.0, -1e-3], [-3.0, 1e-3]], rtol=1e-6)
    np.testing.assert_allclose(cut.Q, -1e-3, rtol=1e-2)
    np.testing.assert_allclose(cut.M, [-1.5e-3, 0.5e-3], rtol=1e-2)
    np.testing.assert_allclose(np.sign(rest.curvature(mesh)), [-1.0, 1.0])
    near_tip = rest.section_force(mesh, [mesh.at(1, 0.25)])
    np.testing.assert_allclose(near_tip.M, [0.25e-3], rtol=1e-2)


def test_a_node_counts_with_the_element_that_begins_there():
    scene = ancf.Scene((0.0, 0.0))
    rod = scene.add_beam("thin", (0, 0), (2, 0), 2, ancf.Circle(0.05), STEEL)
    scene.clamp(rod.start)
    scene.point_force(rod.node(1), (5.0, 0.0))
    scene.point_force(rod.end, (2.0, 0.0))
    rest = ancf.solve_static(scene)
    points = [rod.start, rod.at(1.0 - 1e-6), rod.node(1), rod.end]
    for s in (points, [0.0, 1.0 - 1e-6, 1.0, 2.0]):
        np.testing.assert_allclose(rest.section_force(rod, s).N, [7.0, 7.0, 2.0, 2.0], rtol=1e-6)
    assert rest.section_force(rod, rod.node(1)).N == pytest.approx([2.0])
    assert rest.strain(rod, 0.5).shape == (1,)


def test_states_in_a_file_are_read_in_blocks(tmp_path, monkeypatch):
    scene, rod = pendulum("thick", 6)
    run = ancf.simulate(scene, 0.05, 1e-3)
    stored = ancf.simulate(scene, 0.05, 1e-3, output=tmp_path / "run.h5")
    monkeypatch.setattr("ancfsparse.results.fields.section_forces.BLOCK_SIZE", 10_000)
    whole, read = run.section_force(rod), stored.section_force(rod)
    assert whole.M.shape == (51, 6, 2)
    np.testing.assert_array_equal(whole.M, read.M)
    np.testing.assert_array_equal(run.curvature(rod, 0.3), stored.curvature(rod, 0.3))


@pytest.mark.parametrize(
    ("s", "message"),
    [
        (3.0, r"s = 3 m lies outside beam 0: it runs from 0 to 2 m"),
        ([0.5, np.nan], "s = nan m lies outside beam 0"),
        ("tip", "s on beam 0 must be arc coordinates in m, got 'tip'"),
        ([[0.1]], "must be a list of one or more arc coordinates"),
        ([], "must be a list of one or more arc coordinates"),
    ],
)
def test_places_are_checked(s, message):
    scene, rod = pendulum(n_elements=4)
    run = ancf.simulate(scene, 0.01, 1e-3)
    with pytest.raises(InputError, match=message):
        run.section_force(rod, s)


def test_points_are_checked(system):
    scene, rod = pendulum(n_elements=4)
    run = ancf.simulate(scene, 0.01, 1e-3)
    with pytest.raises(InputError, match="s must be points of beam 0, got beam 0 at s = 2 m"):
        run.section_force(rod, [rod.end, system.rod.end])
    with pytest.raises(InputError, match="is not part of this scene"):
        run.strain(system.rod)
    with pytest.raises(InputError, match="a beam or a mesh of the run is needed, got 3"):
        run.curvature(3)
    scene = ancf.Scene((0.0, 0.0))
    mesh = scene.add_mesh([(0, 0), (1, 0)], [(0, 1)], "thin", ancf.Circle(0.05), STEEL)
    scene.clamp(mesh.node(0))
    rest = ancf.solve_static(scene)
    with pytest.raises(InputError, match="s on mesh 0 must be points on its edges, such as"):
        rest.strain(mesh, [0.5])
    with pytest.raises(InputError, match="is the end of edges whose forces differ"):
        rest.strain(mesh, [mesh.node(0)])
