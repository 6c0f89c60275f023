"""The energies of the elements written a second time, in NumPy and by high-order quadrature.

Nothing here comes from `codegen`.  Functions take coordinates of any floating type, complex
included, so that gradients follow from complex steps; extended precision keeps them exact to
about 1e-17.
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


def string(q, p):
    length = LONG(p["length"])
    first, last = q.reshape(2, -1)
    stretch = np.sqrt(square(last - first)) / length - 1
    return p["axial_stiffness"] * length / 2 * stretch**2


def slack_string(q, p):
    length, w = LONG(p["length"]), LONG(p["transition"])
    first, last = q.reshape(2, -1)
    stretch = np.sqrt(square(last - first) / length**2 + w**2) - 1
    return p["axial_stiffness"] * length / 2 * ((stretch + np.sqrt(stretch**2 + w**2)) / 2) ** 2


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


def dot(u, v):
    return (u * v).sum(axis=-1)


def thick(curvature, section_strain):
    """Thick beam in space, 24 coordinates; the published energy and its variants, term by term."""

    def energy(q, p):
        nodes, length = q.reshape(2, 4, 3), LONG(p["length"])
        lam, shear = p["lame_area"], p["shear_modulus_area"]

        def fields(xi):
            line = np.concatenate([nodes[0, :2], nodes[1, :2]])
            r_x, r_xx = centre_line(line, xi, length)
            r_y, r_z = (np.outer(1 - xi, nodes[0, k]) + np.outer(xi, nodes[1, k]) for k in (2, 3))
            return r_x, r_xx, r_y, r_z

        def green(*vectors):
            return [(square(u) - 1) / 2 for u in vectors]

        xi, w = gauss(6)
        r_x, r_xx, r_y, r_z = fields(xi)
        r_yx, r_zx = ((nodes[1, k] - nodes[0, k]) / length for k in (2, 3))
        if section_strain == "consistent":
            e = green(r_x, r_y, r_z)
            density = lam * sum(e) ** 2 + 2 * shear * sum(x * x for x in e)
            section = w @ (density + shear * dot(r_y, r_z) ** 2)
        else:
            eps = green(r_x)[0]
            section = w @ (p["youngs_modulus_area"] * eps**2)
            mean, slope = w @ eps, 12 * (w @ ((xi - LONG(0.5)) * eps))
            for node, side in zip(nodes, (LONG(-0.5), LONG(0.5)), strict=True):
                eps_x = mean + side * slope  # the line of least squares
                eps_y, eps_z = green(*node[2:])
                a, b = (eps + p["poisson_ratio"] * eps_x for eps in (eps_y, eps_z))
                density = lam * (a + b) ** 2 + 2 * shear * (a * a + b * b)
                section += (density + shear * dot(node[2], node[3]) ** 2) / 2
        reissner = np.array([[4, -2], [-2, 4]])
        shearing = 0
        for stiffness, u in ((p["shear_stiffness_y"], r_y), (p["shear_stiffness_z"], r_z)):
            if curvature == "section":
                shearing = shearing + stiffness * (w @ dot(r_x, u) ** 2)
                continue
            mean = np.array([w @ ((1 - xi) * dot(r_x, u)), w @ (xi * dot(r_x, u))])
            shearing = shearing + stiffness * (mean @ reissner @ mean)
        kap_x = (dot(r_z, r_yx) - dot(r_y, r_zx)) / 2
        if curvature == "axis":
            kap_y, kap_z = dot(r_z, r_xx), -dot(r_y, r_xx)
        else:
            kap_y, kap_z = -dot(r_x, r_zx), dot(r_x, r_yx)
        bending = w @ (
            p["torsion_stiffness"] * kap_x**2
            + p["bending_stiffness_y"] * kap_y**2
            + p["bending_stiffness_z"] * kap_z**2
        )
        if curvature == "section":
            bending = bending + change_of_section(p, nodes[0, 2:], nodes[1, 2:], length)
        return length / 2 * (section + shearing + bending)

    return energy


def change_of_section(p, start, end, length):
    """Shear off the axis: half the squares of r_y and r_z and their product change in x."""
    about_y, about_z = (p[f"bending_stiffness_{k}"] / (2 + 2 * p["poisson_ratio"]) for k in "yz")
    along = (square(end) - square(start)) / (2 * length)
    mixed = (dot(*end) - dot(*start)) / length
    return about_z * along[0] ** 2 + about_y * along[1] ** 2 + (about_y + about_z) / 4 * mixed**2


IN_PLANE = np.array([0, 1, 3, 4, 6, 7, 11, 12, 13, 15, 16, 18, 19, 23])
"""Coordinates of the spatial thick beam that its planar form keeps."""


def in_plane(spatial):
    """Return a function of the coordinates of the planar thick beam from one of the spatial one."""

    def planar(q, *others):
        full = np.zeros(24, dtype=q.dtype)
        full[IN_PLANE] = q
        return spatial(full, *others)

    return planar


def by_module(string, slack_string, l2t2, thin, thick):
    """Return functions by the names of the modules that they are of."""
    return {
        "string_planar": string,
        "string_spatial": string,
        "string_planar_slack": slack_string,
        "string_spatial_slack": slack_string,
        "l2t2": l2t2,
        **{
            f"thin_{where}_{strain}": thin(dim, strain)
            for dim, where in ((2, "planar"), (3, "spatial"))
            for strain in ("green", "biot")
        },
        **{
            f"{where}_{curvature}_{section_strain}": change(thick(curvature, section_strain))
            for where, change in (("thick", lambda spatial: spatial), ("thick_planar", in_plane))
            for curvature in ("axis", "section")
            for section_strain in ("consistent", "nodal")
        },
    }


ENERGIES: dict[str, Energy] = {
    **by_module(string, slack_string, l2t2, thin, thick),
    "thick_axis_consistent_gauss": thick("axis", "consistent"),
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


def hessian_times(energy: Energy, q, p, v, step=1e-3):
    """Derivative of the gradient along v: sixth-order differences of complex steps."""
    result = np.zeros(len(q), dtype=LONG)
    for k, weight in ((1, LONG(3) / 4), (2, -LONG(3) / 20), (3, LONG(1) / 60)):
        for sign in (1, -1):
            z = np.asarray(q, dtype=LONG) + sign * k * LONG(step) * v
            result += sign * weight * gradient(energy, z, p)
    return result / LONG(step)
