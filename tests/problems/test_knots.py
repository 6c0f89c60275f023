"""An overhand knot stays one while it tightens, and its tension tends to the law of loose knots."""

import math

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.problems import knot
from ancfsparse.problems.contacts import LOOP_RADIUS, ROD_RADIUS, RUBBER, SETTLING_TIME

BENDING_STIFFNESS = RUBBER.youngs_modulus * math.pi * ROD_RADIUS**4 / 4.0
DAMPED = ancf.GeneralizedAlpha(0.5)


def determinant(points):
    """Determinant of a knot whose ends are far away along x: 1 if it is none, of a trefoil 3."""
    one, way = points[:-1], np.diff(points, axis=0)
    crossings = []  # place along the curve that passes below, and the one above
    for i in range(len(one)):
        a, b = way[i, :2], way[i + 2 :, :2]
        gap = one[i + 2 :, :2] - one[i, :2]
        cross = a[0] * b[:, 1] - a[1] * b[:, 0]
        s = (gap[:, 0] * b[:, 1] - gap[:, 1] * b[:, 0]) / cross
        t = (gap[:, 0] * a[1] - gap[:, 1] * a[0]) / cross
        for k in np.flatnonzero((s >= 0.0) & (s < 1.0) & (t >= 0.0) & (t < 1.0)):
            j = i + 2 + k
            here, there = one[i, 2] + s[k] * way[i, 2], one[j, 2] + t[k] * way[j, 2]
            places = i + s[k], j + t[k]
            crossings.append(places if here < there else places[::-1])
    n, below = len(crossings), np.sort([each[0] for each in crossings])
    if n < 2:
        return 1
    rows = np.zeros((n, n))  # arcs from one passage below to the next; the last is the first
    for row, (under, over) in zip(rows, crossings, strict=True):
        k = int(np.searchsorted(below, under))
        for arc, value in ((k, -1), (k + 1, -1), (int(np.searchsorted(below, over)), 2)):
            row[arc % n] += value
    return round(abs(np.linalg.det(rows[1:, 1:])))


def axis(run, rod, row, n=300):
    return np.array([run.position(rod.at(s))[row] for s in np.linspace(0.0, rod.length, n)])


def test_the_determinant_tells_knots_from_loops():
    t = np.linspace(-2.3, 2.3, 400)
    trefoil = np.stack([t**3 - 3.0 * t, t**4 - 4.0 * t**2, t**5 - 10.0 * t], axis=1)
    assert determinant(trefoil) == 3
    loop = np.stack([t**3 - 3.0 * t, -(t**2), 0.1 * t], axis=1)
    assert determinant(loop) == 1


def test_the_rod_begins_knotted_and_does_not_touch():
    made = knot()
    start = ancf.simulate(made.scene, 2e-3, 2e-3, integrator=DAMPED)
    assert determinant(axis(start, made.bodies["rod"], 0)) == 3
    quantities = made.quantities(start)
    assert quantities["pressing"][0] == 0.0
    assert quantities["radius"][0] == pytest.approx(LOOP_RADIUS, rel=0.02)


@pytest.mark.slow
def test_a_knot_tightens_and_tends_to_the_law_of_loose_ones():
    """The law is that for eps towards zero; at .15 to .2 the braid adds up to as much again."""
    made = knot()
    run = ancf.simulate(made.scene, 12.0, 2e-3, integrator=DAMPED, save_every=100)
    quantities = made.quantities(run)
    rod = made.bodies["rod"]
    for row in range(0, len(run.t), 10):
        assert determinant(axis(run, rod, row)) == 3
    pulled = run.t > SETTLING_TIME + 3.0
    eps = np.sqrt(ROD_RADIUS / quantities["radius"][pulled])
    tension = quantities["tension"][pulled] * ROD_RADIUS**2 / BENDING_STIFFNESS
    ratio = tension / (0.5 * eps**4 + 0.492 * 0.1 * eps**3)
    assert np.all(np.diff(quantities["radius"][pulled]) < 0.0)
    assert 1.3 < ratio.min() < ratio.max() < 1.9
