"""States of one element in which kernels are examined."""

import numpy as np

AXIS = {"r_": 0, "r_x": 0, "r_y": 1, "r_z": 2}


def split(label):
    """Return the nodal vector and the direction of a coordinate: r_x2 -> (r_x, 1)."""
    return label[:-1], int(label[-1]) - 1


def straight(labels, length, start=0.0):
    """The undeformed element along the first direction."""
    q = []
    for place in (start, start + length):
        for label in labels:
            vector, axis = split(label)
            q.append(place * (axis == 0) if vector == "r_" else float(AXIS[vector] == axis))
    return np.array(q)


def nearly_straight(labels, length, rng):
    return straight(labels, length) + 1e-4 * length * rng.normal(size=2 * len(labels))


def uneven(labels, length, rng):
    """Stretched by half at one end, compressed at the other, bent and sheared a good deal."""
    q = straight(labels, length)
    for i, label in enumerate(labels * 2):
        if label.startswith("r_x"):
            q[i] *= 1.5 if i < len(labels) else 0.6
    return q + 0.2 * length * rng.uniform(-1, 1, size=len(q))


def random(labels, length, rng):
    """Far from anything: only kept away from r' = 0, where curvature is not defined."""
    return straight(labels, 1.5 * length) + 0.3 * rng.uniform(-1, 1, size=2 * len(labels))


STATES = {"nearly straight": nearly_straight, "uneven stretch": uneven, "random": random}


def rotation(labels, rng):
    """A rotation matrix (3, 3); about the third direction if the element lies in the plane."""
    if "r_3" in labels:
        matrix, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        return matrix * np.sign(np.linalg.det(matrix))
    c, s = np.cos(0.8), np.sin(0.8)
    return np.array([[c, -s, 0], [s, c, 0], [0, 0, 1.0]])


def rotate(q, labels, turn):
    """Turn every nodal vector of an element."""
    keys = [(end, *split(label)) for end in (0, 1) for label in labels]
    result = np.zeros_like(q)
    for i, (end, vector, axis) in enumerate(keys):
        for j, (other_end, other, direction) in enumerate(keys):
            if (end, vector) == (other_end, other):
                result[i] += turn[axis, direction] * q[j]
    return result
