"""The four updates as the paper writes them (equations 13 to 16), and in compact form.

Nothing here comes from the package: H, s and y are dense NumPy arrays.
"""

import numpy as np


def broyden(h, s, y, d=None):
    """Equation 13; ``d`` are the weights of the inner product, ones if not given."""
    sd = s if d is None else d * s
    return h + np.outer(s - h @ y, sd @ h) / (sd @ h @ y)


def davidon(h, s, y):
    u = s - h @ y
    return h + np.outer(u, u) / (u @ y)


def dfp(h, s, y):
    return h + np.outer(s, s) / (s @ y) - np.outer(h @ y, y @ h) / (y @ h @ y)


def bfgs(h, s, y):
    one = np.eye(len(s))
    left = one - np.outer(s, y) / (y @ s)
    right = one - np.outer(y, s) / (y @ s)
    return left @ h @ right + np.outer(s, s) / (y @ s)


UPDATES = {"broyden": broyden, "davidon": davidon, "dfp": dfp, "bfgs": bfgs}


def compact(rule, h0, s, y):
    """All pairs at once; columns of ``s`` and ``y`` are the pairs, oldest first.

    Byrd, Nocedal, Schnabel, Math. Program. 63 (1994) 129, in inverse form.
    """
    t = h0 @ y
    sy = s.T @ y
    r, d = np.triu(sy), np.diag(np.diag(sy))
    if rule == "broyden":
        middle = s.T @ t - np.tril(s.T @ s, -1)
        return h0 + (s - t) @ np.linalg.solve(middle, s.T @ h0)
    if rule == "davidon":
        middle = r + r.T - d - y.T @ t
        return h0 + (s - t) @ np.linalg.solve(middle, (s - t).T)
    if rule == "dfp":
        below = np.tril(y.T @ s, -1)
        both = np.hstack([t, s])
        middle = np.block([[y.T @ t, below], [below.T, -d]])
        return h0 - both @ np.linalg.solve(middle, both.T)
    assert rule == "bfgs"
    inverse = np.linalg.inv(r)
    both = np.hstack([s, t])
    zero = np.zeros_like(r)
    middle = np.block([[inverse.T @ (d + y.T @ t) @ inverse, -inverse.T], [-inverse, zero]])
    return h0 + both @ middle @ both.T
