"""Meshes from arrays: lines, slopes, handles, and what is refused."""

import numpy as np
import pytest

from ancfsparse.errors import InputError
from ancfsparse.scene import Circle, Clamp, Material, Rectangle, Scene
from ancfsparse.solve import simulate
from tests.grids import grid
from tests.operations import operations

SQUARE, RUBBER = Rectangle(0.01, 0.01), Material(1e8, 4000.0, 0.3)
CROSS = [(0, 0), (1, 0), (2, 0), (1, 1), (1, -1)]


def add(nodes, edges, scene=None, element="thin", **options):
    return (scene or Scene()).add_mesh(nodes, edges, element, SQUARE, RUBBER, **options)


def shuffled_grid(n, m, seed=0):
    """Give nodes and shuffled edges, in random directions, of a square net of n x m nodes."""
    nodes, edges, _ = grid(n, m)
    rng = np.random.default_rng(seed)
    edges = rng.permutation(edges)
    turned = rng.random(len(edges)) < 0.5
    edges[turned] = edges[turned, ::-1]
    return nodes, edges


def test_a_cross_is_two_lines_that_share_a_position():
    mesh = add(CROSS, [(0, 1), (1, 2), (1, 3), (4, 1)], name="cross")
    assert (mesh.n_nodes, mesh.n_elements, mesh.n_lines) == (5, 4, 2)
    assert (mesh.name, mesh.element, mesh.options) == ("cross", "thin", {"strain": "green"})
    np.testing.assert_array_equal(mesh.lengths, 1.0)
    np.testing.assert_array_equal(mesh.row_nodes, [0, 1, 1, 2, 3, 4])
    np.testing.assert_array_equal(mesh.ends, [[0, 1], [1, 3], [2, 4], [5, 2]])
    np.testing.assert_allclose(mesh.vectors[:, 0], [[1, 0], [1, 0], [0, 1], [1, 0], [0, 1], [0, 1]])
    assert repr(mesh) == "cross: 5 nodes, 4 thin elements, 2 line(s), 4 m, planar"


def test_edges_of_a_line_are_turned_the_way_of_its_first():
    mesh = add([(0, 0), (1, 0), (2, 0), (3, 0)], [(2, 1), (0, 1), (2, 3)])
    np.testing.assert_array_equal(mesh.edges, [[2, 1], [1, 0], [3, 2]])
    np.testing.assert_array_equal(mesh.flipped, [False, True, True])
    np.testing.assert_allclose(mesh.vectors[:, 0], [[-1, 0]] * 4)
    assert mesh.n_lines == 1


@pytest.mark.parametrize("seed", range(3))
def test_a_shuffled_net_has_a_line_for_each_row_and_column(seed):
    mesh = add(*shuffled_grid(4, 6, seed))
    assert mesh.n_lines == 4 + 6
    assert len(mesh.row_nodes) == 2 * 24
    directions = mesh.positions[mesh.edges[:, 1]] - mesh.positions[mesh.edges[:, 0]]
    for end in (0, 1):
        np.testing.assert_allclose(mesh.vectors[mesh.ends[:, end], 0], directions, atol=1e-15)


def test_bends_below_the_limit_are_smooth():
    def bent(degrees, **options):
        angle = np.radians(degrees)
        nodes = [(0, 0), (1, 0), (1 + np.cos(angle), np.sin(angle))]
        return add(nodes, [(0, 1), (1, 2)], **options)

    assert bent(4.9).n_lines == 1
    assert bent(5.1).n_lines == 2
    assert bent(5.1, smooth=6).n_lines == 1
    assert bent(0.0, smooth=0).n_lines == 2
    middle = bent(4.0).vectors[1, 0]
    np.testing.assert_allclose(middle, [np.cos(np.radians(2)), np.sin(np.radians(2))])


