"""Square nets of nodes and edges, as tables for meshes."""

import numpy as np


def grid(n, m=None):
    """Return nodes (x, y) of n x m at distance one, edges between neighbours, and the numbers."""
    m = n if m is None else m
    number = np.arange(n * m).reshape(n, m)
    pairs = (number[:-1], number[1:]), (number[:, :-1], number[:, 1:])
    edges = np.concatenate([np.reshape(pair, (2, -1)).T for pair in pairs])
    return np.stack(np.divmod(number.ravel(), m), axis=1).astype(float), edges, number


def level_grid(n, side=1.0):
    """Return the nodes in space of a level net of n x n nodes, its edges, and the numbers."""
    nodes, edges, number = grid(n)
    return np.pad(nodes * (side / (n - 1)), ((0, 0), (0, 1))), edges, number
