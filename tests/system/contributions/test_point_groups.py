"""Points with the same coordinates, against those of each point."""

import itertools

import numpy as np
import pytest

import ancfsparse as ancf
from ancfsparse.system import System
from ancfsparse.system.contributions.point_weights import PointSums


def sums_of(points):
    """Sums of the given coordinates, by direction the same plus 100."""
    start = np.cumsum([0, *map(len, points)], dtype=np.int32)
    place = np.concatenate(points).astype(np.int32)
    return PointSums(start, np.array([place, place + 100]), np.ones(len(place)))


@pytest.mark.parametrize("largest", [1, 2, 3])
def test_groups_have_the_coordinates_of_their_sums(largest, rng):
    points = [rng.integers(0, 2, size=rng.integers(1, 3)) for _ in range(200)]
    first, term, place, _ = sums_of(points).groups(largest, 102)
    assert first[0] == 0
    assert first[-1] == len(points)
    assert np.diff(first).max() == largest
    for g, (begin, end) in enumerate(itertools.pairwise(first)):
        rows = place[term[g] : term[g + 1]]
        for k in range(begin, end):
            assert np.array_equal(rows[:, 0], points[k])
            assert np.array_equal(rows[:, 1], points[k] + 100)
        full = end - begin == largest
        assert end == len(points) or full or not np.array_equal(points[end], points[begin])


def test_the_points_of_an_element_form_a_group():
    scene = ancf.Scene()
    steel = ancf.Material(1e9, 1e3)
    rod = scene.add_beam("thin", (0, 1), (1, 1), 7, ancf.Circle(0.01), steel)
    scene.pin(rod.start)
    scene.pin(rod.end)
    disc = scene.add_body(mass=1.0, inertia=1.0, position=(0.5, 0.5))
    scene.contact(rod, ancf.Drum((0.5, 0.5), 0.3), on=disc)
    system = System(scene)
    (contact,) = (each for each in system.contributions if hasattr(each, "contact"))
    assert np.array_equal(contact._points.groups(3, system.n_all)[0], np.arange(0, 22, 3))


def test_groups_that_are_alike_have_equal_numbers_and_places_at_equal_distances():
    scene = ancf.Scene((0, 0, -9.81))
    steel = ancf.Material(1e9, 1e3)
    for y, length, n in ((0, 1, 7), (1, 1, 7), (2, 2, 9)):
        rod = scene.add_beam("thin", (0, y, 0), (length, y, 0), n, ancf.Circle(0.01), steel)
        if y == 0:
            scene.pin(rod.start)
    scene.contact(scene.beams, ancf.HalfSpace((0, 0, -1), (0, 0, 1)))
    system = System(scene)
    (contact,) = (each for each in system.contributions if hasattr(each, "contact"))
    points = contact._points
    first, term, place, in_row = groups = points.groups(3, system.n_all)
    numbers = np.zeros(first[-1])
    numbers[3 * 14 + 1] = 1.0  # of one point of the fifteenth group, amid a rod
    alike = points.alike(groups, [numbers])
    assert in_row.sum() == np.sum(alike >= 0) == 34  # the pinned node has no coordinates
    places = place[term[:-1, None] + np.arange(4), 0]
    weights = points.weight[points.start[first[:-1]][:, None] + np.arange(12)]
    for g, a in enumerate(alike):
        if g > a >= 0:
            assert np.array_equal(places[g], places[a] + (g - a) * (places[a + 1] - places[a]))
            assert np.array_equal(weights[g], weights[a])
            assert not numbers[3 * a : 3 * g + 3].any()
    assert len(np.unique(alike)) < 25  # parts of divided elements differ
