"""Rotations of the nodes: what makes a seed that is turned with the body a good one."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import ancfsparse as ancf
from ancfsparse.dispatch import compiled_module
from ancfsparse.system import System
from ancfsparse.system.rigid_motion.corotated_frames import make_corotated_frame
from tests.matrices import full, stiffness

KINDS = {
    "l2t2": ("l2t2", 2, {}),
    "thin, planar": ("thin", 2, {}),
    "thin, planar, biot": ("thin", 2, {"strain": "biot"}),
    "thin": ("thin", 3, {}),
    "thin, biot": ("thin", 3, {"strain": "biot"}),
    **{
        f"thick, {dim}d, {curvature}, {section}": (
            "thick",
            dim,
            {"curvature": curvature, "section_strain": section},
        )
        for dim in (2, 3)
        for curvature in ("axis", "section")
        for section in ("consistent", "nodal")
    },
}


def free_beam(kind, n_elements=3):
    element, dim, options = KINDS[kind]
    scene = ancf.Scene((0.0,) * dim)
    start, end = np.zeros(dim), np.eye(dim)[0]
    scene.add_beam(
        element, start, end, n_elements, ancf.Rectangle(0.1, 0.1), ancf.Material(1e6, 1000.0, 0.3),
        **options,
    )  # fmt: skip
    return System(scene)


def global_rotation(dim, rng):
    """Some rotation, not small."""
    r = Rotation.from_rotvec(rng.normal(size=3)).as_matrix()
    return r if dim == 3 else np.array([[np.cos(2.0), -np.sin(2.0)], [np.sin(2.0), np.cos(2.0)]])


def turned(system, r):
    """The matrix that turns every vector of the coordinates by r."""
    big = np.eye(system.n_all)
    for places in system.places:
        for first in range(0, places.shape[1] - system.dim + 1, system.dim):
            for where in places[:, first : first + system.dim]:
                big[np.ix_(where, where)] = r
    return big


def matrix_of(frame, n):
    return np.column_stack([frame.forward(e) for e in np.eye(n)])


def turned_frame(system, q0, q1):
    """Return the frame that holds one state and has turned to another."""
    frame = make_corotated_frame(system)
    frame.hold(q0)
    frame.turn(q1)
    return frame


@pytest.mark.parametrize(
    "kind", [*(kind for kind, (_, dim, _) in KINDS.items() if dim == 2), "thick, 3d, axis, nodal"]
)
def test_the_frame_of_a_plane_or_a_spatial_beam_finds_the_rotation(kind, rng):
    system = free_beam(kind)
    q = system.q0 + 0.05 * rng.normal(size=system.n_all)
    big = turned(system, global_rotation(system.dim, rng))
    frame = turned_frame(system, q, big @ q)
    np.testing.assert_allclose(matrix_of(frame, system.n_free), big, rtol=0, atol=1e-14)


def test_in_space_a_cable_takes_the_smallest_rotation(rng):
    system = free_beam("thin", 1)
    q = system.q0 + 0.2 * rng.normal(size=system.n_all)
    moved = q + 0.8 * rng.normal(size=system.n_all)
    frame = turned_frame(system, q, moved)
    expected = np.zeros((12, 12))
    for places in system.places[0]:
        old, new = (x[places[3:]] / np.linalg.norm(x[places[3:]]) for x in (q, moved))
        axis = np.cross(old, new)
        angle = np.arctan2(np.linalg.norm(axis), old @ new)
        r = Rotation.from_rotvec(axis / np.linalg.norm(axis) * angle).as_matrix()
        expected[np.ix_(places[:3], places[:3])] = expected[np.ix_(places[3:], places[3:])] = r
    np.testing.assert_allclose(matrix_of(frame, 12), expected, rtol=0, atol=1e-14)


@pytest.mark.parametrize("direction", [(1.0, 0.0, 0.0), (0.3, -2.0, 0.6)])
def test_half_a_turn_is_a_rotation_too(direction):
    system = free_beam("thin", 1)
    slopes = system.places[0][:, 3:]
    q, back = system.q0.copy(), system.q0.copy()
    q[slopes], back[slopes] = direction, -np.array(direction)
    frame = turned_frame(system, q, back)
    r = matrix_of(frame, 12)[np.ix_(slopes[0], slopes[0])]
    np.testing.assert_allclose(r @ direction, back[slopes[0]], rtol=0, atol=1e-14)
    np.testing.assert_allclose(r @ r.T, np.eye(3), rtol=0, atol=1e-14)
    assert np.linalg.det(r) == pytest.approx(1.0)


def test_a_crossing_turns_by_the_average_of_its_slopes():
    x = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [1, -1, 0], [1, 1, 0]])
    edges = np.array([[0, 1], [1, 2], [3, 1], [1, 4]])
    scene = ancf.Scene((0.0, 0.0, 0.0))
    net = scene.add_mesh(x, edges, "thin", ancf.Circle(0.1), ancf.Material(1e6, 1000.0))
    system = System(scene)
    rows = system.rows(net.node(1))
    assert len(rows) == 2
    turns = [Rotation.from_rotvec([0.0, 0.0, angle]).as_matrix() for angle in (0.5, 0.9)]
    q = system.q0.copy()
    for row, turn in zip(rows, turns, strict=True):
        q[row[3:]] = turn @ q[row[3:]]
    found = matrix_of(turned_frame(system, system.q0, q), system.n_free)
    position = rows[0][:3]
    middle = Rotation.from_rotvec([0.0, 0.0, 0.7]).as_matrix()
    np.testing.assert_allclose(found[np.ix_(position, position)], middle, rtol=0, atol=1e-14)
    for row, turn in zip(rows, turns, strict=True):
        np.testing.assert_allclose(found[np.ix_(row[3:], row[3:])], turn, rtol=0, atol=1e-14)


def test_average_in_the_plane_where_beams_meet():
    scene = ancf.Scene((0.0, 0.0))
    section, material = ancf.Rectangle(0.1, 0.1), ancf.Material(1e6, 1000.0)
    a = scene.add_beam("l2t2", (0, 0), (1, 0), 1, section, material)
    b = scene.add_beam("l2t2", (1, 0), (1, 1), 1, section, material)
    scene.connect(a.end, b.start)
    system = System(scene)
    q = system.q0.copy()
    ends = [system.place(a.end), system.place(b.start)]
    q[ends[0][2:]] = np.cos(0.2), np.sin(0.2)  # turned by 0.2, the other one by 0.6
    q[ends[1][2:]] = -np.sin(0.6), np.cos(0.6)
    frame = turned_frame(system, system.q0, q)
    shared = ends[0][:2]
    found = matrix_of(frame, system.n_free)[np.ix_(shared, shared)]
    c, s = np.cos(0.4), np.sin(0.4)
    np.testing.assert_allclose(found, [[c, -s], [s, c]], rtol=0, atol=1e-14)


def test_fixed_and_linearly_constrained_vectors_stay(rng):
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam(
        "l2t2", (0, 0), (1, 1), 4, ancf.Rectangle(0.1, 0.1), ancf.Material(1e6, 1000.0)
    )
    scene.pin(rod.start)
    scene.pin(rod.end, as_constraint=True)
    scene.rod(rod.node(2), (0.0, 1.0))
    system = System(scene)
    frame = turned_frame(system, system.q0, turned(system, global_rotation(2, rng)) @ system.q0)
    n = system.n_free + system.n_multipliers
    found = matrix_of(frame, n)
    held = [*system.place(rod.end)[:2], *range(system.n_free, n)]
    np.testing.assert_array_equal(found[held], np.eye(n)[held])
    # The pinned node has a slope that turns, and a rod's end turns with its node.
    for where in (system.place(rod.start)[2:], system.place(rod.node(2))[:2]):
        assert abs(found[where[0], where[1]]) > 0.5


def test_there_and_back(rng):
    system = free_beam("thin", 5)
    frame = make_corotated_frame(system)
    frame.hold(system.q0)
    x = rng.normal(size=system.n_free)
    np.testing.assert_array_equal(frame.forward(x), x)
    frame.turn(system.q0 + 0.5 * rng.normal(size=system.n_all))
    y = frame.forward(x)
    assert np.abs(y - x).max() > 0.1
    np.testing.assert_allclose(frame.backward(y), x, rtol=0, atol=1e-14)
    frame.hold(system.q0)
    np.testing.assert_array_equal(frame.backward(x), x)


def test_operations_grow_with_the_vectors():
    planar = compiled_module("rotation").Frame(
        4, np.array([[2, 3]], dtype=np.int32), np.zeros(1, np.int32), np.zeros(0, np.int32),
        np.array([[0, 1], [2, 3]], dtype=np.int32), np.zeros(2, np.int32),
    )  # fmt: skip
    assert planar.operations == 24  # two vectors, twice 4 products and 2 sums each


@pytest.mark.parametrize("kind", KINDS)
def test_material_part_is_the_tangent_without_stress_and_never_negative(kind, rng):
    system = free_beam(kind)
    material = full(system, system.assembly.material(0.0, 1.0, system.q0))
    k = stiffness(system, system.q0).toarray()
    np.testing.assert_allclose(material, k, rtol=0, atol=1e-11 * np.abs(k).max())
    q = system.q0 + 0.1 * rng.normal(size=system.n_all)
    bent = full(system, system.assembly.material(0.0, 1.0, q))
    assert np.linalg.eigvalsh(bent).min() > -1e-10 * np.abs(bent).max()
    # With the mass beside it, as in a step.
    both = full(system, system.assembly.material(2.0, 3.0, q))
    mass = full(system, system.assembly.mass)
    np.testing.assert_allclose(both, 2.0 * mass + 3.0 * bent, rtol=1e-12, atol=1e-12)


def test_material_part_keeps_the_constraints():
    scene = ancf.Scene((0.0, -9.81))
    rod = scene.add_beam(
        "l2t2", (0, 0), (1, 0), 2, ancf.Rectangle(0.1, 0.1), ancf.Material(1e6, 1000.0)
    )
    scene.rod(rod.end, (1.0, 1.0))
    system = System(scene)
    system.assembly.set_regularization(0.25)
    n = system.n_free
    found = full(system, system.assembly.material(1.0, 1.0, system.q0))
    phi_q = system.constraints.jacobian(system.q0).toarray()
    np.testing.assert_allclose(found[n:, :n], phi_q, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(found[n:, n:], [[-0.25]])
