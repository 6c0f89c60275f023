"""Squares of distances as terms of an equation."""

from __future__ import annotations

import numpy as np

from ancfsparse.scene.joints.joint import LINEAR, Coordinates, Vector

Term = tuple[float, int, int]


def squared(
    places: Coordinates, weights: Vector, anchor: Vector, factor: float
) -> tuple[list[Term], list[float]]:
    """Return the terms of ``factor |sum of w q - anchor|^2``, and what their places count from.

    Parameters
    ----------
    places : (dim, p) int
        Coordinates.
    weights : (p,) float
        Their weights; the first one is 1 where the anchor is not zero.
    anchor : (dim,) float
        Fixed point [m].
    factor : float
        Factor of the square [1/m].
    """
    terms: list[Term] = []
    about: list[float] = []
    for row, held in zip(places, np.asarray(anchor, dtype=float), strict=True):
        for a, (i, w) in enumerate(zip(row, weights, strict=True)):
            terms.append((factor * w * w, int(i), int(i)))
            about.append(float(held) if a == 0 else 0.0)
            for b in range(a):
                twice = 2.0 * factor * w * weights[b]
                terms.append((twice, int(i), int(row[b])))
                about.append(0.0)
                if b == 0 and held != 0.0:
                    terms.append((-twice * float(held), int(i), LINEAR))
                    about.append(0.0)
    return terms, about
