"""Meshes and height fields: distances against exact shapes, and surfaces that are refused."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.scene.force_elements.obstacles.sampled_obstacles import MARGIN_CELLS
from ancfsparse.scene.force_elements.obstacles.surface_distances import simplex_distances
from tests.system.contributions.shapes import sphere

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float) - 0.5
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
TRIANGLES = np.array([t for a, b, c, d in SIDES for t in ((a, b, c), (a, c, d))])


def nodes_of(core):
    """Return the inner nodes of the grid of a core, (n, dim)."""
    sizes = np.array(core.coefficients.shape) - 2
    indices = np.stack(np.meshgrid(*map(np.arange, sizes), indexing="ij"), axis=-1)
    return core.bounds[0] + core.cell * indices.reshape(-1, len(sizes))


@pytest.mark.parametrize("size", [(1.0, 1.0, 1.0), (2.0, 0.7, 0.4)])
@pytest.mark.parametrize("cell", [0.1, 0.077])
def test_distances_at_nodes_are_those_of_an_equal_block(size, cell):
    mesh = ancf.TriangleMesh((0, 0, 0), CUBE * size, TRIANGLES, cell)
    block = ancf.Block((0, 0, 0), size)
    nodes = nodes_of(mesh.core)
    exact, found = block.distances(nodes), mesh.distances(nodes)
    band = np.abs(exact) < MARGIN_CELLS * cell
    assert band.sum() > 1000
    assert (exact[band] < 0.0).any()
    assert np.abs(found - exact)[band].max() < 1e-12
    # Those of the closest nodes in the band, plus the distances from there.
    assert np.abs(found - exact).max() < cell
    assert np.array_equal(
        np.sign(found[np.abs(exact) > 1e-9]), np.sign(exact[np.abs(exact) > 1e-9])
    )


@pytest.mark.parametrize("n", [6, 12])
def test_distances_by_the_vertex_of_a_cone_are_the_least_of_all_triangles(n):
    angles = 2.0 * np.pi * np.arange(n) / n
    base = np.stack([0.5 * np.cos(angles), 0.5 * np.sin(angles), 0.0 * angles], axis=1)
    vertices = np.concatenate([[[0, 0, 1.0], [0, 0, 0]], base])
    i, j = 2 + np.arange(n), 2 + np.roll(np.arange(n), -1)
    triangles = np.concatenate(
        [np.stack([0 * i, i, j], axis=1), np.stack([0 * i + 1, j, i], axis=1)]
    )
    mesh = ancf.TriangleMesh((0, 0, 0), vertices, triangles, cell=1 / 16)
    nodes = nodes_of(mesh.core)
    corners = vertices[triangles]
    exact = np.min(
        [simplex_distances(nodes, np.repeat(each[None], len(nodes), 0)) for each in corners], axis=0
    )
    band = exact < MARGIN_CELLS / 16
    assert np.abs(np.abs(mesh.distances(nodes)) - exact)[band].max() < 1e-12


def test_the_error_of_a_sphere_is_that_of_its_facets(rng):
    """Facets with edges a are below the sphere by up to a^2 / (6 R) in their middle."""
    points = rng.normal(size=(4000, 3))
    points *= (rng.uniform(0.97, 1.1, 4000) / np.linalg.norm(points, axis=1))[:, None]
    ball, errors = ancf.Ball((0, 0, 0), 1.0), []
    for n in (8, 16, 32):
        vertices, triangles = sphere(n, 1.0)
        mesh = ancf.TriangleMesh((0, 0, 0), vertices, triangles, cell=1 / 16)
        edge = np.linalg.norm(np.diff(mesh.lines, axis=1), axis=-1).max()
        error = mesh.distances(points) - ball.distances(points)
        assert np.abs(error).max() < 1.5 * edge**2 / 6.0
        assert error.mean() > 0.0
        errors.append(np.abs(error).max())
    assert errors[0] > 3.0 * errors[1] > 9.0 * errors[2]


@pytest.mark.parametrize("dim", [2, 3])
def test_a_field_of_the_heights_of_a_disc_is_a_drum(dim, rng):
    x = np.linspace(-0.5, 0.5, 51)
    heights = np.sqrt(1.0 - x**2) - 1.0
    points = np.stack([rng.uniform(-0.3, 0.3, 2000), rng.uniform(-0.02, 0.02, 2000)], axis=1)
    points[:, 1] += np.sqrt(1.0 - points[:, 0] ** 2) - 1.0
    base, drum = (-0.5, 0), ancf.Drum((0, -1), 1.0)
    if dim == 3:
        heights = np.repeat(heights[:, None], 21, axis=1)
        points = np.insert(points, 1, rng.uniform(-0.1, 0.1, 2000), axis=1)
        base, drum = (-0.5, -0.2, 0), ancf.Drum((0, 0, -1), 1.0, axis=(0, 1, 0))
    field = ancf.HeightField(base, heights, 0.02)
    error = field.distances(points) - drum.distances(points)
    # Facets of a quarter of a spacing a are below it by up to (a / 4)^2 / 8, and twice that across.
    assert np.abs(error).max() < 0.02**2 / 16 / 8 * (1.2 if dim == 2 else 2.5)


def test_the_bend_radius_is_that_of_the_crests():
    x = np.linspace(0.0, 4.0 * np.pi / 30.0, 81)
    field = ancf.HeightField((0, 0), 0.02 * np.cos(30.0 * x), x[1])
    assert field.bend_radius == pytest.approx(1.0 / (0.02 * 30.0**2), rel=0.1)


def test_a_field_continues_level_and_ends():
    field = ancf.HeightField((0, 0), (0.1, 0.1, 0.1), 0.1)
    assert field.distances(np.array([[-0.3, 0.15], [0.5, 0.0], [0.1, 0.05]])) == pytest.approx(
        [0.05, -0.1, -0.05], abs=2e-6
    )
    far = field.distances(np.array([[-0.6 - 0.5, 0.15], [-5.0, 0.0]]))
    assert np.all(far > 0.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: (CUBE, TRIANGLES[1:]), r"has a hole: 3 of its edges .* from \(-?0.5"),
        (lambda: (CUBE, TRIANGLES[:, ::-1]), "is inside out: its volume is -1 m3"),
        (lambda: (CUBE, [*TRIANGLES[:-1], TRIANGLES[-1][::-1]]), "triangle 11 .* orientation"),
        (lambda: (CUBE, [*TRIANGLES, *TRIANGLES]), "more than two triangles"),
        (lambda: (CUBE, TRIANGLES + 1), "numbers of its 8 vertices"),
        (lambda: (CUBE, TRIANGLES + 0.5), "numbers of its 8 vertices"),
        (lambda: (CUBE[:, :2], TRIANGLES), "3 columns"),
        (lambda: (CUBE * np.nan, TRIANGLES), "vertices of a mesh"),
        (lambda: (CUBE, TRIANGLES, -0.1), "cell of a mesh"),
        (lambda: (CUBE, TRIANGLES, "fine"), "cell of a mesh"),
    ],
)
def test_meshes_that_are_not_closed_are_refused(make, message):
    with pytest.raises(ancf.InputError, match=message):
        ancf.TriangleMesh((0, 0, 0), *make())


def test_other_input_is_refused():
    with pytest.raises(ancf.InputError, match="in space"):
        ancf.TriangleMesh((0, 0), CUBE, TRIANGLES)
    with pytest.raises(ancf.InputError, match=r"more than 2e.07: give it a cell larger than"):
        _ = ancf.TriangleMesh((0, 0, 0), CUBE, TRIANGLES, 1e-3).core
    for heights in ((1.0,), ((1.0, 2.0), (1.0, 2.0)), (1.0, np.inf), "flat"):
        with pytest.raises(ancf.InputError, match="heights of a height field"):
            ancf.HeightField((0, 0), heights, 0.1)
    with pytest.raises(ancf.InputError, match="spacing of a height field"):
        ancf.HeightField((0, 0), (1.0, 1.0), 0.0)
    scene = ancf.Scene((0.0, 0.0))
    cable = scene.add_beam("thin", (0, 3), (1, 3), 4, ancf.Circle(1.2), ancf.Material(1e6, 1e3))
    with pytest.raises(ancf.InputError, match=r"than 0.5 m, the largest distance of its"):
        scene.contact(cable, ancf.HeightField((0, 0), (0.0, 0.0), 0.1), stiffness=1.0)


def test_lines_of_ground_are_a_grid_from_edge_to_edge():
    field = ancf.HeightField((0, 0, 0), np.zeros((101, 41)), 0.1)
    lines = field.lines
    along = np.abs(np.diff(lines, axis=1)[:, 0])
    for axis, length, rows in (0, 10.0, 17), (1, 4.0, 17):
        of_axis = lines[along[:, axis] > 0]
        other = np.unique(of_axis[..., 1 - axis])
        assert len(other) == rows
        assert np.isclose(np.abs(np.diff(of_axis[..., axis])).sum(), rows * length)


@pytest.mark.parametrize(
    "cell", [np.array([]), np.array([0.1, 0.2]), np.ma.masked, "a", -0.1, 1e300]
)
def test_a_cell_that_is_no_length_is_refused(cell):
    with pytest.raises(ancf.InputError, match="cell of a mesh must"):
        ancf.TriangleMesh((0, 0, 0), CUBE, TRIANGLES, cell=cell)
