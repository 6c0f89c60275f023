"""Chains, nets, lattices and trusses of any size are what they say."""

import numpy as np
import pytest

from ancfsparse import simulate
from ancfsparse.errors import InputError
from ancfsparse.problems import MOTIONS, chain, net, octet
from ancfsparse.scene import Pin
from ancfsparse.system import System


def test_chain_has_elements_of_one_length():
    scene, rod = chain(7)
    assert (rod.element, rod.n_elements, scene.dim) == ("l2t2", 7, 2)
    assert rod.length == pytest.approx(1.4)
    assert rod.velocity is None
    (pin,) = scene.joints
    assert isinstance(pin, Pin)
    assert pin.node == rod.start


def test_net_crosses_in_shared_places():
    scene, along, across = net(4)
    assert len(along) == len(across) == 4
    assert sum(beam.n_elements for beam in scene.beams) == 2 * 4 * 3
    system = System(scene)
    assert system.n_multipliers == 0
    assert system.n_all == 9 * 4**2  # a position and two slopes at each crossing
    assert system.n_all - system.n_free == 3 * 4
    for i in range(4):
        for j in range(4):
            a, b = along[j].node(i), across[i].node(j)
            np.testing.assert_allclose(a.position, b.position, rtol=0, atol=1e-12)
            np.testing.assert_array_equal(system.place(a)[:3], system.place(b)[:3])


@pytest.mark.parametrize("n", [1, 3])
def test_octet_truss_is_a_crystal_of_its_nodes(n):
    scene, mesh = octet(n, "rough")
    # Corners and centres of faces of the cells; the cables between neighbours.
    assert mesh.n_nodes == (n + 1) ** 3 + 3 * n * n * (n + 1)
    assert mesh.n_elements == 12 * n * n * (2 * n + 1)
    np.testing.assert_allclose(mesh.lengths, 0.2, rtol=1e-12)
    places = np.array([mesh.node(k).position for k in range(mesh.n_nodes)])
    assert max(np.bincount(mesh.edges.ravel())) == (12 if n > 1 else 8)
    held = np.array([joint.node.position for joint in scene.joints])
    side = 0.2 * np.sqrt(2.0) * n
    assert {tuple(np.round(place / side, 9)) for place in held} == {
        (x, y, 1.0) for x in (0.0, 1.0) for y in (0.0, 1.0)
    }
    assert np.ptp(places) == pytest.approx(side)
    # A line of k elements has k + 1 slopes: 2 (2 n - 1) lines in each of n + 1 planes that hold
    # corners, 4 n in each of the n between them, along three axes.
    lines = 3 * ((n + 1) * 2 * (2 * n - 1) + n * 4 * n)
    assert len(mesh.row_nodes) == mesh.n_elements + lines


def test_motion_does_not_grow_with_the_size():
    for motion in MOTIONS[1:]:
        fast = [np.abs(System(chain(n, motion).scene).v0).max() for n in (200, 2000)]
        np.testing.assert_allclose(fast[1], fast[0], rtol=0.05)
        wide = [np.abs(System(net(n, motion).scene).v0).max() for n in (21, 41)]
        np.testing.assert_allclose(wide[1], wide[0], rtol=0.3)


def test_motion_needs_more_iterations():
    def iterations(scene):
        return simulate(scene, 0.02, 5e-4, solver="auto").stats.iterations_per_step

    for make, size in ((chain, 100), (net, 8)):
        rest, smooth, rough = (iterations(make(size, motion).scene) for motion in MOTIONS)
        assert rest <= smooth < rough


def test_bad_words_are_refused():
    with pytest.raises(InputError, match="n_nodes must be an integer of at least 2, got 1"):
        net(1)
    with pytest.raises(InputError, match="motion"):
        chain(5, "ruff")
