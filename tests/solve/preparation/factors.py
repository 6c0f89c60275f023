"""Lattices, and the exact factors of scenes."""

import numpy as np

import ancfsparse as ancf
from ancfsparse.seeds import SparseSeed
from ancfsparse.system import System


def cubic_lattice(n):
    """A cube of n nodes a side, held at three corners."""
    number = np.arange(n**3).reshape(n, n, n)
    nodes = 0.1 * np.stack(np.unravel_index(number.ravel(), number.shape), axis=1)
    pairs = [(np.delete(number, -1, axis), np.delete(number, 0, axis)) for axis in range(3)]
    edges = np.concatenate([np.reshape(each, (2, -1)).T for each in pairs])
    scene = ancf.Scene((0.0, 0.0, -9.81))
    mesh = scene.add_mesh(nodes, edges, "thin", ancf.Circle(0.01), ancf.Material(1e8, 1000.0))
    for k in (0, n - 1, n * n - 1):
        scene.pin(mesh.node(k))
    return scene


def seed_of(scene):
    """Return the complete factor of a scene."""
    system = System(scene)
    return SparseSeed(system.pattern.indptr, system.pattern.indices, system.n_free)
