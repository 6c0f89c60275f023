"""Welded frames beside the stiffness method of frame theory, written here apart."""

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.errors import InputError

STEEL = ancf.Material(2.1e11, 7850.0, 0.3)
SECTION = ancf.Rectangle(0.02, 0.03)
CURVES = [{}, {"curvature": "section"}]
# Columns of 2 and 3 m, a beam between them with a node, and a girder out of their plane.
NODES = np.array([(0, 0, 0), (0, 0, 2), (1.5, 0, 2.5), (3, 0, 2), (3, 0, -1), (1.5, 2, 2.5)], float)
EDGES = np.array([(0, 1), (1, 2), (2, 3), (4, 3), (2, 5)])


def bar(way, up, section, material):
    """Return the stiffness of a bar of Bernoulli's beam theory, (12, 12): translation, rotation."""
    length = np.linalg.norm(way)
    e_x = way / length
    e_y = up - (up @ e_x) * e_x
    e_y /= np.linalg.norm(e_y)
    turn = np.kron(np.eye(4), np.stack([e_x, e_y, np.cross(e_x, e_y)]))
    young, shear = material.youngs_modulus, material.shear_modulus
    k = np.zeros((12, 12))
    for places, stiffness in (
        ((0, 6), young * section.area),
        ((3, 9), shear * section.torsion_constant),
    ):
        k[np.ix_(places, places)] += stiffness / length * np.array([[1, -1], [-1, 1]])
    for places, inertia, sign in (
        ((1, 5, 7, 11), section.inertia_z, 1.0),
        ((2, 4, 8, 10), section.inertia_y, -1.0),
    ):
        a, b = 6.0 * sign * length, length**2
        k[np.ix_(places, places)] += (young * inertia / length**3) * np.array(
            [[12, a, -12, a], [a, 4 * b, -a, 2 * b], [-12, -a, 12, -a], [a, 2 * b, -a, 4 * b]]
        )
    return turn.T @ k @ turn


def displaced(nodes, edges, up, held, node, force, section, material):
    """Return the displacements of all nodes of a spatial frame under a force [m]."""
    k = np.zeros((6 * len(nodes), 6 * len(nodes)))
    for (a, b), side in zip(edges, up, strict=True):
        places = np.concatenate([6 * a + np.arange(6), 6 * b + np.arange(6)])
        k[np.ix_(places, places)] += bar(nodes[b] - nodes[a], side, section, material)
    free = np.setdiff1d(np.arange(len(k)), (6 * np.array(held)[:, None] + np.arange(6)).ravel())
    load = np.zeros(len(k))
    load[6 * node : 6 * node + 3] = force
    moved = np.zeros(len(k))
    moved[free] = np.linalg.solve(k[np.ix_(free, free)], load[free])
    return moved.reshape(-1, 6)[:, :3]


@pytest.mark.parametrize("options", CURVES, ids=str)
def test_a_spatial_frame_moves_as_frame_theory_says(options):
    """Slender bars under a small force: shear and second order are below 2e-3."""
    up = np.array([(0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 1, 0), (0, 0, 1)], float)
    force, held = np.array([0.3, 0.2, -0.4]), (0, 4)
    expected = displaced(NODES, EDGES, up, held, 5, force, SECTION, STEEL)
    scene = ancf.Scene((0.0, 0.0, 0.0))
    frame = scene.add_frame(NODES, EDGES, "thick", 8, SECTION, STEEL, up=up, **options)
    for k in held:
        scene.clamp(frame.node(k))
    scene.point_force(frame.node(5), force)
    rest = ancf.solve_static(scene)
    assert rest.stable
    found = np.array([rest.displacement(frame.node(k)) for k in range(len(NODES))])
    np.testing.assert_allclose(found, expected, rtol=0.0, atol=4e-3 * np.abs(expected).max())


def sway(element, n, **options):
    """Return the sway of a portal frame over that of frame theory without stretch.

    Fixed feet, beam and columns alike, k = h / l: P h^3 / (12 E I) (2 + 3 k) / (1 + 6 k), from the
    equilibrium of moments in both corners (slope and deflection).
    """
    height, span, load = 2.0, 3.0, 5.0
    scene = ancf.Scene((0.0, 0.0))
    nodes = [(0, 0), (0, height), (span, height), (span, 0)]
    frame = scene.add_frame(nodes, None, element, n, SECTION, STEEL, **options)
    scene.clamp(frame.node(0))
    scene.clamp(frame.node(3))
    scene.point_force(frame.node(1), (load, 0.0))
    k = height / span
    stiffness = STEEL.youngs_modulus * SECTION.inertia_z
    expected = load * height**3 / (12.0 * stiffness) * (2.0 + 3.0 * k) / (1.0 + 6.0 * k)
    return ancf.solve_static(scene).displacement(frame.node(1))[0] / expected


