"""Energies of straight cables over a whole run, in NumPy, from positions and slopes of the nodes.

Nothing of the package computes here: shape functions, quadrature and strains are written again.
"""

import numpy as np


def gauss(n):
    points, weights = np.polynomial.legendre.leggauss(n)
    return zip((points + 1) / 2, weights / 2, strict=True)


def nodal(run, beam, table):
    """Return r and r' at both ends of every element, shape (states, elements, 4, dim)."""

    def read(place):
        columns = []
        for i in range(beam.n_nodes):
            where, weights = place(beam.node(i))
            columns.append(np.asarray(table[..., where]) @ weights)
        return np.stack(columns, axis=1)

    r, slope = read(run.system.point), read(run.system.slope)
    return np.stack([r[:, :-1], slope[:, :-1], r[:, 1:], slope[:, 1:]], axis=2)


def derivatives(x, length):
    first = [(6 * x * x - 6 * x) / length, 1 - 4 * x + 3 * x * x,
             (6 * x - 6 * x * x) / length, 3 * x * x - 2 * x]  # fmt: skip
    second = [(12 * x - 6) / length**2, (6 * x - 4) / length,
              (6 - 12 * x) / length**2, (6 * x - 2) / length]  # fmt: skip
    return np.array(first), np.array(second)


def cross_square(a, b):
    """|a x b|^2 = |a|^2 |b|^2 - (a b)^2, by components, which loses nothing."""
    if a.shape[-1] == 2:
        return (a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]) ** 2
    return (np.cross(a, b) ** 2).sum(axis=-1)


def energies(run, beam, gravity):
    """Return kinetic, elastic and potential energy of a cable at all saved times [J].

    Mass per length and stiffnesses come from the section and the material.  Stretching is exact
    for five points where the strain is quadratic; the package samples bending of "thin" at three.
    """
    section, material = beam.section, beam.material
    length = beam.length / beam.n_elements
    axial = material.youngs_modulus * section.area
    bending = material.youngs_modulus * section.inertia_z
    mass = material.density * section.area
    q, v = nodal(run, beam, run.q), nodal(run, beam, run.v)
    h = length
    consistent = mass * h * np.array([
        [13 / 35, 11 * h / 210, 9 / 70, -13 * h / 420],
        [11 * h / 210, h * h / 105, 13 * h / 420, -h * h / 140],
        [9 / 70, 13 * h / 420, 13 / 35, -11 * h / 210],
        [-13 * h / 420, -h * h / 140, -11 * h / 210, h * h / 105],
    ])  # fmt: skip
    kinetic = 0.5 * np.einsum("teid,ij,tejd->t", v, consistent, v)
    mean = np.array([0.5, h / 12, 0.5, -h / 12])
    potential = -mass * h * np.einsum("i,d,teid->t", mean, np.asarray(gravity), q)
    biot = beam.options.get("strain") == "biot"
    elastic = np.zeros(len(q))
    for x, weight in gauss(5):
        first, second = derivatives(x, h)
        along = np.einsum("i,teid->ted", first, q)
        square = (along**2).sum(axis=-1)
        strain = np.sqrt(square) - 1 if biot else 0.5 * (square - 1)
        elastic += 0.5 * axial * weight * h * (strain**2).sum(axis=1)
        if beam.element == "l2t2":
            bend = np.einsum("i,teid->ted", second, q)
            elastic += 0.5 * bending * weight * h * (bend**2).sum(axis=(1, 2))
    if beam.element == "thin":
        for x, weight in gauss(3):
            first, second = derivatives(x, h)
            along = np.einsum("i,teid->ted", first, q)
            square = (along**2).sum(axis=-1)
            bend = cross_square(along, np.einsum("i,teid->ted", second, q))
            curvature = bend / square ** (2 if biot else 3)
            elastic += 0.5 * bending * weight * h * curvature.sum(axis=1)
    return kinetic, elastic, potential


def of_box(path, body, gravity):
    """Return kinetic, elastic and potential energy of a rigid box at all saved times [J].

    Its mass at two Gauss points along each edge has the same second moments.
    """
    dim = len(gravity)
    edges = np.array([body.shape.length, body.shape.height, body.shape.width])[:dim]
    signs = np.stack(np.meshgrid(*[[-1.0, 1.0]] * dim), axis=-1).reshape(-1, dim)
    kinetic = potential = 0.0
    for place in signs * edges / np.sqrt(12.0):
        mass, point = body.mass / len(signs), body.at(place)
        kinetic += 0.5 * mass * (path.velocity(point) ** 2).sum(axis=1)
        potential -= mass * path.position(point) @ gravity
    return kinetic, 0.0 * kinetic, potential