def test_the_straightest_continue_each_other_and_nothing_twice():
    angles = np.radians([180.0, 0.5, 3.0, -2.0])
    nodes = np.vstack([[0.0, 0.0], np.stack([np.cos(angles), np.sin(angles)], 1)])
    mesh = add(nodes, [(0, 1), (0, 2), (0, 3), (0, 4)])
    assert mesh.n_lines == 3
    one, two = mesh.ends[mesh.edges == 0][[0, 1]]
    assert one == two  # the edges to 180 and 0.5 degrees
    assert len(set(mesh.ends[mesh.edges == 0])) == 3


def test_a_closed_ring_is_one_line():
    angle = np.linspace(0, 2 * np.pi, 100, endpoint=False)
    nodes = np.stack([np.cos(angle), np.sin(angle)], 1)
    number = np.arange(100)
    edges = np.stack([number, (number + 1) % 100], 1)
    edges[::3] = edges[::3, ::-1]
    mesh = add(nodes, edges)
    assert (mesh.n_lines, len(mesh.row_nodes)) == (1, 100)
    assert len(np.unique(mesh.edges[:, 0])) == 100  # each node begins one edge


def test_points_on_a_mesh():
    mesh = add([(0, 0), (1, 0), (3, 0)], [(1, 0), (1, 2)], name="net")
    assert mesh.flipped.tolist() == [False, True]
    assert repr(mesh.node(1)) == "net, node 1"
    np.testing.assert_array_equal(mesh.node(2).position, [3, 0])
    assert mesh.at(0, 0.0) == mesh.at(1, 0.0) == mesh.node(1)
    assert mesh.at(1, 2.0) == mesh.node(2)
    inside = mesh.at(1, 0.5)
    np.testing.assert_allclose(inside.position, [1.5, 0])
    assert inside.s == pytest.approx(0.5)
    assert repr(inside) == "net, edge 1 at s = 0.5 m"


def test_joints_and_loads_take_nodes_of_a_mesh():
    scene = Scene()
    mesh = add(CROSS, [(0, 1), (1, 2), (1, 3), (4, 1)], scene)
    beam = scene.add_beam("thin", (2, 0), (4, 0), 2, SQUARE, RUBBER)
    joint = scene.clamp(mesh.node(0))
    assert isinstance(joint, Clamp)
    scene.connect(mesh.node(2), beam.start)
    scene.rod(mesh.node(3), (1, 3))
    scene.point_force(mesh.at(0, 0.5), (0, 1))
    scene.point_moment(mesh.node(4), 1.0)
    scene.distributed_force(mesh, (0, 1))
    with pytest.raises(InputError, match=r"edge 0 at .* lies inside element 0: its ends are"):
        scene.clamp(mesh.at(0, 0.5))
    with pytest.raises(InputError, match="node 0 is constrained twice"):
        scene.pin(mesh.node(0))
    assert scene.beams == [mesh, beam]