@pytest.mark.parametrize("element", ["thin", "l2t2"])
def test_the_sway_of_a_portal_frame(element):
    assert sway(element, 4) == pytest.approx(1.0, abs=2e-4)


@pytest.mark.parametrize("options", [*CURVES, {"section_strain": "nodal"}], ids=str)
def test_corners_do_not_soften_where_elements_become_shorter(options):
    """A weld that let slopes follow section vectors lost .8 and 3 % with 64 elements, and more."""
    errors = [sway("thick", n, **options) - 1.0 for n in (16, 32, 64)]
    assert abs(errors[0]) < 4e-3
    assert np.abs(errors[1:]).max() < 6e-4
    assert abs(errors[2] - errors[1]) < 0.3 * abs(errors[1] - errors[0])


def test_a_cable_on_a_thick_beam():
    """The same portal frame, its beam a cable that is welded to thick columns."""
    scene = ancf.Scene((0.0, 0.0))
    places = [(0, 0), (0, 2), (3, 2), (3, 0)]
    found = []
    for n in (16, 64):
        scene = ancf.Scene((0.0, 0.0))
        beams = [
            scene.add_beam(element, a, b, n, SECTION, STEEL)
            for element, a, b in zip(
                ("thick", "thin", "thick"), places[:-1], places[1:], strict=True
            )
        ]
        scene.clamp(beams[0].start)
        scene.clamp(beams[2].end)
        scene.weld(beams[0].end, beams[1].start)
        scene.weld(beams[1].end, beams[2].start)
        scene.point_force(beams[0].end, (5.0, 0.0))
        found.append(ancf.solve_static(scene).displacement(beams[0].end)[0])
    theory = 5.0 * 8.0 / (12.0 * 2.1e11 * SECTION.inertia_z) * 0.8
    np.testing.assert_allclose(found, theory, rtol=1e-3)


def test_a_polyline_keeps_its_corners_in_motion():
    scene = ancf.Scene((0.0, 0.0, -9.81))
    points = [(0, 0, 0), (0.5, 0, 0), (0.5, 0.4, 0), (0.5, 0.4, 0.3)]
    soft = ancf.Material(1e8, 2000.0)
    line = scene.add_frame(points, None, "thick", 4, ancf.Circle(0.02), soft, name="pipe")
    scene.clamp(line.node(0))
    run = ancf.simulate(scene, 0.2, 1e-3, integrator=ancf.EnergyMomentum(), tolerance=1e-10)
    assert run.energy.drift < 1e-6
    for k in (1, 2):
        rows = [run.system.rows(end)[0] for end in line.ends(k)]
        vectors = np.concatenate([run.q[:, row[3:]].reshape(-1, 3, 3) for row in rows], axis=1)
        angles = np.einsum("tik,tjk->tij", vectors, vectors)
        np.testing.assert_allclose(angles, np.broadcast_to(angles[0], angles.shape), atol=1e-8)
    assert line.at(1, 0.2).beam.name == "pipe, edge 1"


def test_frames_are_recorded_by_their_beams_and_welds(tmp_path):
    scene = ancf.Scene((0.0, 0.0, -9.81))
    frame = scene.add_frame(NODES, EDGES, "thick", 2, SECTION, STEEL)
    assert len(scene.beams) == 5
    assert len(scene.joints) == 4
    assert repr(frame) == f"frame: 6 nodes, 5 beams, {sum(b.length for b in frame.beams):.6g} m"
    scene.save(tmp_path / "frame.json")
    assert ancf.Scene.load(tmp_path / "frame.json") == scene


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"element": "thin"}, "cables in space do not include the rotation that a weld constrains"),
        ({"element": "string"}, "strings do not include the rotation that a weld constrains"),
        ({"edges": [(0, 1), (1, 9)]}, "names nodes that do not exist"),
        ({"up": (0, 0, 1)}, "parallel to edge 0"),
        ({"up": (0, 0)}, "must be one direction, or one for each of its 5 edges"),
        ({"n_elements": 0}, "n_elements"),
        ({"curvature": "round"}, "curvature"),
        ({"nodes": 3}, "nodes of frame 0"),
    ],
)
def test_what_does_not_fit_adds_nothing(changed, message):
    scene = ancf.Scene((0.0, 0.0, -9.81))
    given = {
        "nodes": NODES, "edges": EDGES, "element": "thick", "n_elements": 2, "section": SECTION,
        "material": STEEL,
    }  # fmt: skip
    with pytest.raises(InputError, match=message):
        scene.add_frame(**(given | changed))
    assert not scene.bodies
    frame = scene.add_frame(**given)
    with pytest.raises(InputError, match="there is no node 7"):
        frame.node(7)
    with pytest.raises(InputError, match="there is no edge 5"):
        frame.at(5, 0.0)
