"""The strains of the elements written a second time, for their rates and gradients.

U = 1/2 sum w s^2 with the energies of `reference_energies`.  Strains that are vectors in space are
given by components in a frame that turns with the tangent: along and across it in the plane; in
space, for a vector at right angles to the tangent, on two normals of the base state, which give
the right derivative there because the smallest rotation moves normals only along the tangent.
"""

from collections.abc import Callable, Mapping

import numpy as np

from tests.kernels.reference_energies import LONG, by_module, centre_line, dot, gauss, square

Parameters = Mapping[str, float]
Strains = Callable[[np.ndarray, Parameters, np.ndarray], tuple[np.ndarray, np.ndarray]]


def unit(u):
    return u / np.sqrt(square(u))[:, None]


def flat_cross(u, v):
    """Component of u x v out of the plane."""
    return u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]


def joined(length, pairs):
    """Weights and strains of all terms; shares of the length become weights."""
    weights = [length * np.asarray(w, dtype=LONG) for w, _ in pairs]
    return np.concatenate(weights), np.concatenate([s for _, s in pairs])


def string(q, p, base):
    length = LONG(p["length"])
    first, last = q.reshape(2, -1)
    stretch = np.sqrt(square(last - first)) / length - 1
    return joined(length, [(np.array([p["axial_stiffness"]]), np.array([stretch]))])


def slack_string(q, p, base):
    length, w = LONG(p["length"]), LONG(p["transition"])
    first, last = q.reshape(2, -1)
    stretch = np.sqrt(square(last - first) / length**2 + w**2) - 1
    stretch = (stretch + np.sqrt(stretch**2 + w**2)) / 2
    return joined(length, [(np.array([p["axial_stiffness"]]), np.array([stretch]))])


def l2t2(q, p, base):
    length = LONG(p["length"])
    xi, w = gauss(9)
    r_x, _ = centre_line(q.reshape(4, 2), xi, length)
    axial = (w * p["axial_stiffness"], (square(r_x) - 1) / 2)
    xi, w = gauss(3)
    r_x, r_xx = centre_line(q.reshape(4, 2), xi, length)
    t = unit(r_x)
    along, across = dot(t, r_xx), flat_cross(t, r_xx)
    stiff = w * p["bending_stiffness"]
    return joined(length, [axial, (stiff, along), (stiff, across)])


def normals(u):
    """Two unit vectors at right angles to each row and to each other."""
    u = unit(u)
    helper = np.eye(3)[np.argmin(np.abs(u.astype(float)), axis=1)]
    first = unit(np.cross(u, helper))
    return first, np.cross(u, first)


def thin(dim, strain):
    power = 3 if strain == "green" else 2

    def strains(q, p, base):
        length = LONG(p["length"])
        xi, w = gauss(5)
        r_x, _ = centre_line(q.reshape(4, dim), xi, length)
        stretch = (square(r_x) - 1) / 2 if strain == "green" else np.sqrt(square(r_x)) - 1
        pairs = [(w * p["axial_stiffness"], stretch)]
        xi, w = gauss(3)
        r_x, r_xx = centre_line(q.reshape(4, dim), xi, length)
        size, stiff = np.sqrt(square(r_x)) ** power, w * p["bending_stiffness"]
        if dim == 2:
            pairs.append((stiff, flat_cross(r_x, r_xx) / size))
        else:
            here, _ = centre_line(np.asarray(base, dtype=LONG).reshape(4, 3), xi, length)
            kappa = np.cross(r_x, r_xx) / size[:, None]
            pairs += [(stiff, dot(n, kappa)) for n in normals(here)]
        return joined(length, pairs)

    return strains


def thick(curvature, section_strain):
    def strains(q, p, base):
        nodes, length = q.reshape(2, 4, 3), LONG(p["length"])
        lam, shear, nu = p["lame_area"], p["shear_modulus_area"], p["poisson_ratio"]
        xi, w = gauss(6)
        r_x, r_xx = centre_line(np.concatenate([nodes[0, :2], nodes[1, :2]]), xi, length)
        r_y, r_z = (np.outer(1 - xi, nodes[0, k]) + np.outer(xi, nodes[1, k]) for k in (2, 3))
        r_yx, r_zx = ((nodes[1, k] - nodes[0, k]) / length for k in (2, 3))
        pairs = []
        if section_strain == "consistent":
            eps = [(square(u) - 1) / 2 for u in (r_x, r_y, r_z)]
            pairs += [(w * lam, sum(eps)), (w * shear, dot(r_y, r_z))]
            pairs += [(w * 2 * shear, e) for e in eps]
        else:
            pairs.append((w * p["youngs_modulus_area"], (square(r_x) - 1) / 2))
            half = np.array([0.5, 0.5])
            eps = (square(r_x) - 1) / 2
            e_y, e_z = ((square(nodes[:, k]) - 1) / 2 for k in (2, 3))
            e_x = w @ eps + 6 * (w @ ((xi - LONG(0.5)) * eps)) * np.array([-1, 1])
            a, b = e_y + nu * e_x, e_z + nu * e_x
            pairs += [(half * lam, a + b), (half * 2 * shear, a), (half * 2 * shear, b)]
            pairs.append((half * shear, dot(nodes[:, 2], nodes[:, 3])))
        for stiffness, u in ((p["shear_stiffness_y"], r_y), (p["shear_stiffness_z"], r_z)):
            gamma = dot(r_x, u)
            if curvature == "section":
                pairs.append((w * stiffness, gamma))
                continue
            modes = np.array([w @ gamma, 3 * (w @ ((2 * xi - 1) * gamma))])
            pairs.append((stiffness * np.array([1, LONG(1) / 3]), modes))
        if curvature == "axis":
            kap_y, kap_z = dot(r_z, r_xx), -dot(r_y, r_xx)
        else:
            kap_y, kap_z = -dot(r_x, r_zx), dot(r_x, r_yx)
        pairs.append((w * p["torsion_stiffness"], (dot(r_z, r_yx) - dot(r_y, r_zx)) / 2))
        pairs.append((w * p["bending_stiffness_y"], kap_y))
        pairs.append((w * p["bending_stiffness_z"], kap_z))
        if curvature == "section":
            pairs.append(change_of_section(p, nodes[0, 2:], nodes[1, 2:], length))
        return joined(length, pairs)

    return strains


def change_of_section(p, start, end, length):
    """Weights and means of r_y.r_yx, r_z.r_zx and (r_y.r_z)_x."""
    shear = np.array([p["bending_stiffness_z"], p["bending_stiffness_y"]], dtype=LONG)
    shear /= 2 * (1 + LONG(p["poisson_ratio"]))
    along, rate = (start + end) / 2, (end - start) / length
    crossed = dot(along[0], rate[1]) + dot(along[1], rate[0])
    return np.append(shear, shear.sum() / 4), np.append(dot(along, rate), crossed)


STRAINS: dict[str, Strains] = by_module(string, slack_string, l2t2, thin, thick)


def jacobian(strains: Strains, q, p, base=None):
    """Derivative of the strains by the coordinates, (n_strains, n), by complex steps."""
    step, base = LONG(1e-100), q if base is None else base
    columns = []
    for i in range(len(q)):
        z = np.asarray(q, dtype=np.clongdouble)
        z[i] += 1j * step
        columns.append(strains(z, p, base)[1].imag / step)
    return np.array(columns).T