LINE = [(0, 0), (1, 0), (2, 0)]
BAD = [
    ({"nodes": [(0, 0, 0), (1, 0, 0)]}, r"shape \(n, 2\) .* scene is planar, got shape \(2, 3\)"),
    ({"nodes": [["0", "0"], ["1", "0"], ["0", "1"]]}, "must be a table of real numbers"),
    ({"nodes": [[0j, 0], [1 + 1j, 0], [0, 1]]}, "must be a table of real numbers"),
    ({"nodes": [[0, 0], [1e200, 0], [0, 1]]}, r"1 node beyond 1e\+150 m, first node 1 at \(1e"),
    ({"nodes": "net"}, "must be a table of real numbers with 2 columns, got 'net'"),
    ({"nodes": [(0, 0), (1,)]}, "must be a table of real numbers with 2 columns"),
    ({"nodes": [(0, 0), (1, np.nan), (np.inf, 0)]},
     r"2 nodes whose position is not finite, first node 1: \(1, nan\) m"),
    ({"edges": [(0, 1, 2)]}, r"must have shape \(m, 2\) with at least one row, got shape \(1, 3\)"),
    ({"edges": []}, r"must have shape \(m, 2\) with at least one row"),
    ({"edges": [(0, 1), (2,)]}, "must be pairs of node numbers"),
    ({"edges": [(0.0, 1.0)]}, "must be numbers of nodes, that is integers, got float64"),
    ({"edges": [(0, 1), (1, 3), (-1, 2)]},
     r"do not exist in 2 edges, first in edge 1, \(1, 3\): its nodes are 0 to 2"),
    ({"edges": [(0, 1), (1, 1), (1, 2)]}, r"1 edge of zero length, first edge 1, \(1, 1\)"),
    ({"edges": [(0, 1)]}, r"1 node that no edge ends at, first node 2 at \(2, 0\) m"),
    ({"edges": [(0, 1), (1, 2), (1, 0), (2, 1)]},
     r"2 edges given before, first edge 2, \(1, 0\), which joins the nodes of edge 0"),
    ({"nodes": [*LINE, (0, 0), (1, 1e-12)], "edges": [(0, 1), (1, 2), (3, 4)]},
     r"2 nodes where another is already, first node 3, at the place of node 0, \(0, 0\) m"),
    ({"element": "thing"}, "unknown element 'thing': did you mean 'thin'"),
    ({"element": "string", "strain": "green"}, "'string', which has no option strain"),
    ({"smooth": 120}, "smooth of mesh 0 must lie between 0 and 90 degrees, got 120"),
    ({"velocity": (1, 2, 3)}, "velocity of mesh 0 has 3 components"),
    ({"name": " "}, "name of a mesh must be a non-empty string"),
]  # fmt: skip


@pytest.mark.parametrize(("changes", "message"), BAD)
def test_bad_meshes(changes, message):
    scene = Scene()
    with pytest.raises(InputError, match=message) as caught:
        add(**{"nodes": LINE, "edges": [(0, 1), (1, 2)]} | changes, scene=scene)
    assert "\n" not in str(caught.value)
    assert scene.beams == []


@pytest.mark.parametrize(
    ("point", "message"),
    [
        (lambda m: m.node(3), "mesh 0 has nodes 0 to 2, there is no node 3"),
        (lambda m: m.node(-1), "there is no node -1$"),
        (lambda m: m.at(2, 0.1), "mesh 0 has edges 0 to 1, there is no edge 2"),
        (lambda m: m.at(0, 1.1), "s = 1.1 m lies outside edge 0 of mesh 0: it runs from 0 to 1 m"),
        (lambda m: m.node(0).s, "mesh 0, node 0 has no arc coordinate"),
    ],
)
def test_points_that_are_not_there(point, message):
    with pytest.raises(InputError, match=message):
        point(add(LINE, [(0, 1), (1, 2)]))


def test_many_joints_cost_no_more_than_their_number():
    def cost(n):
        scene = Scene()
        mesh = add(*shuffled_grid(n, n), scene)
        return operations(lambda: [scene.pin(mesh.node(k)) for k in range(n * n)])

    # Looking through all joints each time took minutes for 14 400 of them.
    _, few, many = (cost(n) for n in (3, 10, 20))
    assert many < 4.4 * few


def test_a_large_mesh_is_made_without_a_loop_over_elements():
    _, few, many = (operations(lambda n=n: add(*shuffled_grid(n, n))) for n in (3, 10, 40))
    assert many < 1.1 * few
    mesh = add(*shuffled_grid(300, 300))
    assert mesh.n_elements == 2 * 300 * 299
    assert mesh.n_lines == 600


def test_a_length_whose_powers_are_no_numbers():
    scene = Scene()
    scene.add_mesh([(0, 0), (1e120, 0)], [(0, 1)], "thin", Circle(0.01), Material(1e8, 1e3))
    with pytest.raises(InputError, match="parameters beyond the range of floating-point numbers"):
        simulate(scene, 1e-3, 1e-3)
