"""The energies of the elements written a second time, in NumPy and by high-order quadrature.

Nothing here comes from `codegen`.  Functions take coordinates of any floating type, complex included, so
that gradients follow from complex steps; extended precision keeps them exact to about 1e-17.
"""

from collections.abc import Callable, Mapping

import numpy as np

Parameters = Mapping[str, float]
Energy = Callable[[np.ndarray, Parameters], np.ndarray]
LONG = np.longdouble


def gauss(n):
    """Gauss points on [0, 1], improved to extended precision by Newton steps."""
    points, _ = np.polynomial.legendre.leggauss(n)
    s = points.astype(LONG)
    for _ in range(3):
        before, here = np.ones_like(s), s
        for k in range(2, n + 1):
            before, here = here, ((2 * k - 1) * s * here - (k - 1) * before) / LONG(k)
        slope = n * (s * here - before) / (s * s - 1)
        s = s - here / slope
    return (s + 1) / 2, 1 / ((1 - s * s) * slope * slope)


def cubic(xi, length):
    """Hermite shape functions and their first two derivatives by x."""
    one = np.ones_like(xi)
    value = [1 - 3 * xi**2 + 2 * xi**3, length * (xi - 2 * xi**2 + xi**3),
             3 * xi**2 - 2 * xi**3, length * (xi**3 - xi**2)]  # fmt: skip
    slope = [(-6 * xi + 6 * xi**2) / length, 1 - 4 * xi + 3 * xi**2,
             (6 * xi - 6 * xi**2) / length, 3 * xi**2 - 2 * xi]  # fmt: skip
    curve = [(-6 * one + 12 * xi) / length**2, (-4 * one + 6 * xi) / length,
             (6 * one - 12 * xi) / length**2, (6 * xi - 2 * one) / length]  # fmt: skip
    return tuple(np.array(rows) for rows in (value, slope, curve))


def centre_line(nodes, xi, length):
    """r_x and r_xx, (points, dim), from rows r0, r0', r1, r1'."""
    _, slope, curve = cubic(xi, length)
    return slope.T @ nodes, curve.T @ nodes


def square(u):
    return (u * u).sum(axis=-1)


def cross_square(u, v):
    """|u x v|^2 by components, in two or three directions."""
    n = u.shape[-1]
    pairs = [(0, 1)] if n == 2 else [(1, 2), (2, 0), (0, 1)]
    return sum((u[..., i] * v[..., j] - u[..., j] * v[..., i]) ** 2 for i, j in pairs)


def l2t2(q, p):
    xi, w = gauss(9)
    r_x, r_xx = centre_line(q.reshape(4, 2), xi, LONG(p["length"]))
    axial = p["axial_stiffness"] * ((square(r_x) - 1) / 2) ** 2
    return LONG(p["length"]) / 2 * (w @ (axial + p["bending_stiffness"] * square(r_xx)))


def thin(dim, strain):
    def energy(q, p):
        nodes, length = q.reshape(4, dim), LONG(p["length"])
        xi, w = gauss(5)
        r_x, _ = centre_line(nodes, xi, length)
        stretch = (square(r_x) - 1) / 2 if strain == "green" else np.sqrt(square(r_x)) - 1
        axial = w @ (p["axial_stiffness"] * stretch**2)
        xi, w = gauss(3)
        r_x, r_xx = centre_line(nodes, xi, length)
        power = 3 if strain == "green" else 2
        bending = w @ (p["bending_stiffness"] * cross_square(r_x, r_xx) / square(r_x) ** power)
        return length / 2 * (axial + bending)

    return energy


ENERGIES: dict[str, Energy] = {
    "l2t2": l2t2,
    **{
        f"thin_{where}_{strain}": thin(dim, strain)
        for dim, where in ((2, "planar"), (3, "spatial"))
        for strain in ("green", "biot")
    },
}


def gradient(energy: Energy, q, p):
    """Complex step in extended precision."""
    step = LONG(1e-100)
    result = np.empty(len(q), dtype=LONG)
    for i in range(len(q)):
        z = np.asarray(q, dtype=np.clongdouble)
        z[i] += 1j * step
        result[i] = energy(z, p).imag / step
    return result


def hessian(energy: Energy, q, p, step=1e-3):
    """Sixth-order central differences of the complex-step gradient, in extended precision."""
    n = len(q)
    result = np.empty((n, n), dtype=LONG)
    for j in range(n):
        total = np.zeros(n, dtype=LONG)
        for k, weight in ((1, LONG(3) / 4), (2, -LONG(3) / 20), (3, LONG(1) / 60)):
            for sign in (1, -1):
                z = np.asarray(q, dtype=LONG)
                z[j] += sign * k * LONG(step)
                total += sign * weight * gradient(energy, z, p)
        result[:, j] = total / LONG(step)
    return result
