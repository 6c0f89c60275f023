"""Count the entries of the factor of a scene before it is allocated."""

from __future__ import annotations

import numpy as np

from ancfsparse.scene import Scene
from ancfsparse.seeds import fill_of
from ancfsparse.system.assembly.sparsity_pattern import build_pattern


def count_factor_entries(scene: Scene) -> float:
    """Return the approximate number of entries of the factor of a scene.

    Each position and each slope is one unknown in place of two, three or nine coordinates, so the
    ordering takes at most a ninth of the time.  Constrained coordinates are counted as free.
    """
    import scipy.sparse as sp
    from scipy.sparse.csgraph import connected_components

    first_node, first_row, size = [], [], 0
    for body in scene.bodies:
        first_node.append(size)
        first_row.append(size + body.n_nodes)
        size += body.n_nodes + len(body.row_nodes)
    index = {id(body): k for k, body in enumerate(scene.bodies)}
    pairs = np.array(
        [
            [first_node[index[id(node.beam)]] + node.index for node in joint.nodes]
            for joint in scene.joints
            if joint.joins
        ],
        dtype=int,
    ).reshape(-1, 2)
    same = sp.coo_array((np.ones(len(pairs), dtype=bool), pairs.T), shape=(size, size))
    n_unknowns, unknown = connected_components(same, directed=False)
    cliques = []
    coordinates = -scene.dim * float(size - n_unknowns)
    for body, node, row in zip(scene.bodies, first_node, first_row, strict=True):
        kind = body.kind
        width = len(kind.node_coordinates)
        coordinates += scene.dim * body.n_nodes + (width - scene.dim) * len(body.row_nodes)
        meeting = [node + body.row_nodes[body.ends], row + body.ends]
        cliques.append(unknown[np.concatenate(meeting, axis=1)])
    pattern = build_pattern(n_unknowns, cliques)
    entries = fill_of(pattern.indptr, pattern.indices) + n_unknowns
    return float(entries * (coordinates / n_unknowns) ** 2)
