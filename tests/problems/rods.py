"""Reissner's rod as a boundary value problem, written apart from the package."""

import numpy as np
from scipy.integrate import solve_bvp, solve_ivp
from scipy.optimize import root

G = 9.81


def _along(y, h, v, axial, bending):
    """Return the derivatives of x, y, angle and moment of a planar rod by its length."""
    _, _, angle, moment = y
    c, s = np.cos(angle), np.sin(angle)
    stretch = 1.0 + (h * c + v * s) / axial
    return np.stack([stretch * c, stretch * s, moment / bending, stretch * (h * s - v * c)])


def hung(length, start, end, axial, bending, weight, dip):
    """Return the pull at the start and the middle of a rope between hinges that sags by `dip`."""

    def slopes(s, y, p):
        return _along(y, p[0], p[1] + weight * s, axial, bending)

    def ends(a, b, p):
        return np.array([*(a[:2] - start), a[3], *(b[:2] - end), b[3]])

    s = np.linspace(0.0, length, 400)
    share = s / length
    place = np.outer(start, 1.0 - share) + np.outer(end, share)
    place[1] -= 4.0 * dip * share * (1.0 - share)
    way = np.gradient(place, s, axis=1)
    guess = np.stack([*place, np.arctan2(way[1], way[0]), 0.0 * s])
    pulls = [1.0, -0.5 * weight * length]
    found = solve_bvp(slopes, ends, s, guess, p=pulls, tol=1e-10, max_nodes=100_000)
    assert found.success
    return -found.p, found.sol(0.5 * length)[:2]


def carried(length, end, axial, bending, weight, load):
    """Return where a carriage with a load rests on a rope from the origin, and the pull there.

    Without friction the load is at a right angle to the rope.
    """

    def slopes(t, y, p):
        h, v, at = p
        one = _along(y[:4], h, v + weight * at * t, axial, bending)
        behind = at + (length - at) * t
        other = _along(y[4:], h - load[0], v - load[1] + weight * behind, axial, bending)
        return np.concatenate([at * one, (length - at) * other])

    def ends(a, b, p):
        level = load[0] * np.cos(b[2]) + load[1] * np.sin(b[2])
        return np.array([a[0], a[1], a[3], *(b[4:6] - end), b[7], *(b[:4] - a[4:]), level])

    t = np.linspace(0.0, 1.0, 200)
    at = 0.35 * length
    guess = np.zeros((8, len(t)))
    guess[0], guess[1], guess[2] = 0.3 * end[0] * t, -0.13 * end[0] * t, -0.4
    guess[4], guess[5], guess[6] = 0.3 * end[0] + 0.7 * end[0] * t, -0.13 * end[0] * (1 - t), 0.3
    pulls = [2.0 * abs(load[1]), 0.6 * load[1], at]
    found = solve_bvp(slopes, ends, t, guess, p=pulls, tol=1e-9, max_nodes=100_000)
    assert found.success
    return found.sol(1.0)[:2], -found.p[:2]


def spatial(frame, curvature, length, stiffness, force, moment):
    """Return place (3,) and frame (3, 3) at the end of a rod clamped at the origin.

    `stiffness` is EA, GA, GJ and EI; the force is the same all along, the moment that at the clamp;
    the frame has the tangent as its first column, and `curvature` is in it.
    """
    axial, shear, torsion, bending = stiffness
    soft = 1.0 / np.array([axial, shear, shear])
    turned = 1.0 / np.array([torsion, bending, bending])

    def slopes(_, y):
        turn, m = y[3:12].reshape(3, 3), y[12:]
        along = turn @ (np.array([1.0, 0.0, 0.0]) + soft * (turn.T @ force))
        k = curvature + turned * (turn.T @ m)
        spin = np.array([[0.0, -k[2], k[1]], [k[2], 0.0, -k[0]], [-k[1], k[0], 0.0]])
        return np.concatenate([along, (turn @ spin).ravel(), -np.cross(along, force)])

    begin = np.concatenate([np.zeros(3), frame.ravel(), moment])
    y = solve_ivp(slopes, (0.0, length), begin, method="DOP853", rtol=1e-8, atol=1e-11).y[:, -1]
    return y[:3], y[3:12].reshape(3, 3), y[12:]


def shot(residual, unknowns, shares):
    """Solve for the unknowns of a rod under growing shares of its load."""
    for share in shares:
        found = root(residual, unknowns, args=(share,), tol=1e-8)
        unknowns = found.x
        assert np.abs(found.fun).max() < 1e-7
    return unknowns
