"""The planar thick beam with curvature of the section, solved without elements.

One polynomial of high degree for each field over the whole beam, the same energy by Gauss
quadrature and Newton's method: what the elements must tend to, with no line of theirs in it.
"""

import numpy as np

DEGREE = 18
R_X, R_Y, R_YX = (0, 1), (2, 3), (4, 5)
R_Z, R_ZX = (6,), (7,)


def product(a, b):
    """Symmetric matrix A with u.A.u / 2 = a.b."""
    out = np.zeros((8, 8))
    for i, j in zip(a, b, strict=True):
        out[i, j] += 1
        out[j, i] += 1
    return out


def strains(p):
    """Weight, matrix A and constant c of each strain u.A.u / 2 + c."""
    shear = 2 * (1 + p["poisson_ratio"])
    stretch = [(product(u, u) / 2, -0.5) for u in (R_X, R_Y, R_Z)]
    every = (sum(a for a, _ in stretch), sum(c for _, c in stretch))
    return [
        (p["lame_area"], *every),
        *((2 * p["shear_modulus_area"], a, c) for a, c in stretch),
        (p["shear_stiffness_y"], product(R_X, R_Y), 0.0),
        (p["bending_stiffness_z"], product(R_X, R_YX), 0.0),
        (p["bending_stiffness_z"] / shear, product(R_Y, R_YX), 0.0),
        (p["bending_stiffness_y"] / shear, product(R_Z, R_ZX), 0.0),
    ]


def tip(p, length, force=(0.0, 0.0), moment=0.0, steps=8):
    """Position of the free end of a cantilever whose wall holds r, r_y and r_z.

    Parameters
    ----------
    p : mapping
        Parameters of the section, as `Beam.parameters` gives them.
    length : float
        [m].
    force : (2,) float
        At the end, fixed in space [N].
    moment : float
        On the section at the end [N m].
    steps : int
        Load steps.

    Returns
    -------
    (2,) float
        [m].
    """
    x, w = np.polynomial.legendre.leggauss(2 * DEGREE + 8)
    s, w = length * (x + 1) / 2, w * length / 2
    n = DEGREE + 1
    value = np.polynomial.legendre.legvander(x, DEGREE)
    slope = np.array(
        [np.polynomial.legendre.legval(x, np.polynomial.legendre.legder(e)) for e in np.eye(n)]
    ).T * (2 / length)
    # r_x is a polynomial; r_y and r_z are their values at the wall and s times a polynomial.
    b = np.zeros((len(x), 8, 5 * n))
    u0 = np.zeros(8)
    u0[R_Y[1]] = u0[R_Z[0]] = 1.0
    for k in range(2):
        b[:, R_X[k], k * n : (k + 1) * n] = value
    for k, (row, rate) in enumerate(((R_Y[0], R_YX[0]), (R_Y[1], R_YX[1]), (R_Z[0], R_ZX[0])), 2):
        b[:, row, k * n : (k + 1) * n] = s[:, None] / length * value
        b[:, rate, k * n : (k + 1) * n] = (value + s[:, None] * slope) / length
    pull = np.zeros((2, 5 * n))  # the end's position: the integral of r_x
    for k in range(2):
        pull[k, k * n : (k + 1) * n] = w @ value
    end = np.zeros((2, 5 * n))  # r_y at the end, less that of the wall
    for k in range(2):
        end[k, (2 + k) * n : (3 + k) * n] = 1.0
    c = np.zeros(5 * n)
    c[0] = 1.0
    for share in np.linspace(0, 1, steps + 1)[1:]:
        for _ in range(30):
            u = b @ c + u0
            slopes, curves = np.zeros((len(x), 8)), np.zeros((len(x), 8, 8))
            for weight, a, constant in strains(p):
                au = u @ a
                strain = (u * au).sum(axis=1) / 2 + constant
                slopes += weight * strain[:, None] * au
                curves += weight * (au[:, :, None] * au[:, None] + strain[:, None, None] * a)
            gradient = np.tensordot(w[:, None] * slopes, b, 2) - share * np.asarray(force) @ pull
            half = np.matmul(w[:, None, None] * curves, b)
            hessian = np.tensordot(b, half, ((0, 1), (0, 1)))
            y = end @ c + [0.0, 1.0]
            turned = np.array([-y[1], y[0]]) / (y @ y)
            change = np.array([[0, -1], [1, 0]]) / (y @ y) - 2 * np.outer(turned, y) / (y @ y)
            gradient -= share * moment * turned @ end
            hessian -= share * moment * end.T @ change @ end
            step = np.linalg.solve(hessian, gradient)
            c -= step
            if np.abs(step).max() < 1e-12:
                break
        else:
            raise RuntimeError(f"no equilibrium at {share:.3g} of the load")
    return pull @ c
